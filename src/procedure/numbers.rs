//! Flow numbers of an oscillatory run.
//!
//! ```text
//! Re = U_m L_c/ν   KC = U_m T/L_c   λ = Σ|f_D| / Σ|f_I|   C_m = (m − m_dry)/(ρ∇)        (22), (23)
//! ```
//!
//! U_m: greatest speed, m/s (rad/s times L_c in rotation); L_c: characteristic length, m; ν:
//! kinematic viscosity, m²/s; T: period, s; f_D, f_I: drag and inertia force, N. Avila et al.
//! (2013).

use serde::Serialize;

use crate::chain::{Nature, nature};
use crate::effects::id;
use crate::estimate::{Components, RegressorError, force_components};
use crate::frame::Dof;
use crate::model::Model;
use crate::run::{Run, Signal};
use crate::vehicle::{Vehicle, Water};

/// Flow numbers; those that need unknown vehicle data are absent.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct FlowNumbers {
    /// Period of the command, s.
    pub period: f64,
    /// Greatest speed over the last cycle, m/s or rad/s.
    pub greatest_speed: f64,
    /// Re, 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reynolds: Option<f64>,
    /// KC, 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub keulegan_carpenter: Option<f64>,
    /// λ: drag over inertia, 1.
    pub lambda: f64,
    /// C_m, 1; translations only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub inertia_coefficient: Option<f64>,
}

/// Flow numbers of `run` (number `index`) in `dof` with `model`, over the last cycle; `None`
/// without a periodic command.
///
/// The inertia force is the sum of all other forces: no acceleration is measured or differentiated.
///
/// # Errors
/// [`RegressorError`] if the balance reads a channel that is not logged.
pub fn flow_numbers(
    run: &Run,
    index: usize,
    dof: Dof,
    model: &Model,
    vehicle: &Vehicle,
    water: &Water,
) -> Result<Option<FlowNumbers>, RegressorError> {
    let Some(period) = run.signal(dof.force()).and_then(period_of) else { return Ok(None) };
    let parts = force_components(dof, run, index, model)?;
    let Some(end) = parts.time.last() else { return Ok(None) };
    let first = parts.time.partition_point(|t| *t < end - period);
    let greatest_speed = parts.velocity[first..].iter().fold(0.0_f64, |a, v| a.max(v.abs()));
    let length = vehicle.characteristic_length();
    let arm = |l: f64| if dof.is_rotation() { greatest_speed * l } else { greatest_speed };
    let inertia_coefficient = (!dof.is_rotation())
        .then(|| Some((model.value_at(id::INERTIA, dof)? - vehicle.mass?) / (water.density * vehicle.volume?)));
    Ok(Some(FlowNumbers {
        period,
        greatest_speed,
        reynolds: length.map(|l| arm(l) * l / water.kinematic_viscosity),
        keulegan_carpenter: length.map(|l| arm(l) * period / l),
        lambda: drag_over_inertia(&parts, first, model),
        inertia_coefficient: inertia_coefficient.flatten(),
    }))
}

/// λ, from the sample `first` on.
fn drag_over_inertia(parts: &Components, first: usize, model: &Model) -> f64 {
    let is_drag = |name: &str| model.term(name).is_some_and(|t| nature(model, &model.terms[t]) == Nature::Drag);
    let size = |f: &[f64]| f[first..].iter().map(|f| f.abs()).sum::<f64>();
    size(&parts.sum_of(is_drag)) / size(&parts.total())
}

/// Period of a signal, s: mean time between its upward crossings of its mean value; `None` with
/// fewer than two.
pub fn period_of(signal: &Signal) -> Option<f64> {
    let (time, x) = (signal.time(), signal.values());
    let mean = x.iter().sum::<f64>() / x.len() as f64;
    let scatter = (x.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / x.len() as f64).sqrt();
    let mut crossings = Vec::new();
    let mut low = false;
    for k in 1..x.len() {
        low |= x[k - 1] < mean - 0.3 * scatter;
        if low && x[k - 1] < mean && x[k] >= mean {
            crossings.push(time[k - 1] + (time[k] - time[k - 1]) * (mean - x[k - 1]) / (x[k] - x[k - 1]));
            low = false;
        }
    }
    let cycles = crossings.len().checked_sub(1).filter(|n| *n > 0)?;
    Some((crossings[cycles] - crossings[0]) / cycles as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_period_of_a_sampled_sine_is_found() {
        let time: Vec<f64> = (0..300).map(|k| 0.1 * f64::from(k)).collect();
        let x: Vec<f64> = time.iter().map(|t| 185.7 + 145.3 * (std::f64::consts::TAU * t / 8.0).sin()).collect();
        let period = period_of(&Signal::new(time.clone().into(), x)).unwrap();
        // a straight line between samples of a sine: crossings of a mean that is off by an incomplete cycle
        assert!((period - 8.0).abs() < 0.01, "{period}");
        assert_eq!(period_of(&Signal::new(time.into(), vec![3.0; 300])), None);
    }
}
