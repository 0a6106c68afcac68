//! The campaign file: reads TOML into checked plain data, and writes it back.
//!
//! Each table is one struct; an unknown key is refused. All errors are reported at once, each with line, column, key,
//! value and the correction. Nothing is fitted here, and formulas stay text: the modules that parse them find their
//! place by [`Source::locate`].

mod check;
mod discover;
mod error;
mod fit;
mod model;
mod noise;
mod paths;
mod report;
mod runs;
mod tree;

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use toml::de::{DeTable, DeValue};

pub use discover::DiscoverTable;
pub(super) use error::io_text;
pub use error::{CampaignError, CampaignErrors, Location, Problem};
pub use fit::{Estimator, FitTable};
pub(super) use model::tie_cycle;
pub use model::{EffectRole, EffectTable, ModelTable, ObserveTable, ParameterTable};
pub use noise::{ForceNoise, ForceWord, NoiseTable};
pub use report::Source;
pub use runs::{RunFile, RunTable};

use crate::effects::{Coriolis, catalogue};
use crate::log::LogOptions;
use crate::log::encoding::{Opening, opening};
use crate::procedure::StagedOptions;
use crate::text_file;
use crate::thrust::efficiency::Efficiency;
use crate::thrust::thruster::Thruster;
use crate::vehicle::{Vehicle, Water};
use report::Report;

/// Format that this version reads and writes.
pub const FORMAT: i64 = 1;

/// A campaign as its file says it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CampaignFile {
    /// Format of the file: 1.
    pub format: i64,
    /// Seed of everything random. 1: any number will do, as long as it is the same tomorrow.
    pub seed: u64,
    /// Dry figures of the vehicle.
    pub vehicle: Vehicle,
    /// The water.
    #[serde(skip_serializing_if = "is_default")]
    pub water: Water,
    /// What is known of the noise of the sensors and of the random force.
    #[serde(skip_serializing_if = "NoiseTable::is_empty")]
    pub noise: NoiseTable,
    /// The baseline.
    pub model: ModelTable,
    /// What is known of parameters beforehand.
    #[serde(rename = "parameter", skip_serializing_if = "Vec::is_empty")]
    pub parameters: Vec<ParameterTable>,
    /// The user's own effects.
    #[serde(rename = "effect", skip_serializing_if = "Vec::is_empty")]
    pub effects: Vec<EffectTable>,
    /// Logged functions of the states.
    #[serde(rename = "observe", skip_serializing_if = "Vec::is_empty")]
    pub observed: Vec<ObserveTable>,
    /// The thrusters, where they are described.
    #[serde(rename = "thruster", skip_serializing_if = "Vec::is_empty")]
    pub thrusters: Vec<Thruster>,
    /// Known losses of thrust.
    #[serde(skip_serializing_if = "is_default")]
    pub efficiency: Efficiency,
    /// Reading options of all runs.
    #[serde(skip_serializing_if = "is_default")]
    pub log: LogOptions,
    /// Options of the fit.
    #[serde(skip_serializing_if = "is_default")]
    pub fit: FitTable,
    /// Options of the staged procedure.
    #[serde(skip_serializing_if = "is_default")]
    pub stage: StagedOptions,
    /// Options of the discovery.
    #[serde(skip_serializing_if = "is_default")]
    pub discover: DiscoverTable,
    /// The runs.
    #[serde(rename = "run", skip_serializing_if = "Vec::is_empty")]
    pub runs: Vec<RunTable>,
    /// Where every key stands in the text; `None` for a campaign that was not read.
    #[serde(skip)]
    pub source: Option<Source>,
}

