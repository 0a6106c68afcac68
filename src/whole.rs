//! A file is there whole or not at all: it is written beside its place first, then put under its name.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::Path;

/// Makes the file at `path` of what `fill` writes; what was there is replaced when all of it is written, not before.
///
/// # Errors
/// Those of the system and of `fill`; then nothing is left, and what was there stays.
pub(crate) fn write(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<File>) -> std::io::Result<()>,
) -> std::io::Result<()> {
    let mut name = OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    name.push(format!(".{}", std::process::id()));
    let beside = path.with_file_name(name);
    let written = File::create(&beside).map(BufWriter::new).and_then(|mut file| {
        fill(&mut file)?;
        file.flush()?;
        file.get_ref().sync_all()?;
        fs::rename(&beside, path)
    });
    written.inspect_err(|_| {
        // what is left of it is of no use to anybody
        let _ = fs::remove_file(&beside);
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_fails_half_way_leaves_what_was_there_and_nothing_else() {
        let folder = std::env::temp_dir().join(format!("hydrosysid_whole_{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let path = folder.join("model.toml");
        write(&path, |file| file.write_all(b"first")).unwrap();
        let half = write(&path, |file| {
            file.write_all(b"second, as far as")?;
            Err(std::io::Error::other("the disk is full"))
        });
        assert_eq!(half.unwrap_err().to_string(), "the disk is full");
        assert_eq!(fs::read(&path).unwrap(), b"first");
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
        write(&path, |file| file.write_all(b"second")).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"second");
        fs::remove_dir_all(&folder).unwrap();
    }
}
