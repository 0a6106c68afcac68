//! The demo: the whole procedure on the virtual tank, including the discovery of a hidden effect.
//!
//! 1. The paper's vehicle performs the paper's runs; they are written as a campaign and read back.
//! 2. The staged procedure estimates the model; the direct regression, which fits everything at
//!    once, is shown beside it.
//! 3. Each oscillation's model is simulated on the others' runs.
//! 4. A second campaign, with a random force and a baseline without one effect, goes through the
//!    discovery, which finds both.
//!
//! The true values are used only for the column that prints them.

mod folder;
mod printed;

use std::path::{Path, PathBuf};

use serde::Serialize;
use thiserror::Error;

pub use folder::FolderError;

use crate::campaign::{
    Campaign, Crossed, Error as CampaignError, Estimator, Fit, FitOptions, ForceFound, LoadOptions, each_run, filters,
    fit,
};
use crate::compare::{CompareError, CompareOptions, compare};
use crate::discover::Discovery;
use crate::frame::Dof;
use crate::model::Model;
use crate::procedure::sensitivity::{Spread, spreads};
use crate::procedure::{ProcedureError, Stage, StagedOptions, StagedResult, direct_regression, made_ready, staged};
use crate::run::{Run, RunKind};
use crate::tank::{
    Blind, BlindOptions, FolderError as TankFolderError, Hidden, PaperCampaign, TankError, paper_campaign, write_blind,
};

/// Options of the demo.
#[derive(Debug, Clone, PartialEq)]
pub struct DemoOptions {
    /// Folder to write; only the folder of an earlier demo is replaced.
    pub folder: PathBuf,
    /// Seed of the tank.
    pub seed: u64,
    /// Sensor noise, as a multiple of the default.
    pub noise: f64,
    /// Effect to hide: any id of the catalogue.
    pub hide: String,
}

/// Effect that is hidden by default: the Munk moment, which the paper found.
pub const HIDDEN: &str = "coriolis_yaw";

impl Default for DemoOptions {
    fn default() -> DemoOptions {
        DemoOptions { folder: "demo".into(), seed: 1, noise: 1.0, hide: HIDDEN.into() }
    }
}

/// Random force of the second campaign, as a fraction of the rated force: typical for tanks and
/// harbours.
const DISTURBANCE: f64 = 0.01;

