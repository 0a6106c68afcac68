//! A campaign ready for analysis, from its file or from runs in memory.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::baseline::{self, wrong};
use super::codes;
use super::columns;
use super::derived;
use super::error::Error;
use super::file::{CampaignFile, Estimator, ReadOptions, RunTable};
use super::forces;
use super::heading;
use super::lead_in;
use super::logs::{self, Logged};
use super::model_noise::ModelNoise;
pub(super) use super::moves::moves;
use super::single_thrusters::Own;
use super::steps_as_lines;
use super::thrusters;
use super::vertical;
use super::window;
use super::{own_formulas, same_log, scale};
use crate::effects::channel;
use crate::estimate::output_error::OutputErrorOptions;
use crate::finding::{Finding, Severity};
use crate::formula::Formula;
use crate::frame::Dof;
use crate::log::options::PositionSource;
use crate::model::{Interpolation, Model};
use crate::navigation::{comes_round, unwrap};
use crate::procedure::{Bench, acting_forces};
use crate::progress::Count;
use crate::run::{Role, Run, RunKind, Signal};
use crate::thrust::efficiency::Efficiency;
use crate::thrust::measured::MeasuredCurve;
use crate::vehicle::{Vehicle, Water};

/// Options of loading a campaign.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct LoadOptions {
    /// Whether logs may lie outside the campaign's folder.
    pub allow_outside: bool,
}

/// Options of the estimators.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// The estimator that the campaign asks for.
    pub estimator: Option<Estimator>,
    /// Options of output error: segments, noise, whether the position is an independent
    /// measurement.
    pub output_error: OutputErrorOptions,
    /// Seed of all random numbers.
    pub seed: u64,
}

/// One vehicle, its runs and its baseline: the input of every verb.
#[derive(Debug, Clone)]
pub struct Campaign {
    /// Content of the campaign file.
    pub file: CampaignFile,
    /// Properties of the dry vehicle.
    pub vehicle: Vehicle,
    /// The water.
    pub water: Water,
    /// The baseline, with the prior knowledge of its parameters.
    pub model: Model,
    /// The runs, in the order of the file: in SI units, with acting forces and derived channels.
    pub runs: Vec<Run>,
    /// Runs of a thruster on a bench; the verbs about motion do not read them.
    pub benches: Vec<Run>,
    /// The user's own effects that the discovery may add, and those that columns of the log
    /// suggest.
    pub candidates: Vec<Own>,
    /// Findings about the columns that suggest candidates.
    pub brought: Vec<Finding>,
    /// Thruster curves that were fitted to bollard tables; the thrusters of `file` have them.
    pub curves: Vec<MeasuredCurve>,
    /// Noise that belongs to the model in use; estimated where it is needed and absent.
    pub noise: Option<ModelNoise>,
    /// Options of the estimators.
    pub options: Options,
    /// Findings from reading and preparing.
    pub findings: Vec<Finding>,
    /// Files that were read: the campaign and its logs.
    pub sources: Vec<PathBuf>,
}

impl Campaign {
    /// Reads a campaign file and its logs.
    ///
    /// # Errors
    /// [`Error`]; faults of the logs are reported for all runs at once.
    pub fn load(path: &Path, options: LoadOptions) -> Result<Campaign, Error> {
        let read = ReadOptions { allow_outside: options.allow_outside, ..ReadOptions::default() };
        Campaign::from_file(CampaignFile::read(path, &read)?)
    }

