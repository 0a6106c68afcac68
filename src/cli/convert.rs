//! The verb `convert`: writes a log as plain CSV in SI units.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use super::answer;
use super::arguments::{self as typed, Reading};
use super::failure::Failure;
use super::output::Output;
use super::table::wrapped;
use super::verbs::reading;
use crate::campaign;
use crate::log::encoding::{LOOKED_AT, Opening, opening};
use crate::log::{self, LogOptions};
use crate::text_file;
use crate::wording::count;

/// File extensions of logs that only the Python package reads, with the extra that it needs for
/// them. They are used only if the log cannot be opened.
const ELSEWHERE: [(&str, &str); 16] = [
    ("bag", "ros"),
    ("db3", "ros"),
    ("mcap", "ros"),
    ("bin", "ardupilot"),
    ("tlog", "ardupilot"),
    ("ulg", "px4"),
    ("mat", "mat"),
    ("h5", "hdf5"),
    ("hdf5", "hdf5"),
    ("parquet", "parquet"),
    ("arrow", "arrow"),
    ("arrows", "arrow"),
    ("feather", "arrow"),
    ("nc", "xarray"),
    ("npz", ""),
    ("npy", ""),
];

/// The kind of a log that the library does not read, and the extra of the Python package that reads
/// it; determined from its first bytes, independent of its name.
fn elsewhere(log: &Path) -> Option<(String, &'static str)> {
    if log.is_dir() {
        return Some(("a folder, such as a ROS 2 bag".into(), "ros"));
    }
    // a pipe can be read only once: its reader determines the kind
    if log.exists() && !log.is_file() {
        return None;
    }
    let mut begin = Vec::new();
    match File::open(log).and_then(|file| file.take(LOOKED_AT).read_to_end(&mut begin)) {
        Ok(_) => match opening(&begin) {
            Opening::Log(name, extra) => Some((format!("this is {name}"), extra)),
            Opening::Text(_) | Opening::Other(_) => None,
        },
        Err(_) => {
            let end = log.extension().map(|e| e.to_string_lossy().to_lowercase());
            let found = ELSEWHERE.iter().find(|(e, _)| Some(*e) == end.as_deref());
            found.map(|(_, extra)| ("there is no such file, and its name is not that of a CSV file".into(), *extra))
        }
    }
}

/// Refuses a log in a format that the library does not read, with the name of the package that
/// does.
fn reads(log: &Path) -> Result<(), Failure> {
    elsewhere(log).map_or(Ok(()), |(what, extra)| {
        let package = if extra.is_empty() { "hydrosysid".to_string() } else { format!("hydrosysid[{extra}]") };
        let text = format!(
            "{}: {what}; such logs need the command of the Python package: pip install '{package}'",
            log.display()
        );
        Err(Failure::Argument(text))
    })
}

/// The options of a map file together with those of the command line.
fn mapped(map: Option<&Path>, typed: &Reading) -> Result<LogOptions, Failure> {
    let Some(path) = map else { return reading(typed) };
    let read = text_file::read(path);
    let text = read.map_err(|source| Failure::Read { file: path.to_path_buf(), source })?;
    let of = |text: &str| toml::from_str::<toml::Table>(text);
    let mut table = of(&text).map_err(|e| Failure::Argument(format!("{}: {}", path.display(), e.message())))?;
    table.extend(of(&typed.options.join("\n")).map_err(|e| Failure::Argument(format!("--log: {}", e.message())))?);
    table.try_into().map_err(|e: toml::de::Error| Failure::Argument(format!("{}: {}", path.display(), e.message())))
}

pub(super) fn convert(a: &typed::Convert, output: &Output) -> Result<(), Failure> {
    let Some(to) = a.output.as_ref().or(a.out.as_ref()) else {
        return Err(Failure::Argument("give the file to write with -o".into()));
    };
    let is_data = Output::is_stdout(to);
    if is_data && output.json_on_stdout() {
        return Err(Failure::Argument(
            "standard output can take either the log or the JSON: give one of them a file".into(),
        ));
    }
    output.may_write(Some(to).filter(|_| !is_data).map(PathBuf::as_path))?;
    reads(&a.log)?;
    let options = mapped(a.map.as_deref(), &a.reading)?;
    let name = a.log.display().to_string();
    let read = output.working("reading the log", || log::read(&a.log, &options, &[]))?;
    let read = read.map_err(|source| campaign::Error::Log { run: name, source })?;
    let mut bytes = Vec::new();
    log::write_log(&read, &mut bytes).map_err(|source| Failure::Write { file: to.clone(), source })?;
    if is_data {
        output.hand_over(&String::from_utf8_lossy(&bytes));
    } else {
        output.write(to, &bytes)?;
        let (rows, channels) = (count(read.rows, "row"), count(read.signals.len(), "channel"));
        output.print(&wrapped(&format!("{}: {rows}, {channels}", to.display())));
        if read.signals.values().any(|signal| signal.len() < read.rows) {
            output.print("cells are empty where a sensor has no sample: missing = \"no_sample\" reads them");
        }
    }
    let spans = read.signals.iter().filter(|(_, signal)| !signal.is_empty()).map(|(channel, signal)| {
        let time = signal.time();
        let span = serde_json::json!({"samples": signal.len(), "from": time[0], "to": time[time.len() - 1]});
        (channel.clone(), span)
    });
    let channels: serde_json::Map<String, serde_json::Value> = spans.collect();
    let findings: Vec<_> = read.warnings.into_iter().chain(read.notes).collect();
    output.json(&serde_json::json!({"format": 1, "source": a.log, "channels": channels, "warnings": findings}))?;
    output.tell(&findings)?;
    if !is_data {
        answer::next(&format!("hydrosysid init {0} -o {1}", to.display(), to.with_extension("").display()), output);
    }
    Ok(())
}
