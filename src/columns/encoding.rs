//! From bytes to text: what a file's marks and its content say about its encoding.

use std::fmt;

use encoding_rs::{EUC_KR, UTF_16BE, UTF_16LE, WINDOWS_1252};

/// How the text of a file is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Encoding {
    /// With or without its mark.
    Utf8,
    /// Little-endian.
    Utf16Le,
    /// Big-endian.
    Utf16Be,
    /// Korean Windows: EUC-KR and more syllables.
    Cp949,
    /// Western Windows, of which Latin-1 is a part.
    Latin1,
}

impl fmt::Display for Encoding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Utf8 => "UTF-8",
            Self::Utf16Le => "UTF-16, little-endian",
            Self::Utf16Be => "UTF-16, big-endian",
            Self::Cp949 => "CP949 (Korean)",
            Self::Latin1 => "Latin-1",
        })
    }
}

/// The text of `bytes`, and how it was stored.
///
/// Errors: the 1-based line with a control character, which no table has: the file is binary.
pub(super) fn decode(bytes: Vec<u8>) -> Result<(String, Encoding), u64> {
    let (text, encoding) = match of_mark(&bytes) {
        Some(Encoding::Utf8) | None => match String::from_utf8(bytes) {
            Ok(text) => (text, Encoding::Utf8),
            Err(error) => of_code_page(&error.into_bytes()),
        },
        Some(encoding) => (with(encoding, &bytes), encoding),
    };
    let text = match text.strip_prefix('\u{feff}') {
        Some(rest) => rest.to_owned(),
        None => text,
    };
    let is_control = |c: char| c.is_control() && !matches!(c, '\t' | '\n' | '\r' | '\x0c' | '\x1a');
    match text.find(|c| is_control(c) || c == '\u{fffd}') {
        None => Ok((text, encoding)),
        Some(at) => Err(1 + text[..at].bytes().filter(|&b| b == b'\n').count() as u64),
    }
}

/// What the first bytes say, or the place of the zeros that ASCII has in UTF-16.
fn of_mark(bytes: &[u8]) -> Option<Encoding> {
    match bytes {
        [0xef, 0xbb, 0xbf, ..] => return Some(Encoding::Utf8),
        [0xff, 0xfe, ..] => return Some(Encoding::Utf16Le),
        [0xfe, 0xff, ..] => return Some(Encoding::Utf16Be),
        _ => {}
    }
    let (pairs, _) = bytes[..bytes.len().min(256)].as_chunks::<2>();
    let zeros = |at: usize| pairs.iter().filter(|pair| pair[at] == 0).count();
    match [zeros(0), zeros(1)].map(|count| 2 * count > pairs.len()) {
        [false, true] => Some(Encoding::Utf16Le),
        [true, false] => Some(Encoding::Utf16Be),
        _ => None,
    }
}

/// Bytes that are not UTF-8.
fn of_code_page(bytes: &[u8]) -> (String, Encoding) {
    let encoding = if is_korean(bytes) { Encoding::Cp949 } else { Encoding::Latin1 };
    (with(encoding, bytes), encoding)
}

fn with(encoding: Encoding, bytes: &[u8]) -> String {
    let table = match encoding {
        Encoding::Utf16Le => UTF_16LE,
        Encoding::Utf16Be => UTF_16BE,
        Encoding::Cp949 => EUC_KR,
        Encoding::Utf8 | Encoding::Latin1 => WINDOWS_1252,
    };
    table.decode_with_bom_removal(bytes).0.into_owned()
}

/// Whether the bytes above ASCII come in pairs, half of which at least are Hangul syllables.
///
/// Every pair of Korean is text of Latin-1 too, and some of Latin-1, such as "öß" and "µm", is
/// Korean, but no Hangul of the standard's table.
fn is_korean(bytes: &[u8]) -> bool {
    let runs = bytes.split(u8::is_ascii).filter(|run| !run.is_empty());
    let (mut pairs, mut syllables) = (0, 0);
    for run in runs {
        let (whole, rest) = run.as_chunks::<2>();
        if !rest.is_empty() {
            return false;
        }
        pairs += whole.len();
        syllables += whole.iter().filter(|pair| (0xb0..=0xc8).contains(&pair[0])).count();
    }
    2 * syllables >= pairs && !EUC_KR.decode_without_bom_handling(bytes).1
}

#[cfg(test)]
mod tests {
    use super::*;

    fn utf16(text: &str, of: fn(u16) -> [u8; 2]) -> Vec<u8> {
        text.encode_utf16().flat_map(of).collect()
    }

    #[test]
    fn encodings_are_told_by_mark_and_content() {
        let text = "380;0,5\n";
        let marked = format!("\u{feff}{text}");
        for (bytes, encoding) in [
            (text.as_bytes().to_vec(), Encoding::Utf8),
            (marked.clone().into_bytes(), Encoding::Utf8),
            (utf16(&marked, u16::to_le_bytes), Encoding::Utf16Le),
            (utf16(&marked, u16::to_be_bytes), Encoding::Utf16Be),
            (utf16(text, u16::to_le_bytes), Encoding::Utf16Le),
            (utf16(text, u16::to_be_bytes), Encoding::Utf16Be),
        ] {
            assert_eq!(decode(bytes), Ok((text.to_owned(), encoding)));
        }
    }

    #[test]
    fn code_pages_are_told_by_their_pairs() {
        for (bytes, text, encoding) in [
            (&b"\xc6\xc4\xc0\xe5(nm)"[..], "파장(nm)", Encoding::Cp949),
            (b"Wellenl\xe4nge [nm]", "Wellenlänge [nm]", Encoding::Latin1),
            (b"lambda (\xb5m)", "lambda (µm)", Encoding::Latin1),
            (b"Gr\xf6\xdfe", "Größe", Encoding::Latin1),
            (b"\xc5", "Å", Encoding::Latin1),
        ] {
            assert_eq!(decode(bytes.to_vec()), Ok((text.to_owned(), encoding)));
        }
    }

    #[test]
    fn binary_files_are_told_by_line() {
        assert_eq!(decode(b"a\nb\n\x00\x01".to_vec()), Err(3));
        assert_eq!(decode(vec![0xff, 0xfe, 0x00, 0xd8]), Err(1));
    }
}