    /// Reads the logs of a campaign file.
    ///
    /// # Errors
    /// As [`Campaign::load`].
    pub fn from_file(file: CampaignFile) -> Result<Campaign, Error> {
        let names = names(&file.runs);
        let count = Count::begun("reading logs", names.len());
        let read = |(table, name): (&RunTable, &String)| logs::read(&file, table, name);
        let logged: Vec<Result<Logged, Error>> =
            file.runs.par_iter().zip(&names).map(read).inspect(|_| count.one_done()).collect();
        let mut good = Vec::new();
        let mut findings = Vec::new();
        for logged in logged {
            match logged {
                Ok(logged) => good.push(logged),
                Err(error) if error.is_wrong_use() => return Err(error),
                Err(error) => findings.extend(named(error)),
            }
        }
        if !findings.is_empty() {
            return Err(Error::Refused { findings });
        }
        let logs = file.runs.iter().flat_map(|run| &run.files).map(|log| file.path_of(log));
        let sources: Vec<PathBuf> = file.source.iter().map(|s| s.file.clone()).chain(logs).collect();
        let tables = file.runs.clone();
        assemble(file, good, &tables, sources)
    }

    /// Makes a campaign of runs in memory: signals in SI units under their canonical names, `tau_*`
    /// or thruster channels among them. The `[[run]]` tables of `file` are not read: names, kinds
    /// and roles are those of the runs. A repeated name gets a number.
    ///
    /// # Errors
    /// [`Error`].
    pub fn from_runs(file: CampaignFile, runs: Vec<Run>) -> Result<Campaign, Error> {
        Campaign::from_commanded_runs(file, runs.into_iter().map(|run| (run, BTreeMap::new())).collect())
    }

    /// As [`Campaign::from_runs`], each run with the units of its commands: `V`, `1` or `us`; a
    /// command that is not listed is in `V`.
    ///
    /// # Errors
    /// [`Error`].
    pub fn from_commanded_runs(
        file: CampaignFile,
        runs: Vec<(Run, BTreeMap<String, &'static str>)>,
    ) -> Result<Campaign, Error> {
        let tables: Vec<RunTable> =
            runs.iter().map(|(run, _)| RunTable { kind: run.kind, role: run.role, ..RunTable::default() }).collect();
        let position = file.log.position_source == Some(PositionSource::Independent);
        let through_water = file.log.is_through_water();
        let names = numbered(runs.iter().map(|(run, _)| run.name.as_str()));
        let logged = |((run, units), name)| Logged {
            run: Run { name, ..run },
            units,
            position,
            through_water,
            ..Logged::default()
        };
        let logged = runs.into_iter().zip(names).map(logged).collect();
        assemble(file, logged, &tables, Vec::new())
    }

    /// Returns the runs of free motion, all or of one role, on which output error and simulation
    /// work. If the thrust of the model is late, they lack the sensor samples on which commands
    /// from before the log may act.
    pub fn motion(&self, role: Option<Role>) -> Vec<Run> {
        let runs = self.motion_numbers(role).into_iter().map(|k| self.runs[k].clone()).collect();
        if lead_in::is_late(&self.model) { lead_in::settled(runs, &self.model) } else { runs }
    }

    /// Returns the indices of the runs of [`Campaign::motion`], in its order.
    pub(super) fn motion_numbers(&self, role: Option<Role>) -> Vec<usize> {
        let of_role = |r: &Run| moves(r.kind) && role.is_none_or(|role| r.role == role);
        (0..self.runs.len()).filter(|k| of_role(&self.runs[*k])).collect()
    }

    /// Returns the runs with nominal instead of acting forces, for procedures that apply
    /// efficiencies themselves.
    pub fn nominal_runs(&self) -> Vec<Run> {
        with_nominal_forces(self.runs.clone())
    }

    /// Returns the campaign with the acting forces under other losses of thrust than its own, such
    /// as those of a fitted model.
    #[must_use]
    pub fn under(&self, efficiency: &Efficiency) -> Campaign {
        if *efficiency == self.file.efficiency {
            return self.clone();
        }
        let mut campaign = self.clone();
        let thrusters = &campaign.file.thrusters;
        let acting = |run: Run| if moves(run.kind) { acting_forces(&run, efficiency, thrusters).0 } else { run };
        campaign.runs = self.nominal_runs().into_iter().map(acting).collect();
        campaign.file.efficiency = efficiency.clone();
        campaign
    }

    /// Returns the campaign with the noise of a fitted model.
    #[must_use]
    pub fn with_noise(mut self, noise: Option<ModelNoise>) -> Campaign {
        self.noise = noise;
        self
    }

    /// Returns what is known about the vehicle apart from its model, for the staged procedure.
    pub fn bench(&self) -> Bench<'_> {
        Bench {
            vehicle: &self.vehicle,
            water: &self.water,
            efficiency: &self.file.efficiency,
            thrusters: &self.file.thrusters,
            curves: &self.curves,
        }
    }

