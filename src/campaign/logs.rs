//! Reading of the logs of one `[[run]]`: they are brought to one clock and put together.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use super::baseline;
use super::codes;
use super::error::Error;
use super::file::{CampaignFile, RunTable};
use crate::finding::Finding;
use crate::frame::Dof;
use crate::log::check::time::silences;
use crate::log::codes::MISSING_COLUMN;
use crate::log::options::PositionSource;
use crate::log::{self, LogError, LogFile, LogOptions};
use crate::run::{Run, RunKind, Signal, WALL_CLOCK, thruster_of};

/// Largest number of thrusters that are looked for in the header of a log that was refused.
const MOST_THRUSTERS: usize = 16;

/// A run as its logs have it.
#[derive(Debug, Clone, Default)]
pub(super) struct Logged {
    pub run: Run,
    /// Unit of each channel that has one: of a command as it was logged (`V`, `1` or `us`),
    /// otherwise that of SI.
    pub units: BTreeMap<String, &'static str>,
    /// Warnings and notes of the reader.
    pub findings: Vec<Finding>,
    /// Whether the position is an independent measurement.
    pub position: bool,
    /// Whether the velocities are relative to the water.
    pub through_water: bool,
    /// Whether it is a piece of a run: nothing that needs a whole run is derived from it.
    pub piece: bool,
}

