//! Reference data that does not live in the repository.

use std::path::PathBuf;

/// The reference data of this name, `None` where it is not at hand: the test then says on standard error that it was
/// skipped, whether its output is captured or not.
///
/// The folder is `HYDROSYSID_SHARED`, else `shared` beside the repository.
///
/// # Panics
/// Where `CI` is `true`: there the data is at hand, and a test that is skipped holds nothing.
pub fn path(name: &str) -> Option<PathBuf> {
    let root = std::env::var_os("HYDROSYSID_SHARED")
        .map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared"), PathBuf::from);
    let path = root.join(name);
    if path.exists() {
        return Some(path);
    }
    let test = std::thread::current().name().unwrap_or("a test").to_string();
    let text = format!("{test}: skipped, no reference data at {} (HYDROSYSID_SHARED names its folder)", path.display());
    assert!(std::env::var_os("CI").is_none_or(|ci| ci != "true"), "{text}");
    // not by `eprintln!`, which the test harness keeps to itself where a test passes
    let _ = std::io::Write::write_all(&mut std::io::stderr(), format!("{text}\n").as_bytes());
    None
}