    /// Whether some run is held out of the fit.
    pub fn validates(&self) -> bool {
        self.runs.iter().any(|run| run.role == Role::Validate)
    }
}

/// Returns the runs with nominal instead of acting forces.
pub(super) fn with_nominal_forces(mut runs: Vec<Run>) -> Vec<Run> {
    for run in &mut runs {
        for dof in Dof::ALL {
            if let Some(signal) = run.signals.remove(&forces::nominal(dof)) {
                run.signals.insert(dof.force().into(), signal);
            }
        }
    }
    runs
}

/// Returns the names of the runs: their first file, with a number if several runs are of one file.
pub fn names(tables: &[RunTable]) -> Vec<String> {
    numbered(tables.iter().map(|table| table.files.first().map_or("", |f| f.file.as_str())))
}

/// Returns the names made distinct: one that was there before gets a number.
fn numbered<'a>(given: impl Iterator<Item = &'a str>) -> Vec<String> {
    let mut seen: BTreeMap<&str, usize> = BTreeMap::new();
    let numbered = |name: &'a str| {
        let count = seen.entry(name).or_default();
        *count += 1;
        if *count > 1 { format!("{name} #{count}") } else { name.to_string() }
    };
    given.map(numbered).collect()
}

/// Returns the findings of a refusal, each with its run.
fn named(error: Error) -> Vec<Finding> {
    match error {
        Error::Log { run, source } => source.findings().iter().map(|f| f.clone().of_run(&run)).collect(),
        Error::Refused { findings } => findings,
        _ => Vec::new(),
    }
}

/// Whether the velocities of the runs of free motion are relative to the water; an error if only
/// some are.
fn velocities_through_water(logged: &[Logged]) -> Result<bool, Error> {
    let logs_velocity = |run: &Run| ["u", "v", "w"].iter().any(|name| run.signals.contains_key(*name));
    let moving = || logged.iter().filter(|l| moves(l.run.kind) && logs_velocity(&l.run));
    let mut through = moving().filter(|l| l.through_water);
    let Some(first) = through.next() else { return Ok(false) };
    match moving().find(|l| !l.through_water) {
        None => Ok(true),
        Some(other) => {
            let text = format!(
                "{}: velocity_reference is \"water\", but in {} it is not: one model can use only one of the two; \
                 leave u, v, w of the others out",
                first.run.name, other.run.name
            );
            Err(Error::Refused { findings: vec![Finding::new(&codes::MIXED_REFERENCES, text)] })
        }
    }
}

