//! How long a step may be in a target that steps the velocities explicitly.
//!
//! ```text
//! J(ν) = M⁻¹ ∂f/∂ν,   ν ← ν + h J ν shrinks for h < −2 Re λ / |λ|² of every eigenvalue λ of J with Re λ < 0
//! ```
//!
//! f: damping, products and Coriolis forces, at the corners of the speeds of the fit (m/s, rad/s); a motion that grows in
//! the model grows in the target too, and bounds no step.

use std::collections::BTreeMap;

use nalgebra::Matrix6;

use super::body::Parts;
use super::coefficients::Coefficients;
use super::number::number;
use crate::frame::Dof;

/// Speeds where the envelope of a model says none, m/s and rad/s.
const SPEED: f64 = 1.0;

/// The longest stable step of Euler's explicit rule, s; infinite without damping.
pub(super) fn longest_step(found: &Coefficients, parts: &Parts, envelope: &BTreeMap<String, [f64; 2]>) -> f64 {
    let inertia = Matrix6::from_fn(|i, j| parts.body.matrix()[i][j] + parts.added[i][j]);
    let Some(inverse) = inertia.try_inverse() else { return 0.0 };
    let reach = |dof: Dof| {
        let known = envelope.get(dof.velocity()).map_or(SPEED, |[low, high]| low.abs().max(high.abs()));
        if found.dofs.contains(&dof) { known } else { 0.0 }
    };
    let reaches = Dof::ALL.map(reach);
    let mut longest = f64::INFINITY;
    // the other half of the corners are these with all signs turned, whose products matter as much
    for corner in 0..64_u32 {
        let nu: [f64; 6] = std::array::from_fn(|i| if corner >> i & 1 == 1 { -reaches[i] } else { reaches[i] });
        for value in (inverse * slope(found, &nu)).complex_eigenvalues().iter().filter(|value| value.re < -1e-9) {
            longest = longest.min(-2.0 * value.re / value.norm_sqr());
        }
    }
    longest
}

/// ∂f/∂ν.
fn slope(found: &Coefficients, nu: &[f64; 6]) -> Matrix6<f64> {
    Matrix6::from_fn(|i, j| {
        let absolute =
            |k: usize| found.absolute[i][j][k] * nu[k].abs() + found.absolute[i][k][j] * nu[k] * nu[j].signum();
        let product = |k: usize| (found.product[i][j][k] + found.product[i][k][j]) * nu[k];
        found.linear[i][j] + (0..6).map(|k| absolute(k) + product(k)).sum::<f64>()
    })
}

/// The line of the heading.
pub(super) fn told(longest: f64) -> String {
    if longest.is_finite() {
        let digits = |x: f64| number(format!("{x:.2e}").parse().unwrap_or(x));
        format!(
            "Stability: explicit Euler shrinks what the model damps for steps below {} s at the speeds of the fit",
            digits(longest)
        )
    } else {
        "Stability: nothing is damped, so that no step of explicit Euler is stable; use a Runge-Kutta scheme".into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Coriolis;
    use crate::export::coefficients::coefficients;
    use crate::export::{ExportOptions, body::split};
    use crate::model::Model;
    use crate::vehicle::Vehicle;

    #[test]
    fn one_degree_of_freedom_is_that_by_hand() {
        let mut model =
            Model::with_effects(&[Dof::Surge], Coriolis::Tied, &["inertia", "linear_drag", "quadratic_drag"]).unwrap();
        for (name, x) in [("inertia@surge", 200.0), ("linear_drag@surge", 20.0), ("quadratic_drag@surge", 100.0)] {
            model.set(name, x);
        }
        let found = coefficients(&model);
        let vehicle = Vehicle { mass: Some(150.0), ..Vehicle::default() };
        let options = ExportOptions { inertia: Some([1.0; 3]), ..ExportOptions::default() };
        let parts = split(&found, &vehicle, &options, &mut Vec::new()).unwrap();
        let envelope = BTreeMap::from([("u".to_string(), [-0.3, 0.9])]);
        // 2 m / (d + 2 d_q |u|)
        let longest = longest_step(&found, &parts, &envelope);
        assert!((longest - 400.0 / (20.0 + 180.0)).abs() < 1e-9, "{longest}");
        assert!(told(longest).contains("below 2 s"));
    }
}
