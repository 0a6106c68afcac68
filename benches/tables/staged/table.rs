//! Comparison of the staged procedure with the truth of the virtual tank: one entry for each
//! estimate, and one for each all-at-once twin.
//!
//! An estimate is compared with the truth of the run of its stage, or of its runs if they share one
//! truth. A value of the twin is absurd if it is a negative drag coefficient, or if it differs from
//! its truth by more than three of its own standard deviations and by more than half of the truth.

use hydrosysid::compare::{CompareOptions, compare};
use hydrosysid::effects::Coriolis;
use hydrosysid::frame::Dof;
use hydrosysid::model::Model;
use hydrosysid::procedure::direct_regression::{alone, direct};
use hydrosysid::procedure::{Bench, Estimate, Stage, StagedOptions, StagedResult, made_ready, staged};
use hydrosysid::run::{Run, RunKind};
use hydrosysid::tank::PaperCampaign;
use hydrosysid::thrust::advance::AdvanceLoss;
use hydrosysid::thrust::efficiency::Efficiency;
use hydrosysid::vehicle::Water;

/// One estimate, and the truth of its run.
pub struct Entry {
    pub dof: Dof,
    pub stage: String,
    pub name: String,
    pub truth: f64,
    pub value: f64,
    pub std: f64,
}

impl Entry {
    /// Whether the truth is within two reported standard deviations.
    pub fn holds(&self) -> bool {
        (self.value - self.truth).abs() <= 2.0 * self.std
    }
}

/// The all-at-once twin of one zig-zag.
pub struct Twin {
    pub run: String,
    /// Mean |measured − simulated| of r by the staged balance of yaw, (29), with u and v as logged, rad/s.
    pub staged_error: f64,
    /// The same by the balance of the twin, (30), rad/s.
    pub twin_error: f64,
    /// Both errors when surge and sway are simulated too, by the staged model of the run.
    pub in_the_plane: (f64, f64),
    /// cond(HᵀH) of the staged fit and of the twin.
    pub condition: (f64, f64),
    /// Absurd values as text.
    pub absurd: Vec<String>,
    /// Whether one of them is a negative drag.
    pub negative: bool,
}

/// The baseline model of the campaign, with W − B fixed at its weighed value.
pub fn model(campaign: &PaperCampaign) -> Model {
    let effects: Vec<&str> = campaign.baseline.iter().map(String::as_str).collect();
    let mut model = Model::with_effects(&campaign.dofs, Coriolis::Free, &effects).expect("the baseline is a model");
    model.set("restoring_surge", campaign.net_weight);
    let net_weight = model.parameter_of("restoring_surge").expect("it is in the baseline");
    model.parameters[net_weight].fixed = true;
    model
}

fn efficiency() -> Efficiency {
    Efficiency { eta_adv: Some(AdvanceLoss::PAPER), ..Efficiency::default() }
}

/// The staged procedure on the campaign.
pub fn fit(campaign: &PaperCampaign, options: &StagedOptions) -> StagedResult {
    let bench = Bench {
        vehicle: &campaign.vehicle,
        water: &Water::default(),
        efficiency: &efficiency(),
        thrusters: &[],
        curves: &[],
    };
    staged(&campaign.runs, &model(campaign), bench, options).expect("the paper's campaign can be fitted")
}

fn term(estimate: &Estimate) -> String {
    match estimate.dof.as_str() {
        "" => estimate.effect.clone(),
        dof => format!("{}@{}", estimate.effect, dof),
    }
}

/// The true value of an estimate in the run of its stage; for anticlockwise turns the drag is that
/// of Table 7.
fn truth(campaign: &PaperCampaign, stage: &Stage, estimate: &Estimate) -> Option<f64> {
    match (stage.name.as_str(), estimate.effect.as_str()) {
        ("steady anticlockwise", "linear_drag") => return Some(18.21),
        ("steady anticlockwise", "quadratic_drag") => return Some(94.72),
        _ => {}
    }
    let run = campaign.runs.iter().position(|r| r.name == stage.runs[0])?;
    campaign.truths[run].value(&term(estimate))
}