/// Makes a campaign of logs that have been read, one per table.
pub(super) fn assemble(
    mut file: CampaignFile,
    logged: Vec<Logged>,
    tables: &[RunTable],
    mut sources: Vec<PathBuf>,
) -> Result<Campaign, Error> {
    columns::add_listed(&mut file, logged.iter().map(|logged| &logged.run))?;
    let (mut model, mut candidates) = baseline::build(&file)?;
    let held: Vec<bool> = tables.iter().map(|t| t.input.unwrap_or(file.model.input) == Interpolation::Hold).collect();
    // runs of both kinds together are read as lines, held commands as lines with steps
    let measures =
        |logged: &Logged| logged.run.signals.iter().any(|(name, signal)| steps_as_lines::goes_on(name, signal));
    let mixed =
        held.iter().any(|h| *h != held[0]) || held.iter().zip(&logged).any(|(h, logged)| *h && measures(logged));
    model.input = if !mixed && held.first() == Some(&true) { Interpolation::Hold } else { Interpolation::Linear };
    let thrusters::Curves { curves, mut findings, sources: tables_of_thrust } = thrusters::fit(&mut file)?;
    sources.extend(tables_of_thrust);
    own_formulas::check_observed_units(&file, &logged)?;
    let (mut runs, mut benches, mut refused) = (Vec::new(), Vec::new(), Vec::new());
    let mut position = true;
    model.through_water = velocities_through_water(&logged)?;
    let uncommanded = [baseline::driven_beside_thrust(&file), file.model.undriven.clone()].concat();
    let whole = !logged.iter().any(|logged| logged.piece);
    let mut holding: BTreeSet<String> = BTreeSet::new();
    for (k, (mut logged, table)) in logged.into_iter().zip(tables).enumerate() {
        prepare(&file, &mut logged, table, k)?;
        vertical::unfold(&model, &mut logged.run);
        if held[k] {
            holding.insert(logged.run.name.clone());
        }
        if held[k] && mixed {
            window::steps(&mut logged.run);
        }
        if let Err(wrong) = forces::apply(&mut logged, &model.dofs, &uncommanded, &file.thrusters, &file.efficiency) {
            refused.extend(wrong);
        }
        forces::nothing(&mut logged.run, &file.model.undriven);
        position &= logged.position || !moves(logged.run.kind);
        findings.append(&mut logged.findings);
        if logged.run.span().is_none() {
            let text = "no sample is left; widen `from`, `to` or `where`";
            refused
                .push(Finding::at(&codes::NOTHING_LEFT, &logged.run.name, None, None, text).of_run(&logged.run.name));
        }
        if logged.run.kind == RunKind::Bench { benches.push(logged.run) } else { runs.push(logged.run) }
    }
    if whole {
        derived::add(&mut runs, &file.vehicle, &model.dofs);
    }
    refused.extend(absent_channels(&model, &runs));
    let (errors, others): (Vec<_>, Vec<_>) =
        vertical::findings(&model, &runs).into_iter().partition(|f| f.severity == Severity::Error);
    refused.extend(errors);
    findings.extend(others);
    if !refused.is_empty() {
        return Err(Error::Refused { findings: refused });
    }
    own_formulas::check(&file, &model, &runs)?;
    let undriven = scale::undriven(&model, &runs, &baseline::driven_by_formulas(&file));
    findings.extend(scale::finding(&model, &undriven));
    if whole {
        findings.extend(same_log::findings(&runs));
        findings.extend(steps_as_lines::finding(&runs, |run| holding.contains(&run.name)));
        findings.extend(steps_as_lines::measured(&runs, |run| holding.contains(&run.name)));
    }
    let (tables, brought) = columns::bring(&mut file, &runs);
    for table in &tables {
        candidates.push(baseline::own(table).map_err(|e| wrong(&file, "effect", &e))?);
    }
    if position {
        findings.extend(heading::finding(&model, &runs));
    }
    findings.extend(unjudged(runs.iter().map(|run| run.role)));
    let output_error = OutputErrorOptions {
        segment: file.fit.segment,
        longest_step: file.fit.longest_step,
        loss: file.fit.loss,
        position: position && runs.iter().any(|run| moves(run.kind)),
        sigma: (!file.noise.sensors.is_empty()).then(|| file.noise.sensors.clone()),
        ..OutputErrorOptions::default()
    };
    let options = Options { estimator: file.fit.estimator, output_error, seed: file.seed };
    Ok(Campaign {
        vehicle: file.vehicle.clone(),
        water: file.water,
        model,
        runs,
        benches,
        candidates,
        brought,
        curves,
        noise: None,
        options,
        findings,
        sources,
        file,
    })
}

/// Largest number of samples that resampling may make of one; more add no information.
const MOST_MADE_UP: f64 = 1000.0;

