//! The campaign file: reads TOML into checked plain data, and writes it back.
//!
//! Each table is one struct; an unknown key is refused. All errors are reported at once, each with
//! line, column, key, value and the correction. Nothing is fitted here, and formulas stay text: the
//! modules that parse them find their place by [`Source::locate`].

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

/// Content of a campaign file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CampaignFile {
    /// Format of the file: 1.
    pub format: i64,
    /// Seed of all random numbers. 1: any number will do, as long as it stays the same.
    pub seed: u64,
    /// Properties of the dry vehicle.
    pub vehicle: Vehicle,
    /// The water.
    #[serde(skip_serializing_if = "is_default")]
    pub water: Water,
    /// Prior knowledge of the noise of the sensors and of the random force.
    #[serde(skip_serializing_if = "NoiseTable::is_empty")]
    pub noise: NoiseTable,
    /// The baseline.
    pub model: ModelTable,
    /// Prior knowledge of parameters.
    #[serde(rename = "parameter", skip_serializing_if = "Vec::is_empty")]
    pub parameters: Vec<ParameterTable>,
    /// The user's own effects.
    #[serde(rename = "effect", skip_serializing_if = "Vec::is_empty")]
    pub effects: Vec<EffectTable>,
    /// Observed functions of the states.
    #[serde(rename = "observe", skip_serializing_if = "Vec::is_empty")]
    pub observed: Vec<ObserveTable>,
    /// The thrusters, if they are described.
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
    /// Place of every key in the text; `None` for a campaign that was not read from a file.
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

/// Options of reading a campaign file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ReadOptions {
    /// Whether run files may lie outside the campaign's folder. False: a campaign from elsewhere
    /// must not read arbitrary files.
    pub allow_outside: bool,
    /// Whether to check that the run files exist. True: a missing one is better known before the
    /// others are read.
    pub look_for_files: bool,
    /// Ids of the known effects besides the file's own; by default those of the catalogue.
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
    /// All errors, up to [`CampaignErrors::MOST`].
    pub fn read(path: &Path, options: &ReadOptions) -> Result<CampaignFile, CampaignErrors> {
        let path = CampaignFile::at(path);
        let bytes = text_file::read_bytes(&path).map_err(|error| unreadable(&path, error.kind()))?;
        CampaignFile::from_bytes(&bytes, &path, options)
    }

    /// Returns the campaign file that a path stands for: for a folder, the `campaign.toml` in it.
    pub fn at(path: &Path) -> PathBuf {
        if path.is_dir() { path.join("campaign.toml") } else { path.to_path_buf() }
    }

    /// Checks the bytes of a campaign file as if they were read from `path`.
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
                // the well-formed part before it is the same in the lossy text, so the place is the
                // same
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
        // before runs inherit options, so that a wrong option is reported where it stands
        report.source.spots = tree::spots(root.get_ref());
        tree::inherit_log(root.get_mut());
        // the keys of another format mean nothing here: only the format is reported
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

    /// Returns the campaign as TOML without default values. It reads back unchanged.
    ///
    /// # Errors
    /// Refusals of the TOML writer; no value of these tables is known to cause one.
    pub fn to_toml(&self) -> Result<String, toml::ser::Error> {
        toml::to_string(self)
    }

    /// Returns the folder that run files are relative to: that of the file it was read from,
    /// otherwise the current one.
    pub fn folder(&self) -> PathBuf {
        folder_of(self.source.as_ref().map_or(Path::new(""), |source| &source.file))
    }

    /// Returns the reading options of all logs; `None` if they are read with different ones.
    pub fn common_log<'a>(&'a self) -> Option<&'a LogOptions> {
        let of_run = |run: &'a RunTable| {
            let way = run.log.as_ref().unwrap_or(&self.log);
            run.files.iter().all(|file| file.log.as_ref().is_none_or(|own| own == way)).then_some(way)
        };
        let mut ways = self.runs.iter().map(of_run);
        let first = ways.next().unwrap_or(Some(&self.log));
        first.filter(|way| ways.all(|other| other == Some(way)))
    }

    /// Returns the path of a log.
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
            told: "this folder holds no campaign but a ROS 2 bag: `hydrosysid init FOLDER -o dive` of the Python \
                   package reads it and writes a campaign",
        },
        false => Problem::CannotRead { kind },
    };
    let error = CampaignError { file: file.clone(), location: None, key: String::new(), value: None, problem };
    CampaignErrors { file, text: "".into(), errors: vec![error], more: false }
}

/// Returns what a file is that is no campaign file at all, so that its lines need not be checked.
fn other_file(root: &DeTable<'_>, text: &str, broken: bool) -> Option<&'static str> {
    // a model file states which version wrote it, a campaign file never does
    if root.keys().any(|key| key.get_ref() == "hydrosysid") {
        return Some(
            "this is a model file, not a campaign file: a campaign file has [vehicle], [model] and [[run]] tables",
        );
    }
    let first = text.lines().find(|line| !line.trim().is_empty())?.trim_start();
    let table = !first.contains('=') && !first.starts_with(['[', '#']) && first.contains([',', ';', '\t']);
    (broken && table).then_some(
        "this is not a campaign file but looks like a log: `hydrosysid init LOG -o campaign.toml` writes a campaign \
         from logs",
    )
}

/// Returns the format of the file, if it is a whole number.
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