/// Whether all runs of a stage share one truth: stages with a single run, steady ones and towing,
/// but not both directions of yaw together.
fn has_one_truth(stage: &Stage) -> bool {
    let together = stage.name == "steady" && stage.dof == Dof::Yaw;
    (stage.runs.len() == 1 || stage.name.starts_with("steady") || stage.name == "towing") && !together
}

/// An entry for every estimate that has a true value.
pub fn entries(campaign: &PaperCampaign, result: &StagedResult) -> Vec<Entry> {
    let of_stage = |stage: &Stage| -> Vec<Entry> {
        // runs of one kind share a row of the table
        let kind = if stage.runs.len() == 1 { stage.name.split(' ').next() } else { None };
        let entry = |e: &Estimate| {
            Some(Entry {
                dof: stage.dof,
                stage: kind.map_or_else(|| stage.name.clone(), str::to_string),
                name: e.name.clone(),
                truth: truth(campaign, stage, e)?,
                value: e.value,
                std: e.std,
            })
        };
        stage.estimates.iter().filter_map(entry).collect()
    };
    result.stages.iter().filter(|s| has_one_truth(s)).flat_map(of_stage).collect()
}

/// Mean |measured − simulated| of r over a run, (25), in rad/s.
pub fn error_of(model: &Model, run: &Run) -> f64 {
    let result = compare(model, std::slice::from_ref(run), &CompareOptions::default()).expect("the model simulates");
    result.runs.iter().find(|r| r.dof == Dof::Yaw).map_or(f64::NAN, |r| r.mean_abs)
}

fn written(model: &Model, stage: &Stage) -> Model {
    let mut own = model.clone();
    for e in &stage.estimates {
        assert!(own.set(&term(e), e.value), "{} is in the model", term(e));
    }
    own
}

/// The twin of each zig-zag.
pub fn twins(campaign: &PaperCampaign, result: &StagedResult, options: &StagedOptions) -> Vec<Twin> {
    let ready = made_ready(&campaign.runs, &model(campaign), &result.efficiency, &[], options).expect("as for the fit");
    let twin = |run: &Run| {
        let stage = result.stages.iter().find(|s| s.dof == Dof::Yaw && s.runs == [run.name.clone()])?;
        let of_this = result.stages.iter().filter(|s| s.runs == [run.name.clone()]);
        let of_run = of_this.fold(result.model.clone(), |model, stage| written(&model, stage));
        let (twin, model_of_twin) = direct(Dof::Yaw, &[run], &of_run, options).ok()?;
        let yaw = |model: &Model| error_of(&alone(model, Dof::Yaw), run);
        let mut absurd = Vec::new();
        let mut negative = false;
        for e in &twin.estimates {
            let drag = ["linear_drag", "quadratic_drag"].contains(&e.effect.as_str()) && e.value < 0.0;
            let judged = ["linear_drag", "quadratic_drag", "inertia", "coriolis_yaw"].contains(&e.effect.as_str());
            let far = truth(campaign, &twin, e)
                .is_some_and(|t| (e.value - t).abs() > 3.0 * e.std && (e.value - t).abs() > 0.5 * t.abs());
            if drag || (judged && far) {
                absurd.push(format!("{} = {:.1}", e.name, e.value));
            }
            negative |= drag;
        }
        Some(Twin {
            run: run.name.clone(),
            staged_error: yaw(&of_run),
            twin_error: yaw(&model_of_twin),
            in_the_plane: (error_of(&of_run, run), error_of(&model_of_twin, run)),
            condition: (stage.condition_number, twin.condition_number),
            absurd,
            negative,
        })
    };
    ready.iter().filter(|r| r.kind == RunKind::Zigzag).filter_map(twin).collect()
}
