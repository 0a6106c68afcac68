//! Reference data that does not live in the repository.

use std::path::PathBuf;

/// The reference data of this name, `None` (said on standard output) where it is not at hand.
///
/// The folder is `HYDROSYSID_SHARED`, else `shared` beside the repository.
pub fn path(name: &str) -> Option<PathBuf> {
    let root = std::env::var_os("HYDROSYSID_SHARED")
        .map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared"), PathBuf::from);
    let path = root.join(name);
    if path.exists() {
        return Some(path);
    }
    println!("skipped: no reference data at {}", path.display());
    None
}
