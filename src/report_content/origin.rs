//! Where a report comes from: the files of a campaign with the hashes of what is in them.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use crate::campaign::Campaign;
use crate::report::{Input, Origin};

/// A file that cannot be read to be hashed.
#[derive(Debug, thiserror::Error)]
#[error("{} cannot be read: {source}", .file.display())]
pub struct Unhashed {
    /// The file.
    pub file: PathBuf,
    /// Why.
    pub source: std::io::Error,
}

/// The origin of a report of `campaign`: `command` is what was given, `seed` that of anything random.
///
/// # Errors
/// [`Unhashed`] for a file of the campaign that is gone since it was read.
pub fn origin(campaign: &Campaign, command: String, seed: Option<u64>) -> Result<Origin, Unhashed> {
    Ok(Origin {
        version: format!("hydrosysid {}", env!("CARGO_PKG_VERSION")),
        command,
        inputs: campaign.sources.iter().map(|path| input(path)).collect::<Result<_, _>>()?,
        seed,
    })
}

/// A file with the hash of what is in it.
fn input(path: &Path) -> Result<Input, Unhashed> {
    let hash = hash_of(path).map_err(|source| Unhashed { file: path.to_path_buf(), source })?;
    let sha256 = hash.iter().map(|b| format!("{b:02x}")).collect();
    Ok(Input { name: path.file_name().unwrap_or_default().to_string_lossy().into_owned(), sha256 })
}

/// The hash of a file, of which one piece at a time is in memory.
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