/// Error of the demo.
#[derive(Debug, Error)]
pub enum DemoError {
    /// The folder is not a demo's, or cannot be written.
    #[error(transparent)]
    Folder(#[from] FolderError),
    /// The tank campaign cannot be made.
    #[error(transparent)]
    Tank(#[from] TankError),
    /// The campaign's files cannot be written.
    #[error(transparent)]
    Write(#[from] TankFolderError),
    /// The hidden campaign cannot be written.
    #[error(transparent)]
    Blind(#[from] crate::tank::WriteBlindError),
    /// A campaign does not load or fit.
    #[error(transparent)]
    Campaign(#[from] CampaignError),
    /// The staged procedure fails.
    #[error(transparent)]
    Procedure(#[from] ProcedureError),
    /// A model cannot be simulated.
    #[error(transparent)]
    Compare(#[from] CompareError),
}

/// An estimate beside the true value of its run and the printed value of the paper.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Held {
    /// Stage of the procedure.
    pub stage: String,
    /// Run, if the stage is of a single one.
    pub run: Option<String>,
    /// Degree of freedom.
    pub dof: Dof,
    /// Symbol.
    pub name: String,
    /// Estimate, SI.
    pub value: f64,
    /// Standard deviation, SI.
    pub std: f64,
    /// Unit.
    pub unit: String,
    /// True value in the run, SI; `None` if several runs with different true values take part.
    pub truth: Option<f64>,
    /// Printed value and standard deviation of the paper, SI.
    pub paper: Option<(f64, f64)>,
}

/// The random force in one degree of freedom of the second campaign: estimated and true values.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct HeldForce {
    /// The estimate; `None` if there is none.
    pub found: Option<ForceFound>,
    /// Degree of freedom.
    pub dof: Dof,
    /// True root mean square, N or N·m.
    pub rms: f64,
    /// True correlation time, s.
    pub correlation_time: f64,
}

/// One row of the table of condition numbers.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Conditioned {
    /// Stage.
    pub stage: String,
    /// Degree of freedom.
    pub dof: Dof,
    /// Rows.
    pub rows: usize,
    /// cond(HᵀH), as the paper prints.
    pub condition_number: f64,
    /// cond(H) with columns of unit length.
    pub condition_number_scaled: f64,
}

/// The staged model and the direct regression on one run: parameters and simulation errors.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Twins {
    /// Run.
    pub run: String,
    /// Symbol: staged value, all-at-once value and its standard deviation, truth.
    pub values: Vec<(String, f64, f64, f64, Option<f64>)>,
    /// Mean |measured − simulated| of the staged model, rad/s.
    pub staged_error: f64,
    /// The same of the direct regression, rad/s.
    pub twin_error: f64,
}

/// Results of the demo.
#[derive(Debug, Serialize)]
pub struct Demo {
    /// Version of this form.
    pub format: u32,
    /// Seed.
    pub seed: u64,
    /// Estimates of the staged procedure.
    pub estimates: Vec<Held>,
    /// Condition numbers.
    pub conditions: Vec<Conditioned>,
    /// Staged against all at once.
    pub twins: Vec<Twins>,
    /// Cross-validation of the surge oscillations.
    pub cross_validation: Vec<Crossed>,
    /// Variation of the estimates with window and degree of a filter.
    pub filters: Vec<Spread>,
    /// The hidden effect.
    pub hidden: Vec<String>,
    /// Result of the discovery.
    pub discovery: Discovery,
    /// The random force in the campaign with the hidden effect.
    pub forces: Vec<HeldForce>,
    /// Files that were written.
    pub files: Vec<PathBuf>,
    /// The paper's campaign as it was read back, for the report.
    #[serde(skip)]
    pub campaign: Campaign,
    /// Its fit.
    #[serde(skip)]
    pub fit: Fit,
    /// The campaign with the hidden effect.
    #[serde(skip)]
    pub blind: Campaign,
}

/// Makes the demo. `progress` is called with the name of each step.
///
/// # Errors
/// [`DemoError`].
pub fn demo(options: &DemoOptions, progress: &dyn Fn(&str)) -> Result<Demo, DemoError> {
    folder::prepare(&options.folder)?;
    let (paper_folder, blind_folder) = (options.folder.join("paper"), options.folder.join("hidden"));

    progress("sailing the paper's runs");
    let tank = paper_campaign(options.seed, options.noise)?;
    tank.write(&paper_folder)?;
    let campaign = Campaign::load(&paper_folder.join("campaign.toml"), LoadOptions::default())?;

    progress("the staged procedure");
    let bench = campaign.bench();
    let nominal = campaign.nominal_runs();
    let staging = &campaign.file.stage;
    let result = staged(&nominal, &campaign.model, bench, staging)?;
    let ready = made_ready(&nominal, &campaign.model, &result.efficiency, bench.thrusters, staging)?;
    let twins = twins(&ready, &campaign.model, &result, staging, &tank)?;
    let fitted = fit(&campaign, FitOptions { estimator: Some(Estimator::Staged) })?;
    let cross_validation = each_run(&campaign, &fitted).crossed.into_iter().filter(|c| c.dof == Dof::Surge).collect();
    progress("the same with filters");
    let moved = spreads(&filters(&campaign)?);

    progress("a campaign with a hidden effect");
    let hidden = BlindOptions {
        seed: options.seed,
        noise: options.noise,
        hidden: vec![Hidden::new(options.hide.clone(), 1.0)],
        disturbance: DISTURBANCE,
        ..BlindOptions::default()
    };
    let secret = write_blind(&blind_folder, &hidden)?;
    let blind = Campaign::load(&blind_folder.join("campaign.toml"), LoadOptions::default())?;
    progress("finding it");
    let discovery = crate::campaign::discover(&blind)?;

    Ok(Demo {
        format: 1,
        seed: options.seed,
        estimates: estimates(&result, &tank),
        conditions: result.stages.iter().map(conditioned).collect(),
        twins,
        cross_validation,
        filters: moved,
        forces: forces(&blind, &discovery, &secret, hidden.disturbance_time)?,
        hidden: secret.hidden,
        discovery,
        files: vec![paper_folder.join("campaign.toml"), blind_folder.join("campaign.toml")],
        campaign,
        fit: fitted,
        blind,
    })
}

/// The random force that a fit of the discovered model estimates, beside the true one.
fn forces(campaign: &Campaign, found: &Discovery, secret: &Blind, time: f64) -> Result<Vec<HeldForce>, DemoError> {
    let mut campaign = campaign.clone();
    if let Some(model) = found.model() {
        campaign.model = model.clone();
    }
    let noise = fit(&campaign, FitOptions::default())?.noise;
    let of = |dof: Dof| noise.iter().flat_map(|noise| &noise.force).find(|force| force.dof == dof).cloned();
    let pairs = secret.dofs.iter().zip(&secret.disturbance);
    Ok(pairs.map(|(dof, rms)| HeldForce { found: of(*dof), dof: *dof, rms: *rms, correlation_time: time }).collect())
}

/// Name of a run in the tank: without its file extension.
fn stem(run: &str) -> &str {
    Path::new(run).file_stem().and_then(|s| s.to_str()).unwrap_or(run)
}

/// True value of a parameter in a run of the tank.
fn truth_in(tank: &PaperCampaign, run: &str, term: &str) -> Option<f64> {
    let k = tank.runs.iter().position(|r| stem(&r.name) == stem(run))?;
    tank.truths[k].value(term)
}

fn estimates(result: &StagedResult, tank: &PaperCampaign) -> Vec<Held> {
    let of_stage = |stage: &Stage| -> Vec<Held> {
        let single = (stage.runs.len() == 1).then(|| stage.runs[0].clone());
        let one_truth = single.is_some() || stage.name == "towing" || (stage.name == "steady" && stage.dof != Dof::Yaw);
        stage
            .estimates
            .iter()
            .map(|e| {
                let term = if e.dof.is_empty() { e.effect.clone() } else { format!("{}@{}", e.effect, e.dof) };
                let truth = stage.runs.first().filter(|_| one_truth).and_then(|run| truth_in(tank, run, &term));
                Held {
                    stage: stage.name.clone(),
                    run: single.clone(),
                    dof: stage.dof,
                    name: e.name.clone(),
                    value: e.value,
                    std: e.std,
                    unit: e.unit.clone(),
                    truth,
                    paper: printed::of(&stage.name, stage.dof, &e.name),
                }
            })
            .collect()
    };
    result.stages.iter().flat_map(of_stage).collect()
}

fn conditioned(stage: &Stage) -> Conditioned {
    Conditioned {
        stage: stage.name.clone(),
        dof: stage.dof,
        rows: stage.rows,
        condition_number: stage.condition_number,
        condition_number_scaled: stage.condition_number_scaled,
    }
}

/// The model with the estimates of one stage.
fn with_stage(model: &Model, stage: &Stage) -> Model {
    let mut own = model.clone();
    for e in &stage.estimates {
        let found = own.parameters.iter_mut().find(|p| p.effect == e.effect && p.spec.name == e.name);
        if let Some(parameter) = found {
            parameter.value = e.value;
        }
    }
    own
}

/// Mean |measured − simulated| for the balance of `dof` alone, as in (29) and (30).
fn mean_abs(model: &Model, run: &Run, dof: Dof) -> Result<f64, CompareError> {
    let result = compare(&direct_regression::alone(model, dof), std::slice::from_ref(run), &CompareOptions::default())?;
    Ok(result.runs.iter().find(|r| r.dof == dof).map_or(f64::NAN, |r| r.mean_abs))
}

/// The staged procedure beside the direct regression (30), for each zig-zag.
fn twins(
    ready: &[Run],
    model: &Model,
    result: &StagedResult,
    options: &StagedOptions,
    tank: &PaperCampaign,
) -> Result<Vec<Twins>, DemoError> {
    let mut all = Vec::new();
    for run in ready.iter().filter(|run| run.kind == RunKind::Zigzag) {
        let own = result.stages.iter().find(|s| s.dof == Dof::Yaw && s.runs == [run.name.clone()]);
        let staged_model = own.map_or_else(|| result.model.clone(), |stage| with_stage(&result.model, stage));
        let (stage, at_once) = direct_regression::direct(Dof::Yaw, &[run], model, options)?;
        let at_once = with_others(&staged_model, &at_once, &stage);
        let values = stage
            .estimates
            .iter()
            .map(|e| {
                let staged_value =
                    staged_model.parameters.iter().find(|p| p.effect == e.effect && p.spec.name == e.name);
                let term = if e.dof.is_empty() { e.effect.clone() } else { format!("{}@{}", e.effect, e.dof) };
                let staged_value = staged_value.map_or(f64::NAN, |p| p.value);
                (e.name.clone(), staged_value, e.value, e.std, truth_in(tank, &run.name, &term))
            })
            .collect();
        all.push(Twins {
            run: run.name.clone(),
            values,
            staged_error: mean_abs(&staged_model, run, Dof::Yaw)?,
            twin_error: mean_abs(&at_once, run, Dof::Yaw)?,
        });
    }
    Ok(all)
}

/// The staged model with the estimates of the direct regression; all other parameters are the same.
fn with_others(staged: &Model, twin: &Model, stage: &Stage) -> Model {
    let mut model = staged.clone();
    let named = |effect: &str, name: &str| stage.estimates.iter().any(|e| e.effect == effect && e.name == name);
    for (p, q) in model.parameters.iter_mut().zip(&twin.parameters) {
        if named(&p.effect, &p.spec.name) {
            p.value = q.value;
        }
    }
    model
}
