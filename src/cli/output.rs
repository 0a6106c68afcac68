//! Output of results: standard output, files written completely or not at all, and progress on a
//! terminal.

use std::cell::RefCell;
use std::io::{ErrorKind, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use anstream::ColorChoice;
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;

use super::arguments::Shared;
use super::failure::Failure;
use super::inputs;
use crate::atomic_file;
use crate::finding::{Finding, Severity};
use crate::progress::{Watch, is_watched, watched};

/// The words of a call without the options of colour, tables, silence and threads, which concern
/// only the user who typed it.
fn asked(words: &[String]) -> impl Iterator<Item = &String> {
    let presentational = |word: &str| match word.strip_prefix("--") {
        Some(long) => matches!(long, "no-color" | "verbose" | "quiet") || long.starts_with("jobs"),
        // `-v`, `-vj2`; a negative number is no option
        None => word.strip_prefix('-').is_some_and(|short| short.starts_with(['v', 'q', 'j'])),
    };
    // `-j 2`: the number is a separate word
    let takes_next = |word: &str| word == "--jobs" || (!word.starts_with("--") && word.ends_with('j'));
    let follows = move |k: usize| k > 0 && presentational(&words[k - 1]) && takes_next(&words[k - 1]);
    (0..words.len()).filter(move |k| !presentational(&words[*k]) && !follows(*k)).map(|k| &words[k])
}

/// The outputs of one call.
pub(super) struct Output {
    json: Option<PathBuf>,
    pub strict: bool,
    force: bool,
    quiet: bool,
    /// Files that the call reads.
    inputs: Vec<PathBuf>,
    /// The error if standard output did not take everything.
    lost: RefCell<Option<std::io::Error>>,
    verbose: bool,
    /// The call as it was typed.
    typed: Vec<String>,
}

impl Output {
    pub fn new(shared: &Shared, inputs: Vec<PathBuf>, typed: Vec<String>) -> Output {
        if shared.no_color {
            ColorChoice::Never.write_global();
        }
        let Shared { strict, force, quiet, verbose, .. } = *shared;
        Output { json: shared.json.clone(), strict, force, quiet, verbose, inputs, lost: RefCell::default(), typed }
    }

    /// The call as it was typed, without options of presentation and threads, with quotes where a
    /// shell needs them.
    pub fn typed(&self) -> String {
        let plain = |c: char| c.is_alphanumeric() || "-_./=%+,:@".contains(c);
        let quoted = |word: &String| match !word.is_empty() && word.chars().all(plain) {
            true => word.clone(),
            false => format!("'{}'", word.replace('\'', "'\\''")),
        };
        std::iter::once("hydrosysid".to_string())
            .chain(asked(self.typed.get(1..).unwrap_or_default()).map(quoted))
            .collect::<Vec<_>>()
            .join(" ")
    }

    /// Whether JSON goes to standard output.
    pub fn json_on_stdout(&self) -> bool {
        self.json.as_deref() == Some(Path::new("-"))
    }

    /// Prints text for people on standard output.
    pub fn print(&self, text: &str) {
        if !self.quiet && !self.json_on_stdout() {
            self.keep(writeln!(anstream::stdout(), "{text}"));
        }
    }

    /// Stores the error of a write to standard output, such as a full disk. A reader that closed
    /// the pipe is no error.
    fn keep(&self, written: std::io::Result<()>) {
        if let Err(error) = written
            && error.kind() != ErrorKind::BrokenPipe
        {
            self.lost.borrow_mut().get_or_insert(error);
        }
    }

    /// Returns an error if standard output did not take everything.
    pub fn finish(&self) -> Result<(), Failure> {
        self.keep(anstream::stdout().flush());
        let failed = |source| Failure::Write { file: "standard output".into(), source };
        self.lost.take().map_or(Ok(()), |source| Err(failed(source)))
    }

    /// Whether the long tables are wanted.
    pub fn is_verbose(&self) -> bool {
        self.verbose
    }

    /// Whether an output file is standard output: then only the file is written there.
    pub fn is_stdout(path: &Path) -> bool {
        ["-", "/dev/stdout"].iter().any(|name| path == Path::new(name))
    }

    /// Prints the requested result on standard output, even with `--quiet`.
    pub fn hand_over(&self, text: &str) {
        self.keep(write!(anstream::stdout(), "{text}"));
    }

    /// A remark on standard error.
    pub fn remark(&self, text: &str) {
        if !self.quiet {
            let _ = writeln!(anstream::stderr(), "{text}");
        }
    }

    /// Prints an error on standard error, even with `--quiet`.
    pub fn complain(&self, text: &str) {
        let _ = writeln!(anstream::stderr(), "{text}");
    }

    /// Refuses, before any work, outputs that must not be replaced.
    pub fn may_write(&self, path: Option<&Path>) -> Result<(), Failure> {
        let json = self.json.as_deref().filter(|_| !self.json_on_stdout());
        [path, json].into_iter().flatten().try_for_each(|path| self.may_replace(path))
    }

    /// Refuses to replace a file without `--force`, and an input of the call in any case.
    fn may_replace(&self, path: &Path) -> Result<(), Failure> {
        if inputs::hold(&self.inputs, path) {
            return Err(Failure::Input(path.to_path_buf()));
        }
        // writing to a device or a pipe replaces nothing
        match !self.force && (path.is_file() || path.is_dir()) {
            true => Err(Failure::Exists(path.to_path_buf())),
            false => Ok(()),
        }
    }

    /// Writes the requested JSON.
    pub fn json<T: Serialize>(&self, result: &T) -> Result<(), Failure> {
        let Some(path) = &self.json else { return Ok(()) };
        let text = serde_json::to_string_pretty(result)
            .map_err(|e| Failure::Write { file: path.clone(), source: std::io::Error::other(e) })?;
        if self.json_on_stdout() {
            self.hand_over(&(text + "\n"));
            return Ok(());
        }
        self.write(path, (text + "\n").as_bytes())
    }

    /// Writes a file completely or not at all; replaces an existing one only with `--force`.
    pub fn write(&self, path: &Path, bytes: &[u8]) -> Result<(), Failure> {
        self.may_replace(path)?;
        self.rewrite(path, bytes)
    }

    /// Writes a file completely, over an existing one without content worth keeping.
    pub fn rewrite(&self, path: &Path, bytes: &[u8]) -> Result<(), Failure> {
        if inputs::hold(&self.inputs, path) {
            return Err(Failure::Input(path.to_path_buf()));
        }
        let failed = |source| Failure::Write { file: path.to_path_buf(), source };
        atomic_file::write(path, |file| file.write_all(bytes)).map_err(failed)
    }

    /// A spinner that turns until it is dropped, if standard error is a terminal.
    pub fn busy(&self, what: &str) -> ProgressBar {
        if self.quiet || !std::io::stderr().is_terminal() {
            return ProgressBar::hidden();
        }
        let bar = ProgressBar::new_spinner().with_message(what.to_string());
        if let Ok(style) = ProgressStyle::with_template("{spinner} {msg} ({elapsed})") {
            bar.set_style(style);
        }
        bar.enable_steady_tick(Duration::from_millis(120));
        bar
    }

    /// Does `work`, which may report its own progress; shown if standard error is a terminal,
    /// unless the caller of the command already watches it.
    pub fn working<R: Send>(&self, what: &str, work: impl FnOnce() -> R + Send) -> Result<R, Failure> {
        if is_watched() {
            return Ok(work());
        }
        let busy = self.busy(what);
        let shown = busy.clone();
        let watch = Watch::new(move |step| {
            let part = match (step.done, step.of) {
                (0, 0) => String::new(),
                (done, 0) => format!(" {done}"),
                (done, of) => format!(" {done}/{of}"),
            };
            shown.set_message(step.what + &part);
        });
        let done = watched(&watch, work);
        busy.finish_and_clear();
        Ok(done?)
    }

    /// A progress bar that counts to `total`, if standard error is a terminal.
    pub fn counted(&self, what: &str, total: usize) -> ProgressBar {
        if self.quiet || !std::io::stderr().is_terminal() {
            return ProgressBar::hidden();
        }
        let bar = ProgressBar::new(total as u64).with_message(what.to_string());
        if let Ok(style) = ProgressStyle::with_template("{msg} {bar:30} {pos}/{len} ({eta})") {
            bar.set_style(style);
        }
        bar
    }

    /// Prints findings, one of each kind with its places; returns an error for warnings with
    /// `--strict`.
    pub fn tell(&self, findings: &[Finding]) -> Result<(), Failure> {
        for told in super::message::grouped(findings, self.verbose) {
            self.remark(&told);
        }
        let warnings = findings.iter().filter(|f| f.severity == Severity::Warning).count();
        if self.strict && warnings > 0 { Err(Failure::Strict(warnings)) } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_call_is_told_without_how_it_is_shown() {
        let told = |typed: &str| {
            let words: Vec<String> = typed.split(' ').map(str::to_string).collect();
            asked(&words).cloned().collect::<Vec<_>>().join(" ")
        };
        let plain = "plan m.toml --want drag=-1 -o jobs";
        assert_eq!(told(plain), plain);
        for shown in [
            "-j 1 --no-color plan m.toml",
            "plan -vj2 m.toml -q",
            "--jobs=2 plan --verbose m.toml",
            "plan m.toml --jobs 3",
        ] {
            assert_eq!(told(shown), "plan m.toml", "{shown}");
        }
    }
}
