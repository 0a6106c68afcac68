//! What a file is, from its first bytes.

/// What the first bytes say.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Opening {
    /// Text, after this many bytes of byte order mark.
    Text(usize),
    /// Something else, by name: `UTF-16`, `gzip`.
    Other(&'static str),
}

/// Marks of files that are not CSV text. UTF-32 comes before UTF-16, whose mark it begins with.
const MARKS: [(&[u8], &str); 11] = [
    (b"\xff\xfe\0\0", "UTF-32"),
    (b"\0\0\xfe\xff", "UTF-32"),
    (b"\xff\xfe", "UTF-16"),
    (b"\xfe\xff", "UTF-16"),
    (b"\x1f\x8b", "gzip"),
    (b"PK\x03\x04", "zip"),
    (b"\x28\xb5\x2f\xfd", "zstd"),
    (b"\xfd7zXZ\0", "xz"),
    (b"BZh", "bzip2"),
    (b"\x89HDF\r\n\x1a\n", "HDF5"),
    (b"PAR1", "Parquet"),
];

/// Looks at the first bytes of a file.
pub fn opening(bytes: &[u8]) -> Opening {
    if bytes.starts_with(b"\xef\xbb\xbf") {
        return Opening::Text(3);
    }
    if let Some((_, name)) = MARKS.iter().find(|(mark, _)| bytes.starts_with(mark)) {
        return Opening::Other(name);
    }
    // ASCII in UTF-16 without a mark: every other byte is NUL.
    match bytes {
        [a, 0, b, 0, ..] | [0, a, 0, b, ..] if *a != 0 && *b != 0 => Opening::Other("UTF-16"),
        _ => Opening::Text(0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_known_by_their_first_bytes() {
        assert_eq!(opening(b"\xef\xbb\xbft,u"), Opening::Text(3));
        assert_eq!(opening(b"t,u"), Opening::Text(0));
        assert_eq!(opening(b""), Opening::Text(0));
        assert_eq!(opening(b"t\0,\0u\0"), Opening::Other("UTF-16"));
        assert_eq!(opening(b"\0t\0,"), Opening::Other("UTF-16"));
        assert_eq!(opening(b"\x1f\x8b\x08"), Opening::Other("gzip"));
        assert_eq!(opening(b"\xff\xfe\0\0t\0\0\0"), Opening::Other("UTF-32"));
    }
}