/// Applies window, condition and rate to a run, and unwraps its angles.
fn prepare(file: &CampaignFile, logged: &mut Logged, table: &RunTable, index: usize) -> Result<(), Error> {
    window::cut(&mut logged.run, table);
    if let Some(text) = &table.condition {
        let at = format!("run[{index}].where");
        let condition = Formula::parse(text).map_err(|e| wrong(file, &at, &e))?;
        window::keep_where(&mut logged.run, &condition, &observed(file)).map_err(|e| wrong(file, &at, &e))?;
    }
    if let Some(rate) = table.resample {
        let held = table.input.unwrap_or(file.model.input) == Interpolation::Hold;
        let (from, to) = logged.run.span().unwrap_or_default();
        let most = logged.run.signals.values().map(Signal::len).max().unwrap_or(0);
        if rate * (to - from) > MOST_MADE_UP * most as f64 + 1e4 {
            let text = format!(
                "`resample` = {rate} would make {:.3e} samples of {most} over {:.4e} s; if its time stamps are not in \
                 seconds set time_unit",
                rate * (to - from),
                to - from
            );
            let name = &logged.run.name;
            let finding = Finding::at(&codes::RESAMPLE, name, None, None, &text).of_run(name);
            return Err(Error::Refused { findings: vec![finding] });
        }
        window::resample(&mut logged.run, rate, held);
    }
    for angle in [Dof::Roll, Dof::Yaw].map(Dof::position) {
        let turns = logged.run.signals.get_mut(angle).filter(|signal| comes_round(signal.values()));
        if let Some(signal) = turns {
            *signal = Signal::new(signal.shared_time().clone(), unwrap(signal.values()));
        }
    }
    columns::unwind(&mut logged.run);
    logged.run.signals.retain(|_, signal| !signal.is_empty());
    Ok(())
}

/// Returns the finding that no run is held out, if every run takes part in the fit.
pub(super) fn unjudged(mut roles: impl Iterator<Item = Role>) -> Option<Finding> {
    let text =
        "no run has role = \"validate\": the runs compared took part in the fit, so the comparison is optimistic";
    (!roles.any(|role| role == Role::Validate)).then(|| Finding::new(&codes::NO_VALIDATION, text))
}

/// Returns the channels of the observed functions of the states: they are cut like those of motion.
fn observed(file: &CampaignFile) -> Vec<&str> {
    file.observed.iter().map(|o| o.channel.as_str()).collect()
}

/// Returns findings about channels that the model reads and runs of free motion lack.
fn absent_channels(model: &Model, runs: &[Run]) -> Vec<Finding> {
    let read: BTreeSet<(String, String)> = model
        .terms
        .iter()
        .flat_map(|term| term.effect.channels(term.place).into_iter().map(|channel| (channel, term.name())))
        .collect();
    let mut findings = Vec::new();
    for observer in &model.observers {
        let channel = observer.channel();
        if !runs.iter().any(|run| run.signals.contains_key(channel)) {
            let text = format!("[[observe]] compares it with the model, but no run logs `{channel}`");
            findings.push(Finding::at(&codes::NOT_ON_CHANNEL, "[[observe]]", None, Some(channel), &text));
        }
    }
    for run in runs.iter().filter(|run| moves(run.kind)) {
        for (name, term) in read.iter().filter(|(name, _)| !run.signals.contains_key(name)) {
            let what = match name.as_str() {
                channel::SUPPLY_RATIO => "a column with the supply voltage, such as supply_V",
                channel::ANCHOR_NORTH | channel::ANCHOR_EAST => "the position x, y",
                name if name.starts_with("KC_") => "[vehicle] length or volume",
                _ => "this column",
            };
            let text = format!("`{term}` reads it: it needs {what}, or take `{term}` out of the model");
            findings.push(Finding::at(&codes::NOT_ON_CHANNEL, &run.name, None, Some(name), &text).of_run(&run.name));
        }
    }
    findings
}
