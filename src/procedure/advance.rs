//! Stage (i), second part: loss of thrust by advance, from towing runs with the thrusters running.
//!
//! ```text
//! load = D(U) − η_inter η_adv(U) τ_nom     D: drag towed without thrust;  η_adv = slope U + intercept   (17)
//! ```
//!
//! One row per powered run: means over the run. The line is valid between the least and the
//! greatest speed of the rows. The uncertainty of the towed drag D is propagated through the line
//! to its coefficients:
//!
//! ```text
//! cov(slope, intercept) = own + J cov(D) Jᵀ        J = ∂(slope, intercept)/∂(k_Q, k_L, b)
//! ```
//!
//! Avila et al. (2013), eq. 16 and 17.

use std::sync::Arc;

use super::result::{Estimate, Stage};
use crate::chain::{Nature, nature};
use crate::effects::id;
use crate::estimate::{RegressorError, SteadyWindow, force_components, mean_of};
use crate::frame::Dof;
use crate::least_squares::least_squares;
use crate::model::{Model, Term};
use crate::run::{Run, Signal};
use crate::thrust::advance::{AdvanceFit, fit_advance};
use crate::thrust::efficiency::Efficiency;
use crate::thrust::thruster::Thruster;

/// Whether the thrusters run while the vehicle is towed.
pub fn is_powered(run: &Run, dof: Dof) -> bool {
    run.signal(dof.force()).is_some_and(|s| s.values().iter().any(|f| f.abs() > 0.0))
}

/// Drag of `model` in `dof` at speeds, N or N·m: all drags and the bias, the force with which a
/// carriage pulls.
///
/// # Errors
/// [`RegressorError`] if a drag reads a channel that a towed vehicle does not have.
pub fn towed_drag(model: &Model, dof: Dof, speeds: &[f64]) -> Result<Vec<f64>, RegressorError> {
    let time: Arc<[f64]> = (0..speeds.len()).map(|k| k as f64).collect();
    let mut run = Run::default();
    // straight ahead and level, without thrust
    for other in Dof::ALL {
        for name in [other.velocity(), other.position(), other.force()] {
            run.signals.insert(name.into(), Signal::new(time.clone(), vec![0.0; speeds.len()]));
        }
    }
    run.signals.insert(dof.velocity().into(), Signal::new(time, speeds.to_vec()));
    let pulled = |term: &&Term| term.effect.about().id == id::BIAS || nature(model, term) == Nature::Drag;
    let names: Vec<String> = model.terms.iter().filter(pulled).map(Term::name).collect();
    let forces = force_components(dof, &run, 0, model)?;
    Ok(forces.sum_of(|name| names.iter().any(|n| n == name)).into_iter().map(|force| -force).collect())
}

/// A line, its stage, and the covariance of slope and intercept.
pub(super) struct Line {
    pub fit: AdvanceFit,
    pub stage: Stage,
    pub covariance: [[f64; 2]; 2],
}

/// Speed and η_adv of each powered towing run of `dof`; `model` contains the drag that was found
/// without thrust.
fn rows(
    dof: Dof,
    runs: &[&Run],
    model: &Model,
    losses: &Efficiency,
    thrusters: &[Thruster],
) -> Result<(Vec<f64>, Vec<f64>), String> {
    let of = |run: &&Run| {
        let (from, to) = run.span()?;
        let mean = |name: &str| mean_of(run, name, SteadyWindow { from, to }).map(|m| m.value);
        let (speed, load, force) = (mean(dof.velocity())?, mean(dof.load())?, mean(dof.force())?);
        let group = super::effective_thrust::group(run, dof, thrusters);
        let names: Vec<&str> = group.iter().map(String::as_str).collect();
        Some((speed, load, losses.eta_inter.value(dof, &names) * force))
    };
    let means: Vec<(f64, f64, f64)> = runs.iter().filter_map(of).collect();
    let speeds: Vec<f64> = means.iter().map(|(speed, ..)| *speed).collect();
    let drags = towed_drag(model, dof, &speeds).map_err(|e| e.to_string())?;
    Ok(means.iter().zip(drags).map(|((speed, load, thrust), drag)| (speed.abs(), (drag - load) / thrust)).unzip())
}

