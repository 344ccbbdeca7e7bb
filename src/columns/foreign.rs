//! Files that are something else, told by their first bytes.

/// What to do about a file that is packed, or that only stands for another.
pub fn hint_of_content(head: &[u8]) -> Option<&'static str> {
    match head {
        [0x1f, 0x8b, ..] => Some("is compressed (gzip): unpack it first"),
        [b'P', b'K', 3, 4, ..] => {
            Some("is a ZIP archive (or an office document): unpack or export it first")
        }
        [b'B', b'Z', b'h', b'1'..=b'9', ..] => Some("is compressed (bzip2): unpack it first"),
        [0xfd, b'7', b'z', b'X', b'Z', ..] => Some("is compressed (xz): unpack it first"),
        [0x28, 0xb5, 0x2f, 0xfd, ..] => Some("is compressed (zstd): unpack it first"),
        [b'7', b'z', 0xbc, 0xaf, ..] => Some("is a 7z archive: unpack it first"),
        [0xd0, 0xcf, 0x11, 0xe0, ..] => {
            Some("is an old office document (.xls): export the table as CSV first")
        }
        head if head.starts_with(b"version https://git-lfs") => {
            Some("is a pointer of Git LFS, not the file: run \"git lfs pull\" first")
        }
        head if head.starts_with(b"%PDF") => Some("is a PDF: export the table as CSV first"),
        _ => None,
    }
}
