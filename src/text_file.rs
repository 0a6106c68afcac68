//! Small files (campaigns, models, maps) as text, with a limit on their size in memory.
//!
//! A path may lead to an endless device or to a log of gigabytes.

use std::fs::File;
use std::io::{Error, ErrorKind, Read, Result};
use std::path::Path;

/// Maximum size of a file, bytes: the covariance of a thousand parameters as decimal text takes a
/// third of it.
const MOST: u64 = 64 << 20;

/// The bytes of the file at `path`.
///
/// # Errors
/// Those of the system, and an error for a file larger than 64 MiB.
pub(crate) fn read_bytes(path: &Path) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    File::open(path)?.take(MOST + 1).read_to_end(&mut bytes)?;
    match bytes.len() as u64 > MOST {
        true => Err(Error::new(ErrorKind::FileTooLarge, "larger than 64 MiB: this is no file of settings")),
        false => Ok(bytes),
    }
}

/// The text of the file at `path`.
///
/// # Errors
/// As [`read_bytes`], and bytes that are not UTF-8.
pub(crate) fn read(path: &Path) -> Result<String> {
    String::from_utf8(read_bytes(path)?).map_err(|_| Error::new(ErrorKind::InvalidData, "this is not UTF-8 text"))
}

/// Why a file cannot be read, in words: the system's error number does not help the user.
pub(crate) fn reason(error: &Error) -> String {
    match error.kind() {
        ErrorKind::NotFound => "there is no such file".into(),
        // errors of this program contain their own text
        ErrorKind::FileTooLarge | ErrorKind::InvalidData | ErrorKind::Other => error.to_string(),
        kind => Error::from(kind).to_string(),
    }
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    #[test]
    fn what_never_ends_is_refused() {
        assert_eq!(read_bytes(Path::new("/dev/zero")).unwrap_err().kind(), ErrorKind::FileTooLarge);
    }
}
