//! Bytes of text: whatever the encoding, ASCII's letters and digits are themselves.

use encoding_rs::{EUC_KR, Encoding, GBK, SHIFT_JIS, UTF_16BE, UTF_16LE, WINDOWS_1252};

/// Encodings of names that are not UTF-8: CP949, CP1252 (Latin-1), CP932, CP936.
const OTHERS: [&Encoding; 4] = [EUC_KR, WINDOWS_1252, SHIFT_JIS, GBK];

/// The text without a mark of its encoding; UTF-16 becomes UTF-8. Anything else stays as it is.
pub(super) fn to_ascii_based(mut bytes: Vec<u8>) -> Vec<u8> {
    if bytes.starts_with(b"\xef\xbb\xbf") {
        bytes.drain(..3);
        return bytes;
    }
    match utf_16(&bytes) {
        Some(encoding) => encoding.decode_with_bom_removal(&bytes).0.into_owned().into_bytes(),
        None => bytes,
    }
}

/// By its mark, or because every second byte of the first ones is 0.
fn utf_16(bytes: &[u8]) -> Option<&'static Encoding> {
    let start = &bytes[..bytes.len().min(64)];
    let zeros = |odd: usize| {
        let mut places = start.iter().skip(odd).step_by(2);
        start.len() >= 8 && places.all(|&byte| byte == 0)
    };
    let others =
        |odd: usize| start.iter().skip(odd).step_by(2).all(|&byte| byte.is_ascii() && byte != 0);
    if start.starts_with(b"\xff\xfe") || (zeros(1) && others(0)) {
        Some(UTF_16LE)
    } else if start.starts_with(b"\xfe\xff") || (zeros(0) && others(1)) {
        Some(UTF_16BE)
    } else {
        None
    }
}

/// Whether a file's name is the one that a script asks for, in any encoding.
pub(super) fn is_same_name(name: &[u8], wanted: &[u8]) -> bool {
    name == wanted
        || (std::str::from_utf8(name).is_err()
            && OTHERS
                .into_iter()
                .any(|encoding| decoded(encoding, name).as_deref() == Some(wanted)))
}

fn decoded(encoding: &'static Encoding, name: &[u8]) -> Option<Vec<u8>> {
    let text = encoding.decode_without_bom_handling_and_without_replacement(name)?;
    Some(text.into_owned().into_bytes())
}

/// A name for people: UTF-8, else Korean if all that is not ASCII is Hangul, else Latin-1.
pub(super) fn readable(name: &[u8]) -> String {
    if let Ok(text) = std::str::from_utf8(name) {
        return text.to_owned();
    }
    let korean = EUC_KR.decode_without_bom_handling_and_without_replacement(name);
    let is_korean = |text: &str| text.chars().all(|c| c.is_ascii() || ('가'..='힣').contains(&c));
    match korean {
        Some(text) if is_korean(&text) => text.into_owned(),
        _ => WINDOWS_1252.decode_without_bom_handling(name).0.into_owned(),
    }
}
