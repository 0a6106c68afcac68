//! The verb `init`: chooses the place of the campaign, copies logs beside it, writes its text.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};

use super::answer;
use super::arguments as typed;
use super::failure::Failure;
use super::inputs;
use super::output::Output;
use super::table::wrapped;
use super::verbs::reading;
use crate::atomic_file;
use crate::campaign::{self, InitFacts, InitRequest, Learned};
use crate::wording::count;

/// The requested campaign file: a name without `.toml` is a folder.
fn campaign_file(output: &Path) -> PathBuf {
    let file = output.extension().is_some_and(|e| e == "toml") && !output.is_dir();
    if file { output.to_path_buf() } else { output.join("campaign.toml") }
}

pub(super) fn init(a: &typed::Init, output: &Output) -> Result<(), Failure> {
    // an existing file is a file; anything else may be a folder
    let to = |path: &Path| if path.is_file() { path.to_path_buf() } else { campaign_file(path) };
    let file = a.output.as_deref().map(to);
    // a campaign of an earlier call that could read no log may be replaced
    let is_void = file
        .as_deref()
        .and_then(|file| crate::text_file::read(file).ok())
        .is_some_and(|text| campaign::holds_no_run(&text));
    output.may_write(file.as_deref().filter(|_| !is_void))?;
    let folder = file.as_deref().and_then(Path::parent);
    let (mut logs, mut copies) = (Vec::new(), Vec::new());
    for path in &a.logs {
        inputs::is_a_file(path)?;
        let shown = match folder {
            None => path.display().to_string(),
            Some(folder) => inside(path, folder)?.unwrap_or_else(|| {
                let name = path.file_name().map_or_else(|| path.clone(), PathBuf::from).display().to_string();
                copies.push((path.clone(), name.clone()));
                name
            }),
        };
        logs.push((path.clone(), shown));
    }
    let request = InitRequest {
        logs,
        facts: InitFacts {
            name: a.name.clone().unwrap_or_default(),
            mass: a.mass,
            volume: a.volume,
            weight: a.weight,
            buoyancy: a.buoyancy,
            length: a.length,
        },
        vehicle: a.vehicle.clone(),
        options: reading(&a.reading)?,
        learned: a.learned.as_deref().map(learned).transpose()?.unwrap_or_default(),
    };
    let scaffold = output.working("reading logs", || campaign::init(&request))??;
    let warnings = scaffold.warnings();
    for warning in &warnings {
        output.remark(&format!("warning: {warning}"));
    }
    if output.strict && !warnings.is_empty() {
        return Err(Failure::Strict(warnings.len()));
    }
    let Some(file) = file.as_deref() else {
        if !output.json_on_stdout() {
            output.hand_over(&scaffold.text);
        }
        return output.json(
            &serde_json::json!({"format": 1, "file": null, "campaign": scaffold.text, "guesses": scaffold.guesses}),
        );
    };
    let folder = folder.unwrap_or(Path::new(""));
    if !folder.as_os_str().is_empty() {
        std::fs::create_dir_all(folder).map_err(|source| Failure::Write { file: folder.to_path_buf(), source })?;
    }
    for (from, to) in copies.iter().chain(&scaffold.companions) {
        copy(from, &folder.join(to))?;
    }
    match is_void {
        true => output.rewrite(file, scaffold.text.as_bytes())?,
        false => output.write(file, scaffold.text.as_bytes())?,
    }
    let place = if a.output.as_deref() == Some(file) { file } else { folder };
    let guesses = count(scaffold.guesses, "guess");
    output.print(&wrapped(&format!("{} written, with {guesses} to check (`# guessed:`)", file.display())));
    if !scaffold.left_out.is_empty() {
        output.print(&wrapped(&format!("left out of the model: {}", scaffold.left_out.join(", "))));
    }
    let is_unread = !request.logs.is_empty() && scaffold.unread.len() == request.logs.len();
    if is_unread {
        output.print(&wrapped(
            "no log could be read (see the warnings): the campaign has no run. Correct the logs or say how to read \
             them; the next init replaces the file",
        ));
    }
    output.json(
        &serde_json::json!({"format": 1, "file": file, "campaign": scaffold.text, "guesses": scaffold.guesses}),
    )?;
    // a campaign without a run cannot be checked; reading options may help
    match is_unread {
        true => answer::next("hydrosysid init --help", output),
        false => answer::next(&format!("hydrosysid check {}", place.display()), output),
    }
    Ok(())
}

/// The path of a log relative to `folder`; `None` if it is elsewhere.
fn inside(path: &Path, folder: &Path) -> Result<Option<String>, Failure> {
    let whole =
        |path: &Path| std::path::absolute(path).map_err(|source| Failure::Read { file: path.to_path_buf(), source });
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let (path, folder) = (whole(path)?, whole(folder)?);
    // the folder may be reached by another name
    let real = |p: &Path| p.canonicalize().unwrap_or_else(|_| p.to_path_buf());
    let found = path
        .strip_prefix(&folder)
        .map(Path::to_path_buf)
        .or_else(|_| real(&path).strip_prefix(real(&folder)).map(Path::to_path_buf));
    Ok(found.ok().map(|p| p.display().to_string()))
}

/// Copies a file; an existing one with the same content is left.
fn copy(from: &Path, to: &Path) -> Result<(), Failure> {
    let unread = |source| Failure::Read { file: from.to_path_buf(), source };
    let mut log = File::open(from).map_err(unread)?;
    match File::open(to) {
        Ok(there) if is_same(&log, &there).map_err(unread)? => Ok(()),
        Ok(_) => Err(Failure::Argument(format!(
            "{} already exists and is a different log from {}: rename one of them",
            to.display(),
            from.display()
        ))),
        Err(_) => atomic_file::write(to, |file| std::io::copy(&mut log, file).map(drop))
            .map_err(|source| Failure::Write { file: to.to_path_buf(), source }),
    }
}

/// Whether two files have the same content, compared piece by piece: a log may be larger than the
/// memory.
fn is_same(one: &File, other: &File) -> std::io::Result<bool> {
    if one.metadata()?.len() != other.metadata()?.len() {
        return Ok(false);
    }
    let (mut one, mut other) = (BufReader::new(one), BufReader::new(other));
    loop {
        let (a, b) = (one.fill_buf()?, other.fill_buf()?);
        let count = a.len().min(b.len());
        if count == 0 || a[..count] != b[..count] {
            return Ok(a.is_empty() && b.is_empty());
        }
        one.consume(count);
        other.consume(count);
    }
}

fn learned(path: &Path) -> Result<Learned, Failure> {
    let text = crate::text_file::read(path).map_err(|source| Failure::Read { file: path.to_path_buf(), source })?;
    toml::from_str(&text).map_err(|e| Failure::Argument(format!("{}: {}", path.display(), e.message())))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_the_same_to_the_last_byte() {
        let folder = std::env::temp_dir().join(format!("hydrosysid-same-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let written = |name: &str, bytes: &[u8]| {
            std::fs::write(folder.join(name), bytes).unwrap();
            File::open(folder.join(name)).unwrap()
        };
        let mut bytes = vec![7; 100_000];
        let one = written("one", &bytes);
        assert!(is_same(&one, &written("same", &bytes)).unwrap());
        let one = written("one", &bytes);
        assert!(!is_same(&one, &written("shorter", &bytes[1..])).unwrap());
        bytes[99_999] = 8;
        let one = File::open(folder.join("one")).unwrap();
        assert!(!is_same(&one, &written("other", &bytes)).unwrap());
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
