//! The result of the verb `fit`: plain data, as in `fit --json`.

use std::collections::BTreeMap;

use serde::Serialize;

use super::residuals::Residuals;
use crate::campaign::codes;
use crate::campaign::file::Estimator;
use crate::campaign::identifiability::Identifiability;
use crate::campaign::model_noise::ModelNoise;
use crate::campaign::noise::Noise;
use crate::campaign::thrusters::FittedCurve;
use crate::check::codes::AT_REST;
use crate::check::commands::MISPLACED;
use crate::effects::{Place, id};
use crate::envelope::Envelope;
use crate::finding::Finding;
use crate::frame::Dof;
use crate::model::{Model, Parameter};
use crate::plan::Instruments;
use crate::procedure::sensitivity::Setting;
use crate::procedure::{Estimate, FlowNumbers, Stage};
use crate::run::Run;
use crate::thrust::efficiency::Efficiency;
use crate::vehicle::Vehicle;
use crate::wording::by_run;

/// A fitted campaign. Serialises as `hydrosysid fit --json`.
#[derive(Debug, Clone, Serialize)]
pub struct Fit {
    /// Format of the result: 1.
    pub format: u32,
    /// The verdict.
    pub sentence: String,
    /// Whether the estimator reached its maximum.
    pub converged: bool,
    /// Parameters, in the order of the model.
    pub parameters: Vec<FitParameter>,
    /// The estimator.
    pub estimator: Estimator,
    /// Method of `std`.
    pub std_method: String,
    /// Covariance in the order of `parameters`, SI; 0 for those that were held.
    pub covariance: Vec<Vec<f64>>,
    /// Fits that it consists of.
    pub stages: Vec<FitStage>,
    /// Thruster curves that were fitted to bollard tables.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub thrusters: Vec<FittedCurve>,
    /// Random force, sensor noise and prediction errors; of filter error only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise: Option<Noise>,
    /// What the data can determine and what it cannot; absent for a streamed fit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub identifiability: Option<Identifiability>,
    /// Dependence of the estimates on window and degree of a polynomial filter, if
    /// [`filters`](super::filters) was called.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub filters: Vec<Setting>,
    /// Findings for the user.
    pub warnings: Vec<Finding>,
    /// Residuals of the training runs; none for the staged procedure, whose stages have rows of
    /// their own, and for a streamed fit.
    #[serde(skip)]
    pub residuals: Vec<Residuals>,
    /// The model with the estimates in place.
    #[serde(skip)]
    pub model: Model,
    /// Losses of thrust for which the values hold: those of the campaign, and those that bollard
    /// runs have shown.
    #[serde(skip)]
    pub efficiency: Efficiency,
    /// Speeds, angles, forces and amplitudes of the runs that took part.
    #[serde(skip)]
    pub envelope: Envelope,
    /// Noise and rate of the channels that the model predicts, in the runs that took part.
    #[serde(skip)]
    pub instruments: Instruments,
}

impl Fit {
    /// Returns the noise for a model file.
    pub fn model_noise(&self) -> Option<ModelNoise> {
        self.noise.as_ref().map(ModelNoise::from)
    }

    /// Whether nothing moves in the runs of the fit, so that its numbers come from noise.
    pub fn is_at_rest(&self) -> bool {
        self.warnings.iter().any(|w| w.code == AT_REST.code)
    }

    /// Whether the thrusters, as they are placed, push the wrong way (M142): the campaign is wrong,
    /// and no effect is missing.
    pub fn is_misplaced(&self) -> bool {
        self.warnings.iter().any(|w| w.code == codes::CONTRADICTED.code && w.message.contains(MISPLACED))
    }

    /// Whether an effect may be missing: predictions err more than they should, innovations follow
    /// an effect, the log contradicts itself, or the random force is more than turbulence.
    pub fn may_lack(&self) -> bool {
        let pushed = self.noise.as_ref().is_some_and(Noise::is_more_than_turbulence);
        let asks = [codes::MORE_MISSING.code, codes::LACKING.code, codes::CONTRADICTED.code];
        pushed || self.warnings.iter().any(|w| asks.contains(&w.code))
    }
}