/// Reads the logs of `table`; messages call the run `name`.
pub(super) fn read(file: &CampaignFile, table: &RunTable, name: &str) -> Result<Logged, Error> {
    let options = table.log.as_ref().unwrap_or(&file.log);
    let mut logged = Logged {
        run: Run { name: name.to_string(), kind: table.kind, role: table.role, ..Run::default() },
        position: options.position_source == Some(PositionSource::Independent),
        through_water: options.is_through_water(),
        ..Logged::default()
    };
    // none of several logs holds everything: what is absent is reported when they are together
    let alone = table.files.len() == 1;
    let needed = needed(file, table.kind);
    let (mut zero, mut walls, mut locals) = (None, false, false);
    for one in &table.files {
        let required: Vec<&str> = needed.iter().copied().filter(|c| alone || *c == "t").collect();
        let options = one.log.as_ref().unwrap_or(options);
        let path = file.path_of(one);
        let read = read_one(&path, options, &required, &file.model.dofs)
            .map_err(|error| if file.thrusters.is_empty() { without_tables(error, &path, options) } else { error })
            .map_err(|source| Error::Log { run: name.to_string(), source })?;
        let offset = ahead(read.origin, one.clock_offset, &mut zero);
        (walls, locals) = if on_wall_clock(read.origin, one.clock_offset) { (true, locals) } else { (walls, true) };
        let findings = read.warnings.into_iter().chain(read.notes).map(|f| f.of_run(name));
        logged.findings.extend(findings);
        logged.run.gaps.extend(read.gaps.iter().map(|t| t + offset));
        logged.units.extend(read.units);
        let mut clocks = Clocks::new();
        for (channel, signal) in read.signals {
            let signal = shifted(&signal, offset, &mut clocks);
            if logged.run.signals.insert(channel.clone(), signal).is_some() {
                let text = format!("the run has `{channel}` from another log already; keep one of them");
                let finding = Finding::at(&codes::TWICE, &one.file, None, Some(&channel), &text).of_run(name);
                return Err(Error::Refused { findings: vec![finding] });
            }
        }
    }
    if walls && locals {
        let text = "some of its logs have wall-clock stamps and some count from their own zero: the zero of the latter \
                    is assumed to be the first stamp of the first wall clock. Give each of them the `clock_offset` to \
                    that clock, or its zero in seconds since 1970";
        logged.findings.push(Finding::at(&codes::TWO_CLOCKS, name, None, None, text).of_run(name));
    }
    if !alone {
        // a gap of one log is no gap of the run while the sensors of another log go on
        logged.run.gaps = silences(&logged.run.signals);
        let absent: Vec<Finding> = needed
            .into_iter()
            .filter(|c| *c != "t" && !logged.run.signals.contains_key(*c))
            .filter(|c| !Dof::ALL.iter().any(|dof| dof.velocity() == *c && told_by_pose(&logged.run.signals, *dof)))
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

/// Whether the time stamps are those of a wall clock after `clock_offset` is added. `origin` is
/// what the reader has subtracted from them. An offset of that size turns a local clock into a wall
/// clock, and the other way round.
fn on_wall_clock(origin: Option<f64>, clock_offset: f64) -> bool {
    match origin {
        Some(_) => clock_offset > -WALL_CLOCK,
        None => clock_offset >= WALL_CLOCK,
    }
}

/// Returns how far a log is ahead of the clock of its run, s. The reader starts each log of a wall
/// clock at 0; what it has subtracted is added again, relative to `zero`, which the first of these
/// logs sets.
fn ahead(origin: Option<f64>, clock_offset: f64, zero: &mut Option<f64>) -> f64 {
    if !on_wall_clock(origin, clock_offset) {
        return origin.unwrap_or(0.0) + clock_offset;
    }
    // the large numbers first: the difference keeps the digits of a small offset
    let (begin, rest) = origin.map_or((clock_offset, 0.0), |origin| (origin, clock_offset));
    begin - *zero.get_or_insert(begin) + rest
}

/// Reads a log that must have the columns `required`. A velocity may be absent if the log gives it
/// by positions or angles, and the forces if the log has commands or forces of thrusters.
fn read_one(path: &Path, options: &LogOptions, required: &[&str], dofs: &[Dof]) -> Result<LogFile, LogError> {
    let refused = match log::read(path, options, required) {
        Err(error) if error.findings().iter().any(|f| f.code == MISSING_COLUMN.code) => error,
        other => return other,
    };
    let absent = |column: &str| {
        refused.findings().iter().any(|f| f.code == MISSING_COLUMN.code && f.column.as_deref() == Some(column))
    };
    let posed: Vec<Dof> = dofs.iter().copied().filter(|dof| absent(dof.velocity())).collect();
    let unpushed: Vec<Dof> = dofs.iter().copied().filter(|dof| absent(dof.force())).collect();
    let dispensable = |column: &str| {
        posed.iter().any(|dof| dof.velocity() == column) || unpushed.iter().any(|dof| dof.force() == column)
    };
    let fewer: Vec<&str> = required.iter().copied().filter(|c| !dispensable(c)).collect();
    // if thrusters are logged, their [[thruster]] tables are missing, not the forces: `forces`
    // reports that
    let pushes = |log: &LogFile| unpushed.is_empty() || log.signals.keys().any(|c| is_of_thruster(c));
    match log::read(path, options, &fewer) {
        Ok(log) if pushes(&log) && posed.iter().all(|dof| told_by_pose(&log.signals, *dof)) => Ok(log),
        _ => Err(refused),
    }
}

/// Returns the error of a log that was refused, for missing forces among other reasons. If the log
/// has commands or forces of thrusters, the likely cause, no `[[thruster]]` tables, takes the place
/// of the missing forces.
fn without_tables(error: LogError, path: &Path, options: &LogOptions) -> LogError {
    let LogError::Refused { file, mut findings, further } = error else { return error };
    let is_force = |f: &Finding| {
        f.code == MISSING_COLUMN.code && Dof::ALL.iter().any(|dof| f.column.as_deref() == Some(dof.force()))
    };
    if findings.iter().any(is_force) {
        // the header alone: its units may be what was refused
        let names: Vec<String> =
            ["V", "F"].iter().flat_map(|l| (1..=MOST_THRUSTERS).map(move |k| format!("{l}{k}"))).collect();
        let asked: Vec<&str> = names.iter().map(String::as_str).collect();
        let refused = log::read(path, options, &asked).err();
        let is_absent = |name: &&str| {
            let told = refused.iter().flat_map(LogError::findings);
            told.into_iter().any(|f| f.code == MISSING_COLUMN.code && f.column.as_deref() == Some(*name))
        };
        let logged: Vec<&str> = asked.iter().copied().filter(|name| !is_absent(name)).collect();
        if let Some(first) = logged.first() {
            findings.retain(|f| !is_force(f));
            let text = super::forces::no_tables(&logged);
            findings.insert(0, Finding::at(&codes::NO_THRUSTER, &file, None, Some(first), &text));
        }
    }
    LogError::Refused { file, findings, further }
}

/// Whether a column is the command or the force of a thruster: `V1`, `F2`.
fn is_of_thruster(column: &str) -> bool {
    ["V", "F"].iter().any(|letter| thruster_of(column, letter).is_some())
}

/// Whether positions and angles give the motion in `dof` if its velocity is not logged: an angle
/// gives its rate, the depth gives heave, north and east with the heading give surge and sway.
pub(super) fn told_by_pose(signals: &BTreeMap<String, Signal>, dof: Dof) -> bool {
    let needed: &[&str] = match dof {
        Dof::Surge | Dof::Sway => &["x", "y", "psi"],
        Dof::Heave => &["z"],
        Dof::Roll => &["phi"],
        Dof::Pitch => &["theta"],
        Dof::Yaw => &["psi"],
    };
    needed.iter().all(|name| signals.contains_key(*name))
}

/// Returns the columns that a run of this kind must have: time and velocities, and the forces
/// unless thrusters give them. A bollard table may count its rows; a towed vehicle has no thrust. A
/// velocity may be absent if an observed function contains it, and a force if a formula of the
/// user, a fin or nothing drives its degree of freedom.
pub(super) fn needed(file: &CampaignFile, kind: RunKind) -> Vec<&'static str> {
    let (told, driven) = (baseline::told_by_functions(file), baseline::driven_beside_thrust(file));
    let uncommanded = || driven.iter().chain(&file.model.undriven);
    let optional = |column: &&str| {
        told.iter().any(|dof| dof.velocity() == *column) || uncommanded().any(|dof| dof.force() == *column)
    };
    let velocities = file.model.dofs.iter().map(|dof| dof.velocity());
    let all = match kind {
        RunKind::Bollard => Vec::new(),
        RunKind::Towing => vec!["t"],
        RunKind::Bench => vec!["t", "force"],
        _ if file.thrusters.is_empty() => log::required(&file.model.dofs),
        _ => std::iter::once("t").chain(velocities).collect(),
    };
    all.into_iter().filter(|column| !optional(column)).collect()
}

/// Time stamps before and after a shift: signals that share them before share them after it.
type Clocks = Vec<(Arc<[f64]>, Arc<[f64]>)>;

/// Returns the signal on a clock that is `offset` seconds ahead.
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
