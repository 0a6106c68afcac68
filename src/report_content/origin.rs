//! Origin of a report: the files of a campaign with hashes of their content.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use crate::campaign::Campaign;
use crate::report::{Input, Origin};

/// A file that cannot be read for its hash.
#[derive(Debug, thiserror::Error)]
#[error("{} cannot be read: {source}", .file.display())]
pub struct Unhashed {
    /// The file.
    pub file: PathBuf,
    /// Cause.
    pub source: std::io::Error,
}

/// The origin of a report of `campaign`: `command` is the given command, `seed` that of random
/// numbers.
///
/// # Errors
/// [`Unhashed`] for a file of the campaign that has disappeared since it was read.
pub fn origin(campaign: &Campaign, command: String, seed: Option<u64>) -> Result<Origin, Unhashed> {
    Ok(Origin {
        version: format!("hydrosysid {}", env!("CARGO_PKG_VERSION")),
        command,
        inputs: campaign.sources.iter().map(|path| input(path)).collect::<Result<_, _>>()?,
        seed,
    })
}

/// A file with the hash of its content.
fn input(path: &Path) -> Result<Input, Unhashed> {
    let hash = hash_of(path).map_err(|source| Unhashed { file: path.to_path_buf(), source })?;
    let sha256 = hash.iter().map(|b| format!("{b:02x}")).collect();
    Ok(Input { name: path.file_name().unwrap_or_default().to_string_lossy().into_owned(), sha256 })
}

/// The hash of a file, which is read piece by piece.
fn hash_of(path: &Path) -> std::io::Result<Vec<u8>> {
    let mut file = BufReader::with_capacity(1 << 20, File::open(path)?);
    let mut hash = Sha256::new();
    loop {
        let piece = file.fill_buf()?;
        if piece.is_empty() {
            return Ok(hash.finalize().to_vec());
        }
        hash.update(piece);
        let read = piece.len();
        file.consume(read);
    }
}
