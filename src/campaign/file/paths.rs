//! Checks of run files: each must exist and lie in the campaign's folder.

use std::io::ErrorKind;
use std::path::{Component, Path, PathBuf};

use super::error::Problem;

/// Refuses a run file that does not exist, is no file, or lies outside the campaign's folder.
pub(super) fn check(folder: &Path, file: &str, allow_outside: bool) -> Result<(), Problem> {
    let path = folder.join(file);
    let outside = |path: PathBuf| Problem::OutsideFolder { path, folder: folder.to_path_buf() };
    // first by the text of the path alone, so that nothing outside is even accessed
    if !allow_outside && leaves(Path::new(file)) {
        return Err(outside(path));
    }
    let open = |path: &Path| {
        path.canonicalize().map_err(|error| match error.kind() {
            ErrorKind::NotFound | ErrorKind::NotADirectory => Problem::MissingFile { path: path.to_path_buf() },
            kind => Problem::UnreadableFile { path: path.to_path_buf(), kind },
        })
    };
    // then by the targets of links: `a/../..` through a link leads elsewhere than its text says
    let real = open(&path)?;
    if !allow_outside && !real.starts_with(open(folder)?) {
        return Err(outside(real));
    }
    if real.is_file() { Ok(()) } else { Err(Problem::NotAFile { path }) }
}

/// Whether the text of a relative path leads out of its start folder; an absolute path does.
fn leaves(path: &Path) -> bool {
    let mut depth = 0_usize;
    for component in path.components() {
        match component {
            Component::Normal(_) => depth += 1,
            Component::CurDir => {}
            Component::ParentDir if depth > 0 => depth -= 1,
            _ => return true,
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_that_lead_out_are_known_by_their_letters() {
        for out in ["../a.csv", "logs/../../a.csv", "/a.csv", ".."] {
            assert!(leaves(Path::new(out)), "{out}");
        }
        for within in ["a.csv", "./a.csv", "logs/a.csv", "logs/../a.csv", "..a.csv"] {
            assert!(!leaves(Path::new(within)), "{within}");
        }
    }
}
