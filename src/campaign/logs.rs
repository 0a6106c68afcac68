//! From the logs of one `[[run]]` to one run: read, brought to one clock, put together.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::baseline;
use super::codes;
use super::error::Error;
use super::file::{CampaignFile, RunTable};
use crate::finding::Finding;
use crate::log::options::PositionSource;
use crate::log::{self, LogError, LogOptions};
use crate::run::{Run, RunKind, Signal};

/// A run as its logs say it.
#[derive(Debug, Clone, Default)]
pub(super) struct Logged {
    pub run: Run,
    /// Unit of each command as it was logged: `V`, `1` or `us`.
    pub units: BTreeMap<String, &'static str>,
    /// Warnings and notes of the reader.
    pub findings: Vec<Finding>,
    /// Whether the position is a measurement of its own.
    pub position: bool,
    /// Whether it is a piece of a run, of which nothing is made that needs a whole one.
    pub piece: bool,
}

/// Reads the logs of `table`, whose name in messages is `name`.
pub(super) fn read(file: &CampaignFile, table: &RunTable, name: &str) -> Result<Logged, Error> {
    let options = table.log.as_ref().unwrap_or(&file.log);
    let mut logged = Logged {
        run: Run { name: name.to_string(), kind: table.kind, role: table.role, ..Run::default() },
        position: options.position_source == Some(PositionSource::Independent),
        ..Logged::default()
    };
    // of several logs none holds everything, so that what is absent is told when they are together
    let alone = table.files.len() == 1;
    let needed = needed(file, table.kind);
    for one in &table.files {
        let required: Vec<&str> = needed.iter().copied().filter(|c| alone || *c == "t").collect();
        let read = read_one(&file.path_of(one), options, &required)
            .map_err(|source| Error::Log { run: name.to_string(), source })?;
        let findings = read.warnings.into_iter().chain(read.notes).map(|f| f.of_run(name));
        logged.findings.extend(findings);
        logged.run.gaps.extend(read.gaps.iter().map(|t| t + one.clock_offset));
        logged.units.extend(read.units);
        let mut clocks = Clocks::new();
        for (channel, signal) in read.signals {
            let signal = shifted(&signal, one.clock_offset, &mut clocks);
            if logged.run.signals.insert(channel.clone(), signal).is_some() {
                let text = format!("the run has `{channel}` from another log already; keep one of them");
                let finding = Finding::at(&codes::TWICE, &one.file, None, Some(&channel), &text).of_run(name);
                return Err(Error::Refused { findings: vec![finding] });
            }
        }
    }
    logged.run.gaps.sort_by(f64::total_cmp);
    logged.run.gaps.dedup();
    if !alone {
        let absent: Vec<Finding> = needed
            .into_iter()
            .filter(|c| *c != "t" && !logged.run.signals.contains_key(*c))
            .map(|c| {
                Finding::at(&codes::NOT_ON_CHANNEL, name, None, Some(c), "none of the run's logs has it").of_run(name)
            })
            .collect();
        if !absent.is_empty() {
            return Err(Error::Refused { findings: absent });
        }
    }
    Ok(logged)
}

fn read_one(path: &std::path::Path, options: &LogOptions, required: &[&str]) -> Result<log::LogFile, LogError> {
    log::read(path, options, required)
}

/// Columns that a run of this kind must have: time and velocities, and the forces unless thrusters give them. A
/// bollard table may count its rows; a towed vehicle pushes nothing. A velocity that an observed function tells, and
/// the force where a formula of the user drives, may be absent.
pub(super) fn needed(file: &CampaignFile, kind: RunKind) -> Vec<&'static str> {
    let (told, driven) = (baseline::told_by_functions(file), baseline::driven_by_formulas(file));
    let optional = |column: &&str| {
        told.iter().any(|dof| dof.velocity() == *column) || driven.iter().any(|dof| dof.force() == *column)
    };
    let velocities = file.model.dofs.iter().map(|dof| dof.velocity());
    let all = match kind {
        RunKind::Bollard => Vec::new(),
        RunKind::Towing => vec!["t"],
        _ if file.thrusters.is_empty() => log::required(&file.model.dofs),
        _ => std::iter::once("t").chain(velocities).collect(),
    };
    all.into_iter().filter(|column| !optional(column)).collect()
}

/// Stamps before and after a shift, so that signals that share them still do.
type Clocks = Vec<(Arc<[f64]>, Arc<[f64]>)>;

/// The signal on a clock that is `offset` seconds ahead.
fn shifted(signal: &Signal, offset: f64, clocks: &mut Clocks) -> Signal {
    if offset == 0.0 {
        return signal.clone();
    }
    let known = clocks.iter().find(|(old, _)| Arc::ptr_eq(old, signal.shared_time())).map(|(_, new)| new.clone());
    let clock = known.unwrap_or_else(|| {
        let new: Arc<[f64]> = signal.time().iter().map(|t| t + offset).collect();
        clocks.push((signal.shared_time().clone(), new.clone()));
        new
    });
    Signal::new(clock, signal.values().to_vec())
}
