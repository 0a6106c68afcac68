//! Longest stable step in a target that integrates the velocities explicitly, and growing motions
//! of a linear model.
//!
//! ```text
//! J(ν) = M⁻¹ ∂f/∂ν,   ν ← ν + h J ν shrinks for h < −2 Re λ / |λ|² of every eigenvalue λ of J with Re λ < 0
//! ```
//!
//! f: damping, products and Coriolis forces, at the corners of the speeds of the fit (m/s, rad/s).
//! A motion that grows in the model also grows in the target and limits no step. If added mass is a
//! force from an earlier acceleration, steps have to be shorter: [`with_late_added_mass`]. If
//! angles, too, are integrated explicitly with the velocities before the step, a righting moment
//! makes a motion oscillate with growing amplitude unless its damping exceeds what the step adds:
//! [`longest_step_of_angles`].

use std::collections::BTreeMap;

use nalgebra::{Complex, DMatrix, Matrix6, Matrix6x2, Vector6};

use super::body::Parts;
use super::coefficients::{Coefficients, Restoring};
use super::number::number;
use crate::eigenvalues::eigenvalues;
use crate::frame::Dof;

/// Speed of a degree of freedom if the envelope of the model does not contain it, m/s and rad/s.
const SPEED: f64 = 1.0;

/// The longest stable step of Euler's explicit rule, s; infinite without damping.
pub(super) fn longest_step(found: &Coefficients, parts: &Parts, envelope: &BTreeMap<String, [f64; 2]>) -> f64 {
    let Some(inverse) = inverse_inertia(parts) else { return 0.0 };
    corners(found, envelope)
        .map(|nu| {
            let jacobian = inverse * slope(found, &nu);
            shrinking(&DMatrix::from_fn(6, 6, |i, j| jacobian[(i, j)]))
        })
        .fold(f64::INFINITY, f64::min)
}

/// The longest stable step, s, of Euler's explicit rule for the velocities and for roll and pitch,
/// which use the velocities before the step.
///
/// ```text
/// d/dt (φ, θ, ν) = [0 E; M⁻¹G  J] (φ, θ, ν),   G = ∂g/∂(φ, θ) and E ν = (p, q), upright
/// ```
///
/// Evaluated at rest too, where damping is least.
pub(super) fn longest_step_of_angles(
    found: &Coefficients,
    parts: &Parts,
    envelope: &BTreeMap<String, [f64; 2]>,
) -> f64 {
    let Some(inverse) = inverse_inertia(parts) else { return 0.0 };
    let righting = inverse * upright(found);
    corners(found, envelope)
        .chain([[0.0; 6]])
        .map(|nu| {
            let jacobian = inverse * slope(found, &nu);
            shrinking(&DMatrix::from_fn(8, 8, |i, j| match (i, j) {
                (0, 5) | (1, 6) => 1.0,
                (0 | 1, _) => 0.0,
                (i, 0 | 1) => righting[(i - 2, j)],
                (i, j) => jacobian[(i - 2, j - 2)],
            }))
        })
        .fold(f64::INFINITY, f64::min)
}

/// ∂g/∂(φ, θ) at φ = θ = 0.
fn upright(found: &Coefficients) -> Matrix6x2<f64> {
    let Restoring { net_weight, righting, trim } = found.restoring;
    let by_roll = Vector6::new(0.0, net_weight[1], 0.0, -righting[0], 0.0, trim[0]);
    let by_pitch = Vector6::new(-net_weight[0], 0.0, 0.0, 0.0, -righting[1], trim[1]);
    Matrix6x2::from_columns(&[by_roll, by_pitch])
}

fn inverse_inertia(parts: &Parts) -> Option<Matrix6<f64>> {
    Matrix6::from_fn(|i, j| parts.body.matrix()[i][j] + parts.added[i][j]).try_inverse()
}

