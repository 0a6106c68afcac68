//! Atomic writing of files: a file is written under a temporary name beside its place, then
//! renamed.
//!
//! A symbolic link stays a link: its target file is replaced and keeps its permissions. A device or
//! a pipe is written to directly and never replaced by a file.

use std::ffi::OsString;
use std::fs::{self, File, OpenOptions};
use std::io::{BufWriter, Error, ErrorKind, Result, Write};
use std::path::{Path, PathBuf};

/// Maximum number of links that are followed to a file that does not exist yet, as in Linux.
const MOST_LINKS: usize = 40;

/// Writes the file at `path` with the content from `fill`; an existing file is replaced only after
/// all is written.
///
/// # Errors
/// Those of the system and of `fill`; then the temporary file is removed and the existing file
/// stays.
pub(crate) fn write(path: &Path, fill: impl FnOnce(&mut BufWriter<File>) -> Result<()>) -> Result<()> {
    let there = fs::metadata(path).ok();
    // opened by its own name: the link of a process to its pipe (/dev/stdout, a shell's >(…)) leads
    // to no path
    if there.as_ref().is_some_and(|there| !there.is_file()) {
        let mut file = BufWriter::new(OpenOptions::new().write(true).open(path)?);
        fill(&mut file)?;
        return file.flush();
    }
    let path = &destination(path)?;
    let mut name = OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    name.push(format!(".{}", std::process::id()));
    let beside = Beside(path.with_file_name(name));
    let mut file = BufWriter::new(File::create(&beside.0)?);
    fill(&mut file)?;
    file.flush()?;
    if let Some(there) = there {
        fs::set_permissions(&beside.0, there.permissions())?;
    }
    file.get_ref().sync_all()?;
    fs::rename(&beside.0, path)
}

/// A temporary file. It is removed if it does not get its final name, for example because the work
/// was stopped.
struct Beside(PathBuf);

impl Drop for Beside {
    fn drop(&mut self) {
        // after the rename there is no file to remove
        let _ = fs::remove_file(&self.0);
    }
}

/// The target of the links at `path`, whether the file exists or not.
fn destination(path: &Path) -> Result<PathBuf> {
    let mut path = path.to_path_buf();
    for _ in 0..MOST_LINKS {
        match fs::read_link(&path) {
            // an absolute target replaces the folder
            Ok(target) => path = path.parent().unwrap_or(Path::new("")).join(target),
            Err(_) => return Ok(path),
        }
    }
    Err(Error::new(ErrorKind::InvalidInput, "too many symbolic links"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn links_lead_to_the_file_that_is_written_and_permissions_stay() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = std::env::temp_dir().join(format!("hydrosysid_links_{}", std::process::id()));
        fs::create_dir_all(folder.join("elsewhere")).unwrap();
        let (link, file) = (folder.join("link"), folder.join("elsewhere/model.toml"));
        symlink("second", &link).unwrap();
        symlink("elsewhere/model.toml", folder.join("second")).unwrap();
        write(&link, |out| out.write_all(b"first")).unwrap();
        fs::set_permissions(&file, fs::Permissions::from_mode(0o640)).unwrap();
        write(&link, |out| out.write_all(b"second")).unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&file).unwrap(), b"second");
        assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o640);
        symlink("round", folder.join("round")).unwrap();
        assert!(write(&folder.join("round"), |_| Ok(())).is_err());
        fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn what_fails_half_way_leaves_what_was_there_and_nothing_else() {
        let folder = std::env::temp_dir().join(format!("hydrosysid_whole_{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let path = folder.join("model.toml");
        write(&path, |file| file.write_all(b"first")).unwrap();
        let half = write(&path, |file| {
            file.write_all(b"second, as far as")?;
            Err(Error::other("the disk is full"))
        });
        assert_eq!(half.unwrap_err().to_string(), "the disk is full");
        let stopped = std::panic::catch_unwind(|| {
            write(&path, |file| {
                file.write_all(b"second, until somebody")?;
                std::panic::resume_unwind(Box::new("stopped it"))
            })
        });
        assert!(stopped.is_err());
        assert_eq!(fs::read(&path).unwrap(), b"first");
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
        write(&path, |file| file.write_all(b"second")).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"second");
        fs::remove_dir_all(&folder).unwrap();
    }
}