impl Default for CampaignFile {
    fn default() -> CampaignFile {
        CampaignFile {
            format: FORMAT,
            seed: 1,
            vehicle: Vehicle::default(),
            water: Water::default(),
            noise: NoiseTable::default(),
            model: ModelTable::default(),
            parameters: Vec::new(),
            effects: Vec::new(),
            observed: Vec::new(),
            thrusters: Vec::new(),
            efficiency: Efficiency::default(),
            log: LogOptions::default(),
            fit: FitTable::default(),
            stage: StagedOptions::default(),
            discover: DiscoverTable::default(),
            runs: Vec::new(),
            source: None,
        }
    }
}

/// How a campaign file is read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ReadOptions {
    /// Let run files lie outside the campaign's folder. False: a campaign from elsewhere must not read what it likes.
    pub allow_outside: bool,
    /// Look whether the run files are there. True: a missing one is better known before the others are read.
    pub look_for_files: bool,
    /// Ids of the effects that there are besides the file's own; by default those of the catalogue.
    pub known_effects: Vec<String>,
}

impl Default for ReadOptions {
    fn default() -> ReadOptions {
        let known_effects = catalogue(Coriolis::Tied).iter().map(|e| e.about().id.to_string()).collect();
        ReadOptions { allow_outside: false, look_for_files: true, known_effects }
    }
}

impl CampaignFile {
    /// Reads and checks a campaign file; a folder stands for the `campaign.toml` in it.
    ///
    /// # Errors
    /// All that is wrong with it, up to [`CampaignErrors::MOST`] things.
    pub fn read(path: &Path, options: &ReadOptions) -> Result<CampaignFile, CampaignErrors> {
        let path = CampaignFile::at(path);
        let bytes = text_file::read_bytes(&path).map_err(|error| unreadable(&path, error.kind()))?;
        CampaignFile::from_bytes(&bytes, &path, options)
    }

    /// The campaign file that a path stands for: of a folder the `campaign.toml` in it.
    pub fn at(path: &Path) -> PathBuf {
        if path.is_dir() { path.join("campaign.toml") } else { path.to_path_buf() }
    }

    /// Checks the bytes of a campaign file as though they were read from `path`.
    ///
    /// # Errors
    /// As [`CampaignFile::read`].
    pub fn from_bytes(bytes: &[u8], path: &Path, options: &ReadOptions) -> Result<CampaignFile, CampaignErrors> {
        if let Opening::Log(name, extra) = opening(bytes) {
            let mut report = Report::new(path, "");
            report.at_span(0..0, Problem::OtherLog { name, extra });
            return Err(report.into_errors());
        }
        match std::str::from_utf8(bytes) {
            Ok(text) => CampaignFile::from_text(text, path, options),
            Err(error) => {
                let at = error.valid_up_to();
                // what is well-formed before it is the same in the lossy text, so the place is the same
                let mut report = Report::new(path, &String::from_utf8_lossy(bytes));
                report.at_span(at..at, Problem::NotUtf8 { byte: bytes[at] });
                Err(report.into_errors())
            }
        }
    }

    fn from_text(text: &str, path: &Path, options: &ReadOptions) -> Result<CampaignFile, CampaignErrors> {
        let mut report = Report::new(path, text);
        let (mut root, errors) = DeTable::parse_recoverable(text);
        if let Some(told) = other_file(root.get_ref(), text, !errors.is_empty()) {
            report.at_span(0..0, Problem::OtherFile { told });
            return Err(report.into_errors());
        }
        if !errors.is_empty() {
            report.source.spots = tree::spots(root.get_ref());
            for error in &errors {
                let here = error.span().and_then(|span| text.get(span)).filter(|_| error.message() == "duplicate key");
                let key = here.map(|key| format!(" `{key}`: keep one")).unwrap_or_default();
                report.toml(error, |message| Problem::Syntax { message: format!("{message}{key}") });
            }
            report.one_a_line();
            return Err(report.into_errors());
        }
        // before runs take over options, so that a wrong one is told where it stands
        report.source.spots = tree::spots(root.get_ref());
        tree::inherit_log(root.get_mut());
        // the keys of another format mean nothing here: it is the only thing to be told
        if let Some(found) = format_of(root.get_ref()).filter(|found| *found != FORMAT) {
            report.at("format", Problem::Format { found });
            return Err(report.into_errors());
        }
        check::presence(root.get_ref(), &mut report);
        let (tables, errors) = tree::read::<CampaignFile>(&mut root);
        errors.iter().for_each(|error| report.toml(error, report::problem_of));
        report.source.spots = tree::spots(root.get_ref());
        if let Some(tables) = &tables {
            check::numbers(root.get_ref(), &mut report);
            check::Check { campaign: tables, options, report: &mut report }.all();
        }
        match tables {
            Some(tables) if report.is_empty() => Ok(CampaignFile { source: Some(report.source), ..tables }),
            _ => Err(report.into_errors()),
        }
    }

