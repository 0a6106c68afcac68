//! Stage (iii): inertia, coupling, bias, and in the zig-zag the Munk coefficient, with drag held.
//!
//! ```text
//! oscillatory:  u̇ = a₁ q̇ + a₂ R + a₃,   a₁ = −X_q̇/m_u, a₂ = 1/m_u, a₃ = −b/m_u              (20), (21), (26), (27)
//! zig-zag:      ṙ = a₁ u v + a₂ R + a₃,  a₁ = −k_uv/I_r, a₂ = 1/I_r, a₃ = −b/I_r              (28), (29)
//! R = τ − drag with the coefficients of stage (ii)
//! ```
//!
//! In integral form, per unit inertia; the parameters follow from the fitted ratios by the delta method, and what the
//! held drag leaves uncertain is carried on. Rows stand on the stamps of the own velocity; u and v of a slower sensor
//! are straight lines between their samples. Each run has a stage of its own, and all runs together one more.

use super::held::Held;
use super::numbers::flow_numbers;
use super::result::Stage;
use super::{Bench, ProcedureError, StagedOptions, codes, parameters_at};
use crate::effects::Coriolis;
use crate::estimate::RowFit;
use crate::finding::Finding;
use crate::frame::Dof;
use crate::model::Model;
use crate::run::Run;

/// What stands in the balance of a kind of run besides inertia and bias.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// Motion in one degree of freedom.
    Oscillatory,
    /// Turning with speed.
    Zigzag,
}

impl Kind {
    fn name(self) -> &'static str {
        match self {
            Kind::Oscillatory => "oscillatory",
            Kind::Zigzag => "zigzag",
        }
    }

    /// Parameters to estimate in `dof`.
    pub fn free(self, model: &Model, dof: Dof, held: &Held) -> Vec<usize> {
        let coriolis = match model.coriolis {
            Coriolis::Free => parameters_of_term(model, &format!("coriolis_{dof}")),
            // tied: k_uv = m_v − m_u, and the mass in sway is found in yaw where no run of its own has shown it
            Coriolis::Tied if dof == Dof::Yaw => {
                parameters_at(model, Dof::Sway, &["inertia"]).into_iter().filter(|p| !held.has(*p)).collect()
            }
            Coriolis::Tied => Vec::new(),
        };
        match self {
            Kind::Oscillatory => parameters_at(model, dof, &MOMENTUM_AND_BIAS),
            Kind::Zigzag => [parameters_at(model, dof, &MOMENTUM_AND_BIAS), coriolis].concat(),
        }
    }
}

/// What a run in one degree of freedom shows when its drag is held.
const MOMENTUM_AND_BIAS: [&str; 3] = ["inertia", "added_mass_coupling", "bias"];

fn parameters_of_term(model: &Model, name: &str) -> Vec<usize> {
    let all = model.term(name).map(|t| model.terms[t].parameters.clone()).unwrap_or_default();
    all.into_iter().filter(|p| !model.parameters[*p].fixed).collect()
}

/// Stages of each run and of all together; the fit is that of all.
pub(super) fn stages(
    kind: Kind,
    dof: Dof,
    runs: &[&Run],
    model: &Model,
    held: &Held,
    bench: &Bench<'_>,
    options: &StagedOptions,
) -> Result<Result<(Vec<Stage>, RowFit), Finding>, ProcedureError> {
    let free = kind.free(model, dof, held);
    let how = (options.regressor, options.std);
    let mut stages = Vec::new();
    for run in runs {
        let fit = held.fit((dof, &[run]), model, &free, how, &|_| {});
        let fit = match ProcedureError::unless_data(kind.name(), dof, fit)? {
            Ok(fit) => fit,
            Err(finding) => return Ok(Err(finding.of_run(&run.name))),
        };
        let name = if runs.len() > 1 { format!("{} {}", kind.name(), run.name) } else { kind.name().to_string() };
        let mut stage = Stage::of_fit(name, dof, vec![run.name.clone()], model, &fit);
        if kind == Kind::Oscillatory {
            let mut of_run = held.written(model);
            fit.write_to(&mut of_run);
            stage.numbers = flow_numbers(run, 0, dof, &of_run, bench.vehicle, bench.water).ok().flatten();
        }
        if runs.len() == 1 {
            finish(kind, model, &mut stage);
            return Ok(Ok((vec![stage], fit)));
        }
        stages.push(stage);
    }
    // only several runs tell an inertia that grows with the amplitude
    let amplitude =
        if kind == Kind::Oscillatory { parameters_at(model, dof, &["added_mass_amplitude"]) } else { Vec::new() };
    let free = [free, amplitude].concat();
    let fit = match ProcedureError::unless_data(kind.name(), dof, held.fit((dof, runs), model, &free, how, &|_| {}))? {
        Ok(fit) => fit,
        Err(finding) => return Ok(Err(finding)),
    };
    let names = runs.iter().map(|r| r.name.clone()).collect();
    let mut stage = Stage::of_fit(kind.name(), dof, names, model, &fit);
    finish(kind, model, &mut stage);
    stages.push(stage);
    Ok(Ok((stages, fit)))
}

/// Says where the Munk coefficient is not the difference of the masses.
fn finish(kind: Kind, model: &Model, stage: &mut Stage) {
    let masses = (model.value("inertia@sway"), model.value("inertia@surge"));
    if let (Kind::Zigzag, (Some(m_v), Some(m_u)), Some(k)) = (kind, masses, stage.estimate("k_uv"))
        && m_v > 0.0
        && m_u > 0.0
        && (k.value - (m_v - m_u)).abs() > 3.0 * k.std
    {
        let text = format!(
            "k_uv is {:.1} ± {:.1} kg, the difference of the virtual masses {:.1} kg: reported as estimated",
            k.value,
            k.std,
            m_v - m_u
        );
        stage.warnings.push(Finding::new(&codes::MUNK, text));
    }
}
