//! What a compiled Lua function does, apart from where in its file it stands.

use mlua::Function;

/// A function's instructions and constants, and those of the functions within it.
pub(super) struct Code {
    /// Two functions that do the same have the same.
    pub bytes: Vec<u8>,
    /// Names and texts that it mentions; among them are the globals that it uses.
    pub texts: Vec<Vec<u8>>,
}

/// Before the first function: signature, version, format, check bytes, sizes, two numbers, and how
/// many upvalues there are.
const HEADER: usize = 4 + 1 + 1 + 6 + 3 + 8 + 8 + 1;

impl Code {
    /// `None` for a function that is not Lua's.
    pub fn of(function: &Function) -> Option<Self> {
        let dumped = function.dump(true);
        let mut reader = BytecodeReader { rest: dumped.get(HEADER..)? };
        let mut code = Self { bytes: Vec::with_capacity(dumped.len()), texts: Vec::new() };
        code.add_function(&mut reader, false)?;
        reader.rest.is_empty().then_some(code)
    }

    /// Lua 5.4's order (ldump.c): source, lines, parameters, instructions, constants, upvalues,
    /// functions, and what helps debuggers, of which nothing is left.
    fn add_function(&mut self, reader: &mut BytecodeReader, is_inner: bool) -> Option<()> {
        reader.text()?;
        let _first_and_last_line = (reader.count()?, reader.count()?);
        self.bytes.extend(reader.take(3)?);
        let instructions = reader.count()?;
        self.bytes.extend(reader.take(4 * instructions)?);
        for _ in 0..reader.count()? {
            self.add_constant(reader)?;
        }
        let upvalues = reader.count()?;
        let places = reader.take(3 * upvalues)?;
        if is_inner {
            self.bytes.extend(places); // the outer one has its upvalues' values already
        }
        for _ in 0..reader.count()? {
            self.add_function(reader, true)?;
        }
        let debug = [reader.count()?, reader.count()?, reader.count()?, reader.count()?];
        (debug == [0; 4]).then_some(())
    }

    /// Kind, and value if the kind has more than one.
    fn add_constant(&mut self, reader: &mut BytecodeReader) -> Option<()> {
        let kind = reader.take(1)?[0];
        self.bytes.push(kind);
        match kind {
            0 | 1 | 17 => {}
            3 | 19 => self.bytes.extend(reader.take(8)?),
            4 | 20 => {
                let text = reader.text()?;
                self.bytes.extend((text.len() as u64).to_le_bytes());
                self.bytes.extend(text);
                self.texts.push(text.to_vec());
            }
            _ => return None,
        }
        Some(())
    }
}

struct BytecodeReader<'a> {
    rest: &'a [u8],
}

impl<'a> BytecodeReader<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.rest.split_at_checked(count)?;
        self.rest = rest;
        Some(taken)
    }

    /// Seven bits a byte, the highest first; the last byte is marked.
    fn count(&mut self) -> Option<usize> {
        let mut count = 0usize;
        loop {
            let byte = self.take(1)?[0];
            count = count.checked_shl(7)? | usize::from(byte & 0x7f);
            if byte & 0x80 != 0 {
                return Some(count);
            }
        }
    }

    /// Its length and one more stand before it; 0 stands for none.
    fn text(&mut self) -> Option<&'a [u8]> {
        let length = self.count()?;
        self.take(length.saturating_sub(1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn code(source: &str) -> Code {
        let lua = mlua::Lua::new();
        let function: Function = lua.load(source).eval().unwrap();
        Code::of(&function).unwrap()
    }

    #[test]
    fn lines_and_comments_do_not_count() {
        let plain = "local k = 2 return function(x) return function() return k * x end end";
        let moved = plain.replace("return function(x)", "\n\n-- moved\nreturn function(x)");
        assert_eq!(code(plain).bytes, code(&moved).bytes);
    }

    #[test]
    fn instructions_constants_and_inner_functions_count() {
        let base = "return function(x) return function() return x + 2, \"a\" end end";
        for (from, to) in [("x + 2", "x - 2"), ("2", "3"), ("2", "2.0"), ("\"a\"", "\"b\"")] {
            assert_ne!(code(base).bytes, code(&base.replace(from, to)).bytes, "{to}");
        }
    }

    #[test]
    fn mentions_globals() {
        let texts = code("return function() return math.random(3) end").texts;
        assert_eq!(texts, [b"math".to_vec(), b"random".to_vec()]);
    }
}