/// Slope and intercept of η_adv. The error says what the data lacks.
pub(super) fn values(
    dof: Dof,
    runs: &[&Run],
    model: &Model,
    losses: &Efficiency,
    thrusters: &[Thruster],
) -> Result<Vec<f64>, String> {
    let (speed, eta) = rows(dof, runs, model, losses, thrusters)?;
    let fit = fit_advance(&speed, &eta).map_err(|e| e.to_string())?;
    Ok(vec![fit.slope.value, fit.intercept.value])
}

/// J: one row per quantity of the line, one column per parameter of `drag` (index and standard
/// deviation); by central differences.
pub(super) fn by_drag(
    dof: Dof,
    runs: &[&Run],
    model: &Model,
    (losses, thrusters): (&Efficiency, &[Thruster]),
    drag: &[(usize, f64)],
) -> Result<Vec<Vec<f64>>, String> {
    let mut jacobian = vec![vec![0.0; drag.len()]; 2];
    for (column, (parameter, std)) in drag.iter().enumerate().filter(|(_, (_, std))| *std > 0.0) {
        let at = |by: f64| {
            let mut model = model.clone();
            model.parameters[*parameter].value += by;
            values(dof, runs, &model, losses, thrusters)
        };
        for (row, (up, down)) in jacobian.iter_mut().zip(at(*std)?.into_iter().zip(at(-std)?)) {
            row[column] = (up - down) / (2.0 * std);
        }
    }
    Ok(jacobian)
}

/// η_adv from powered towing runs of `dof`; `model` contains the drag that was found without
/// thrust. The error says what the data lacks.
pub(super) fn stage(
    dof: Dof,
    runs: &[&Run],
    model: &Model,
    losses: &Efficiency,
    thrusters: &[Thruster],
) -> Result<Line, String> {
    let (speed, eta) = rows(dof, runs, model, losses, thrusters)?;
    let fit = fit_advance(&speed, &eta).map_err(|e| e.to_string())?;
    let linear = least_squares(&[&speed, &vec![1.0; speed.len()]], &eta).map_err(|e| e.to_string())?;
    let estimate = |name: &str, k: usize, unit: &str| Estimate {
        effect: id::THRUST_ADVANCE_LOSS.into(),
        dof: dof.to_string(),
        name: name.into(),
        value: linear.coefficients[k],
        std: linear.standard_errors[k],
        std_paper: linear.standard_errors[k],
        unit: unit.into(),
    };
    let stage = Stage {
        name: "advance".into(),
        dof,
        runs: runs.iter().map(|run| run.name.clone()).collect(),
        rows: speed.len(),
        residual_std: fit.residual_std,
        condition_number: linear.condition_number,
        condition_number_scaled: linear.condition_number_scaled,
        estimates: vec![estimate("slope", 0, "s/m"), estimate("intercept", 1, "1")],
        covariance: linear.covariance.clone(),
        numbers: None,
        warnings: Vec::new(),
    };
    let c = &linear.covariance;
    Ok(Line { fit, stage, covariance: [[c[0][0], c[0][1]], [c[1][0], c[1][1]]] })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Coriolis;

    /// All drags of the model are pulled; each sign of the speed has its own drag.
    #[test]
    fn exact_towed_drag_of_all_drags() {
        let effects =
            ["inertia", "linear_drag", "quadratic_drag", "cubic_drag@surge", "drag_asymmetry@surge", "bias@surge"];
        let mut model = Model::with_effects(&[Dof::Surge], Coriolis::Tied, &effects).expect("a model");
        for (name, value) in [
            ("inertia@surge", 300.0),
            ("linear_drag@surge", 20.0),
            ("quadratic_drag@surge", 100.0),
            ("cubic_drag@surge", 7.0),
            ("drag_asymmetry@surge", 11.0),
            ("bias@surge", 3.0),
        ] {
            assert!(model.set(name, value), "{name}");
        }
        // k_L u + k_Q u|u| + k_C u³ + b, and astern d u|u| more
        let drag = |u: f64| 20.0 * u + (100.0 + 11.0 * f64::from(u < 0.0)) * u * u.abs() + 7.0 * u.powi(3) + 3.0;
        let speeds = [0.5, 1.2, -0.7];
        for (found, speed) in towed_drag(&model, Dof::Surge, &speeds).expect("drags").iter().zip(speeds) {
            assert!((found - drag(speed)).abs() < 1e-10, "{found} at {speed}");
        }
    }
}