/// The corners of the speeds of the fit, m/s and rad/s.
fn corners(found: &Coefficients, envelope: &BTreeMap<String, [f64; 2]>) -> impl Iterator<Item = [f64; 6]> {
    let reach = |dof: Dof| {
        let known = envelope.get(dof.velocity()).map_or(SPEED, |[low, high]| low.abs().max(high.abs()));
        if found.dofs.contains(&dof) { known } else { 0.0 }
    };
    let reaches = Dof::ALL.map(reach);
    (0..64_u32).map(move |corner| std::array::from_fn(|i| if corner >> i & 1 == 1 { -reaches[i] } else { reaches[i] }))
}

/// The longest step with which Euler's explicit rule damps every motion that ẋ = J x damps, s.
fn shrinking(jacobian: &DMatrix<f64>) -> f64 {
    // if the eigenvalues are not found: none is greater than the norm
    let unknown = || vec![Complex::new(-jacobian.norm(), 0.0)];
    let values = eigenvalues(jacobian).unwrap_or_else(unknown);
    let damped = values.iter().filter(|value| value.re < -1e-9);
    damped.map(|value| -2.0 * value.re / value.norm_sqr()).fold(f64::INFINITY, f64::min)
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

/// The longest step of Euler's rule if added mass is applied as a force from the acceleration of
/// the previous step.
///
/// ```text
/// m aₖ₊₁ = −d νₖ − s m âₖ,   âₖ = w aₖ + (1 − w) âₖ₋₁:   h < (1 − s/s_max) 2m/d,   s_max = (2 − w)/w
/// ```
///
/// `longest` is the step for the whole inertia, 2m (1 + s)/d. s: ratio of added to rigid inertia;
/// w: weight of the newest acceleration, 1 without a filter. The limit follows from the root z = −1
/// of the characteristic polynomial for one degree of freedom.
pub(super) fn with_late_added_mass(longest: f64, share: f64, most: f64) -> f64 {
    let share = share.max(0.0);
    longest * (1.0 - share / most).max(0.0) / (1.0 + share)
}

/// The longest step in words.
pub(super) fn told(longest: f64) -> String {
    if longest.is_finite() {
        format!(
            "explicit Euler damps what the model damps for steps below {} s at the speeds of the fit",
            digits(longest)
        )
    } else {
        "nothing is damped, so no step of explicit Euler is stable; use a Runge-Kutta scheme".into()
    }
}

/// The longest steps in words, if the integration may also step the angles with the velocities
/// before the step.
pub(super) fn told_with_angles(longest: f64, of_angles: f64) -> String {
    let velocities = told(longest);
    if of_angles >= longest {
        return velocities;
    }
    format!(
        "{velocities}, and below {} s if the angles are stepped with the velocities of the previous step",
        digits(of_angles)
    )
}

/// Three significant digits.
fn digits(x: f64) -> String {
    number(format!("{x:.2e}").parse().unwrap_or(x))
}

/// The behaviour of ẋ = A x from the eigenvalues of A (by rows), in words.
pub(super) fn spectrum(a: &[Vec<f64>]) -> String {
    let matrix = DMatrix::from_fn(a.len(), a.len(), |i, j| a[i][j]);
    let size = matrix.amax();
    if a.is_empty() || size == 0.0 {
        return "A is 0: states stay constant".into();
    }
    let Some(mut values) = eigenvalues(&matrix) else {
        return "the eigenvalues of A could not be computed".into();
    };
    values.sort_by(|x, y| x.re.total_cmp(&y.re).then(x.im.total_cmp(&y.im)));
    // an eigenvalue of a defective matrix is known to the square root of the rounding
    let still = size * 1e-8;
    let word = |value: &Complex<f64>| match value.im {
        im if im > 0.0 => Some(format!("{} +- {}i", digits(value.re), digits(im))),
        im if im < 0.0 => None,
        _ if value.re.abs() < still => Some("0".into()),
        _ => Some(digits(value.re)),
    };
    let words: Vec<String> = values.iter().filter_map(word).collect();
    let grow = values.iter().filter(|value| value.re > still).count();
    let stay = values.iter().filter(|value| value.re.abs() <= still).count();
    let verdict = match (grow, stay) {
        (0, 0) => "all modes decay".to_string(),
        (0, _) => format!("{stay} stay constant, the others decay"),
        _ => format!("UNSTABLE at this point: {grow} grow"),
    };
    format!("eigenvalues of A (1/s) {}: {verdict}", words.join(", "))
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

    /// Whether I φ̈ = −d φ̇ − k φ with I = 30 comes to rest if φ is stepped with the rate before the
    /// step.
    fn comes_upright(d: f64, k: f64, h: f64) -> bool {
        let (mut phi, mut p) = (0.1_f64, 0.0);
        for _ in 0..200_000 {
            (phi, p) = (phi + h * p, p + h * (-d * p - k * phi) / 30.0);
        }
        phi.abs() < 1e-3
    }

    #[test]
    fn a_righting_moment_shortens_the_step_of_angles_as_the_scheme_itself_does() {
        let names = ["inertia", "linear_drag", "restoring_roll"];
        let mut model = Model::with_effects(&[Dof::Roll], Coriolis::Tied, &names).unwrap();
        for (name, x) in [("inertia@roll", 30.0), ("linear_drag@roll", 12.0), ("restoring_roll", 1600.0)] {
            model.set(name, x);
        }
        let found = coefficients(&model);
        let vehicle = Vehicle { mass: Some(150.0), ..Vehicle::default() };
        let options = ExportOptions { inertia: Some([30.0; 3]), ..ExportOptions::default() };
        let parts = split(&found, &vehicle, &options, &mut Vec::new()).unwrap();
        let [longest, of_angles] = [longest_step, longest_step_of_angles].map(|f| f(&found, &parts, &BTreeMap::new()));
        // −2 Re λ / |λ|² of λ² + (d/I) λ + k/I = 0: d/k; for the velocities alone 2 I/d
        assert!((of_angles - 12.0 / 1600.0).abs() < 1e-9, "{of_angles}");
        assert!((longest - 5.0).abs() < 1e-9, "{longest}");
        assert!(comes_upright(12.0, 1600.0, 0.9 * of_angles) && !comes_upright(12.0, 1600.0, 1.1 * of_angles));
        let words = told_with_angles(longest, of_angles);
        assert!(words.contains("below 5 s at the speeds of the fit, and below 0.0075 s if the angles"), "{words}");
        assert_eq!(told_with_angles(1.0, 2.0), told(1.0));
    }

    /// Whether the scheme of [`with_late_added_mass`] comes to rest for m = 1.
    fn comes_to_rest(drag: f64, share: f64, weight: f64, h: f64) -> bool {
        let (mut v, mut last, mut filtered) = (1.0_f64, 0.0, 0.0);
        for _ in 0..20_000 {
            filtered = weight * last + (1.0 - weight) * filtered;
            last = -drag * v - share * filtered;
            v += h * last;
        }
        v.abs() < 1e-3
    }

    #[test]
    fn late_added_mass_shortens_the_step_as_the_scheme_itself_does() {
        for (weight, share) in [(1.0, 0.1), (1.0, 0.7), (0.3, 0.5), (0.3, 3.0)] {
            let (drag, most) = (4.0, (2.0 - weight) / weight);
            let longest = with_late_added_mass(2.0 * (1.0 + share) / drag, share, most);
            assert!(comes_to_rest(drag, share, weight, 0.98 * longest), "{weight} {share} {longest}");
            assert!(!comes_to_rest(drag, share, weight, 1.02 * longest), "{weight} {share} {longest}");
        }
        assert_eq!(with_late_added_mass(1.0, 1.2, 1.0).to_bits(), 0.0_f64.to_bits());
    }

    #[test]
    fn eigenvalues_are_told_with_what_grows() {
        let told = spectrum(&[vec![-0.5, 0.0, 0.0], vec![0.0, -0.1, 2.0], vec![0.0, -2.0, -0.1]]);
        assert_eq!(told, "eigenvalues of A (1/s) -0.5, -0.1 +- 2i: all modes decay");
        let told = spectrum(&[vec![-0.5, 0.0], vec![1.0, 0.0]]);
        assert_eq!(told, "eigenvalues of A (1/s) -0.5, 0: 1 stay constant, the others decay");
        assert!(spectrum(&[vec![0.25]]).ends_with("0.25: UNSTABLE at this point: 1 grow"));
        assert!(spectrum(&[vec![0.0]]).contains("A is 0"));
    }
}
