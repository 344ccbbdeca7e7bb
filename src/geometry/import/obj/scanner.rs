//! Words and numbers of a text, byte by byte.

use crate::geometry::DVec3;

/// Reads statements: a line, or several where a backslash continues it.
pub(in crate::geometry::import) struct Scanner<'a> {
    bytes: &'a [u8],
    at: usize,
}

/// 10⁰ to 10²², the powers that f64 holds exactly.
const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
    1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
];

/// Whole numbers up to here are exact in f64.
const EXACT: u64 = 1 << 53;

fn is_line_end(byte: u8) -> bool {
    byte == b'\n' || byte == b'\r'
}

impl<'a> Scanner<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    pub fn at(&self) -> usize {
        self.at
    }

    /// The next byte; a line's end at the end of the text.
    pub fn peek(&self) -> u8 {
        self.bytes.get(self.at).copied().unwrap_or(b'\n')
    }

    pub fn bump(&mut self) {
        self.at += 1;
    }

    /// Goes to the next statement; whether there is none.
    pub fn is_at_end(&mut self) -> bool {
        while let Some(&byte) = self.bytes.get(self.at) {
            if byte > b' ' {
                return false;
            }
            self.at += 1;
        }
        true
    }

    /// Goes to the next word of the statement; whether there is one.
    pub fn is_at_word(&mut self) -> bool {
        loop {
            match self.peek() {
                b'\n' | b'\r' | b'#' => return false,
                0..=b' ' => self.at += 1,
                b'\\' => match self.continued() {
                    Some(at) => self.at = at,
                    None => return true,
                },
                _ => return true,
            }
        }
    }

    /// Where the statement goes on, if a backslash here continues it.
    fn continued(&self) -> Option<usize> {
        let rest = &self.bytes[self.at + 1..];
        let blanks = rest.iter().take_while(|&&byte| byte == b' ' || byte == b'\t').count();
        let end = self.at + 1 + blanks;
        match rest.get(blanks..)? {
            [b'\r', b'\n', ..] => Some(end + 2),
            [b'\r' | b'\n', ..] => Some(end + 1),
            _ => None,
        }
    }

    /// The bytes up to the next blank, line's end or continuation.
    pub fn word(&mut self) -> &'a [u8] {
        let start = self.at;
        while self.peek() > b' ' && !(self.peek() == b'\\' && self.continued().is_some()) {
            self.at += 1;
        }
        &self.bytes[start..self.at]
    }

    /// The word that begins there.
    pub fn word_from(&mut self, start: usize) -> &'a [u8] {
        self.at = start;
        self.word()
    }

    pub fn is_at_end_of_text(&self) -> bool {
        self.at >= self.bytes.len()
    }

    /// Goes behind the end of the line, whatever it holds.
    pub fn skip_line(&mut self) {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let length = rest.iter().position(|&byte| is_line_end(byte)).unwrap_or(rest.len());
        let end = if rest[length..].starts_with(b"\r\n") { 2 } else { 1 };
        self.at += (length + end).min(rest.len());
    }

    /// What is left of the line, without blanks at its ends.
    pub fn rest_of_line(&mut self) -> &'a [u8] {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let length = rest.iter().position(|&byte| is_line_end(byte)).unwrap_or(rest.len());
        self.at += length;
        rest[..length].trim_ascii()
    }

    /// Three finite numbers. Errors: what is wrong, beginning with `what`.
    pub fn vector(&mut self, what: &str) -> std::result::Result<DVec3, String> {
        let mut numbers = [0.0; 3];
        for (count, number) in numbers.iter_mut().enumerate() {
            if !self.is_at_word() {
                return Err(format!("{what} has {count} numbers, expected x y z"));
            }
            let start = self.at;
            let value = self.number();
            match value {
                Some(value) if value.is_finite() => *number = value,
                Some(value) => return Err(format!("{what} has {value}, expected finite numbers")),
                None => {
                    self.at = start;
                    return Err(not_a_number(what, self.word()));
                }
            }
        }
        Ok(DVec3::from_array(numbers))
    }

    /// Number of the words that are left in the statement, and the first.
    pub fn count_words(&mut self) -> (usize, &'a [u8]) {
        let (mut count, mut first): (usize, &[u8]) = (0, &[]);
        while self.is_at_word() {
            let word = self.word();
            if count == 0 {
                first = word;
            }
            count += 1;
        }
        (count, first)
    }

    /// The next word as a number: exact, by way of the standard library where its digits do not fit.
    pub fn number(&mut self) -> Option<f64> {
        let start = self.at;
        let is_negative = self.sign();
        let (mut mantissa, mut digits, mut exponent) = (0u64, 0, 0i32);
        self.digits(&mut mantissa, &mut digits);
        if self.peek() == b'.' {
            self.bump();
            let whole = digits;
            self.digits(&mut mantissa, &mut digits);
            exponent = -(digits - whole);
        }
        if digits > 0 && matches!(self.peek(), b'e' | b'E') {
            self.bump();
            let is_below = self.sign();
            let (mut power, mut length) = (0u64, 0);
            self.digits(&mut power, &mut length);
            if length == 0 || length > 4 {
                return self.slow(start);
            }
            exponent += if is_below { -(power as i32) } else { power as i32 };
        }
        let is_exact = digits > 0 && digits < 19 && mantissa <= EXACT && exponent.abs() <= 22;
        if !is_exact || self.peek() > b' ' {
            return self.slow(start);
        }
        let power = POWERS[exponent.unsigned_abs() as usize];
        let value = if exponent < 0 { mantissa as f64 / power } else { mantissa as f64 * power };
        Some(if is_negative { -value } else { value })
    }

    fn slow(&mut self, start: usize) -> Option<f64> {
        self.at = start;
        std::str::from_utf8(self.word()).ok()?.parse().ok()
    }

    fn sign(&mut self) -> bool {
        let sign = self.peek();
        if sign == b'-' || sign == b'+' {
            self.bump();
        }
        sign == b'-'
    }

    fn digits(&mut self, value: &mut u64, count: &mut i32) {
        let start = self.at;
        loop {
            let digit = self.peek().wrapping_sub(b'0');
            if digit > 9 {
                break;
            }
            *value = value.wrapping_mul(10).wrapping_add(digit.into());
            self.at += 1;
        }
        *count = count.saturating_add((self.at - start).min(i32::MAX as usize) as i32);
    }

    /// A whole number; ends that are far outside of u32 are as good as any beyond it.
    pub fn index(&mut self) -> Option<i64> {
        let is_negative = self.sign();
        let (mut value, mut count) = (0, 0);
        self.digits(&mut value, &mut count);
        let value = if count > 18 { i64::MAX } else { value as i64 };
        (count > 0).then_some(if is_negative { -value } else { value })
    }
}

fn not_a_number(what: &str, word: &[u8]) -> String {
    let word = String::from_utf8_lossy(word);
    let has_comma = word.contains(',') && word.replace(',', ".").parse::<f64>().is_ok();
    let hint = if has_comma { " (with a decimal point, not a comma)" } else { "" };
    format!("{what} has \"{word}\", expected a number{hint}")
}

/// Number of the line that holds the byte, from 1; lines end with LF, CR LF or CR.
pub(in crate::geometry::import) fn line_of(bytes: &[u8], at: usize) -> u64 {
    let at = at.min(bytes.len());
    let is_lone = |k: &usize| bytes[*k] == b'\r' && bytes.get(k + 1) != Some(&b'\n');
    let ends = bytes[..at].iter().filter(|&&byte| byte == b'\n').count();
    let lone = (0..at).filter(is_lone).count();
    1 + (ends + lone) as u64
}
