//! Reference data that is not in the repository.

use std::path::PathBuf;

/// Path of the reference data of this name. `None` if it is not available; the test then reports on
/// standard error that it was skipped, even if its output is captured.
///
/// The folder is `HYDROSYSID_SHARED`, else `shared` beside the repository.
///
/// # Panics
/// If the data is not available and `CI` is `true`, so that no test is skipped there.
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
    // not by `eprintln!`, whose output the test harness hides if a test passes
    let _ = std::io::Write::write_all(&mut std::io::stderr(), format!("{text}\n").as_bytes());
    None
}