/// One parameter of a fit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FitParameter {
    /// Id of the effect.
    pub effect: String,
    /// Degree of freedom of its balance; `null` for the whole vehicle.
    pub dof: Option<Dof>,
    /// The other degree of freedom of a coupling.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub other: Option<Dof>,
    /// Symbol.
    pub name: String,
    /// Value, SI.
    pub value: f64,
    /// Standard deviation, SI; 0 if it was held.
    pub std: Option<f64>,
    /// Standard deviation by the paper's (14), SI; `null` if no linear regressor contains it.
    pub std_paper: Option<f64>,
    /// Unit.
    pub unit: String,
    /// SNAME's name of the same quantity.
    pub sname: Option<String>,
    /// SNAME's value: the opposite sign; for an inertia and a coupling only the added part, without
    /// m and m r_g.
    pub sname_value: Option<f64>,
    /// Whether it was held fixed.
    pub fixed: bool,
    /// Values of a parameter that has its own in each run, by the name of the run.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub per_run: BTreeMap<String, f64>,
}

impl FitParameter {
    /// Returns `least to greatest by run` if each run has its own value; `told` writes a value in
    /// words.
    pub(crate) fn by_run(&self, told: impl Fn(f64) -> String) -> Option<String> {
        by_run(self.per_run.values().copied(), told)
    }
}

/// One fit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FitStage {
    /// Name of the fit or stage.
    pub name: String,
    /// Degree of freedom.
    pub dof: Dof,
    /// Names of the runs that took part.
    pub runs: Vec<String>,
    /// Number of rows or samples.
    pub rows: usize,
    /// Standard deviation of the residual, in the unit of what was fitted.
    pub residual_std: f64,
    /// cond(HᵀH), as the paper prints.
    pub condition_number: f64,
    /// cond(H) with columns of unit length.
    pub condition_number_scaled: f64,
    /// Estimates of this stage of the staged procedure; empty for other estimators, whose only fit
    /// is in `parameters`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub estimates: Vec<Estimate>,
    /// Covariance of `estimates`, in their order, SI.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub covariance: Vec<Vec<f64>>,
    /// Flow numbers of a single oscillatory run: Re, KC, λ, C_m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub numbers: Option<FlowNumbers>,
}

impl From<Stage> for FitStage {
    fn from(stage: Stage) -> FitStage {
        FitStage {
            name: stage.name,
            dof: stage.dof,
            runs: stage.runs,
            rows: stage.rows,
            residual_std: stage.residual_std,
            condition_number: stage.condition_number,
            condition_number_scaled: stage.condition_number_scaled,
            estimates: stage.estimates,
            covariance: stage.covariance,
            numbers: stage.numbers,
        }
    }
}

/// Returns the degree of freedom of an effect of the whole vehicle that is in one balance:
/// `coriolis_yaw` is of yaw.
pub(in crate::campaign) fn row_of(effect: &str, place: Place) -> Option<Dof> {
    place.dof.or_else(|| Dof::ALL.into_iter().find(|dof| effect.ends_with(&format!("_{dof}"))))
}

/// Returns one parameter for the result: its place, SNAME's name and value; `paper` is its standard
/// deviation by (14), `runs` are those of its values per run.
pub fn described(p: &Parameter, paper: Option<f64>, vehicle: &Vehicle, runs: &[Run]) -> FitParameter {
    let dry = match (p.effect.as_str(), p.place.dof, p.place.other) {
        (id::INERTIA, Some(dof), _) => vehicle.mass.filter(|_| !dof.is_rotation()),
        (id::ADDED_MASS_COUPLING, Some(dof), Some(other)) => vehicle.dry_coupling(dof, other),
        _ => Some(0.0),
    };
    // SNAME's N_ṙ and X_q̇ are the added part alone, which is unknown without the dry one
    let sname = p.spec.sname.clone().filter(|_| dry.is_some());
    FitParameter {
        effect: p.effect.clone(),
        dof: row_of(&p.effect, p.place),
        other: p.place.other,
        name: p.spec.name.clone(),
        value: p.value,
        std: if p.fixed { Some(0.0) } else { p.std },
        std_paper: if p.fixed { Some(0.0) } else { paper },
        unit: p.spec.dimension.to_string(),
        sname_value: sname.as_ref().and(dry).map(|dry| dry - p.value),
        sname,
        fixed: p.fixed,
        per_run: runs.iter().zip(&p.per_run).map(|(run, value)| (run.name.clone(), *value)).collect(),
    }
}