    /// The campaign as TOML, without what is at its default. Reads back as it is.
    ///
    /// # Errors
    /// What the writer of TOML refuses; no value of these tables is known to be.
    pub fn to_toml(&self) -> Result<String, toml::ser::Error> {
        toml::to_string(self)
    }

    /// Folder that run files are relative to: that of the file it was read from, else the current one.
    pub fn folder(&self) -> PathBuf {
        folder_of(self.source.as_ref().map_or(Path::new(""), |source| &source.file))
    }

    /// How every log is read; `None` where they are read in several ways.
    pub fn common_log<'a>(&'a self) -> Option<&'a LogOptions> {
        let of_run = |run: &'a RunTable| {
            let way = run.log.as_ref().unwrap_or(&self.log);
            run.files.iter().all(|file| file.log.as_ref().is_none_or(|own| own == way)).then_some(way)
        };
        let mut ways = self.runs.iter().map(of_run);
        let first = ways.next().unwrap_or(Some(&self.log));
        first.filter(|way| ways.all(|other| other == Some(way)))
    }

    /// Where a log lies.
    pub fn path_of(&self, log: &RunFile) -> PathBuf {
        self.folder().join(&log.file)
    }
}

fn folder_of(file: &Path) -> PathBuf {
    match file.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_path_buf(),
        _ => PathBuf::from("."),
    }
}

fn unreadable(path: &Path, kind: std::io::ErrorKind) -> CampaignErrors {
    let file = path.to_path_buf();
    let problem = match path.with_file_name("metadata.yaml").is_file() && kind == std::io::ErrorKind::NotFound {
        true => Problem::OtherFile {
            told: "there is no campaign in this folder but a ROS 2 bag: `hydrosysid init FOLDER -o dive` of the Python package \
                   reads it and writes one",
        },
        false => Problem::CannotRead { kind },
    };
    let error = CampaignError { file: file.clone(), location: None, key: String::new(), value: None, problem };
    CampaignErrors { file, text: "".into(), errors: vec![error], more: false }
}

/// What a file is that is no campaign file at all, so that none of its lines need be gone through.
fn other_file(root: &DeTable<'_>, text: &str, broken: bool) -> Option<&'static str> {
    // a model says which version wrote it, a campaign never does
    if root.keys().any(|key| key.get_ref() == "hydrosysid") {
        return Some(
            "this is a model file, and a campaign file is wanted: one with [vehicle], [model] and [[run]] tables",
        );
    }
    let first = text.lines().find(|line| !line.trim().is_empty())?.trim_start();
    let table = !first.contains('=') && !first.starts_with(['[', '#']) && first.contains([',', ';', '\t']);
    (broken && table).then_some(
        "this is no campaign file but looks like a log: `hydrosysid init LOG -o campaign.toml` writes one from logs",
    )
}

/// The format asked for, when it is a whole number at all.
fn format_of(root: &DeTable<'_>) -> Option<i64> {
    match root.get("format")?.get_ref() {
        DeValue::Integer(n) => i64::from_str_radix(n.as_str(), n.radix()).ok(),
        _ => None,
    }
}

pub(super) fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

#[cfg(test)]
mod tests;
