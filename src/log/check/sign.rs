//! Check of signs: a quick decoupled fit shows whether inertia and drag are positive.
//!
//! For each degree of freedom with velocity ν and force τ, over windows [a, b] by the trapezoidal rule,
//!
//! ```text
//! m (ν(b) − ν(a)) + k ∫ν dt + k₂ ∫ν|ν| dt + e = ∫τ dt
//!
//! e = c ∫(product of the two other planar velocities) dt     in surge, sway and yaw
//!     g ∫sin(angle) dt                                       in roll and pitch
//!     0                                                      in heave, and without these velocities
//! ```
//!
//! m inertia (kg, kg m²), k and k₂ drag, c a free coefficient for the Coriolis term, g for the
//! righting moment: without it a vehicle with a righting moment that moves more slowly than its
//! natural period would show a negative inertia. Roll and pitch are not checked without the angle. A
//! vehicle has m > 0 and dissipates energy: k s + k₂ s² > 0 at its usual speed s. If the sign of ν or
//! of τ is reversed, m, k and k₂ come out with the opposite sign, and the fit is as good as before:
//! this check finds that. It reports only if the fit explains most of ∫τ dt and the sign is certain;
//! the estimate is not accurate enough for other use.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};

use super::super::codes;
use super::super::number::short;
use super::Seen;
use super::statistics::median;
use super::time::{gaps, usual_step};
use crate::frame::Dof;
use crate::run::Signal;

/// Length of a window, s: long compared with sensor noise, short compared with the motion.
const WINDOW: f64 = 0.5;
/// Least and greatest number of windows.
const WINDOWS: (usize, usize) = (24, 2000);
/// Least share of the variance of ∫τ that the fit must explain.
const EXPLAINED: f64 = 0.8;
/// Number of standard deviations below zero at which a sign is certain; large because residuals are
/// correlated.
const CERTAIN: f64 = 8.0;

/// Checks all degrees of freedom whose velocity and force have the same time stamps.
pub fn check(signals: &BTreeMap<String, Signal>) -> Vec<Seen> {
    Dof::ALL.into_iter().filter_map(|dof| negative(dof, signals)).collect()
}

/// Velocities whose product couples into this degree of freedom in the horizontal plane.
fn coupled(dof: Dof) -> Option<[&'static str; 2]> {
    match dof {
        Dof::Surge => Some(["v", "r"]),
        Dof::Sway => Some(["u", "r"]),
        Dof::Yaw => Some(["u", "v"]),
        _ => None,
    }
}

fn negative(dof: Dof, signals: &BTreeMap<String, Signal>) -> Option<Seen> {
    let velocity = signals.get(dof.velocity())?;
    let on_its_clock = |name: &str| signals.get(name).filter(|s| s.time() == velocity.time()).map(Signal::values);
    let (time, nu, tau) = (velocity.time(), velocity.values(), on_its_clock(dof.force())?);
    let step = usual_step(time)?;
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let window = ((WINDOW / step).round() as usize).clamp(1, time.len());
    let windows = time.len().saturating_sub(1) / window;
    if windows < WINDOWS.0 {
        return None;
    }
    let stride = windows.div_ceil(WINDOWS.1);
    let gaps = gaps(time);
    let starts: Vec<usize> = (0..windows)
        .step_by(stride)
        .map(|w| w * window)
        .filter(|a| gaps.partition_point(|g| g <= a) == gaps.partition_point(|g| *g <= a + window))
        .collect();
    let beside: Option<Vec<f64>> = match dof {
        Dof::Roll | Dof::Pitch => Some(on_its_clock(dof.position())?.iter().map(|angle| angle.sin()).collect()),
        _ => coupled(dof)
            .and_then(|[a, b]| Some(on_its_clock(a)?.iter().zip(on_its_clock(b)?).map(|(x, y)| x * y).collect())),
    };
    let integral = |a: usize, f: &dyn Fn(usize) -> f64| -> f64 {
        (a..a + window).map(|k| 0.5 * (f(k) + f(k + 1)) * (time[k + 1] - time[k])).sum()
    };
    let width = 3 + usize::from(beside.is_some());
    let left = DMatrix::from_fn(starts.len(), width, |row, column| {
        let a = starts[row];
        match (column, &beside) {
            (0, _) => nu[a + window] - nu[a],
            (1, _) => integral(a, &|k| nu[k]),
            (2, _) => integral(a, &|k| nu[k] * nu[k].abs()),
            (_, Some(x)) => integral(a, &|k| x[k]),
            (_, None) => 0.0,
        }
    });
    let right = DVector::from_iterator(starts.len(), starts.iter().map(|&a| integral(a, &|k| tau[k])));
    let fit = Fit::new(left, &right)?;
    let speed = median(nu.iter().map(|x| x.abs()))?;
    let mut drag = DVector::zeros(width);
    (drag[1], drag[2]) = (speed, speed * speed);
    let mut inertia = DVector::zeros(width);
    inertia[0] = 1.0;
    let (m, k) = (fit.combination(&inertia), fit.combination(&drag));
    let letter = dof.velocity();
    let (mass, unit) = if dof.is_rotation() { ("I", "kg m²") } else { ("m", "kg") };
    let mut wrong = Vec::new();
    if m.0 < -CERTAIN * m.1 {
        wrong.push(format!("a negative inertia {mass}{letter} = {} {unit}", short(m.0, 3)));
    }
    if k.0 < -CERTAIN * k.1 {
        let unit = if dof.is_rotation() { "N m" } else { "N" };
        wrong.push(format!(
            "a negative drag k{letter}: {} {unit} at {} (it would push)",
            short(k.0, 3),
            short(speed, 3)
        ));
    }
    if wrong.is_empty() {
        return None;
    }
    let text = format!(
        "a quick fit of {} gives {} for {mass}{letter}, k{letter}; most likely {letter} and {} have opposite sign \
         conventions: check body_frame (frd or flu), or set columns.{letter}.sign = -1",
        dof.name(),
        wrong.join(" and "),
        dof.force()
    );
    Some(Seen::new(codes::NON_PHYSICAL, &[dof.velocity(), dof.force()], None, text))
}

/// A least-squares fit by QR with scaled columns.
struct Fit {
    theta: DVector<f64>,
    /// Triangular factor R of the scaled columns: R⁻ᵀ gives variances.
    r: DMatrix<f64>,
    scale: DVector<f64>,
    sigma: f64,
}

impl Fit {
    /// Returns `None` if the columns are dependent, or the fit explains too little.
    fn new(mut left: DMatrix<f64>, right: &DVector<f64>) -> Option<Fit> {
        let (rows, width) = left.shape();
        let scale = DVector::from_iterator(width, left.column_iter().map(|c| c.norm()));
        if rows <= width + 2 || scale.iter().any(|s| !s.is_finite() || *s <= 0.0) {
            return None;
        }
        for (mut column, s) in left.column_iter_mut().zip(scale.iter()) {
            column /= *s;
        }
        let qr = left.clone().qr();
        let r = qr.r();
        // below this limit the data do not determine the sign
        if r.diagonal().iter().any(|d| d.abs() < 1e-6) {
            return None;
        }
        let scaled = r.solve_upper_triangular(&(qr.q().transpose() * right))?;
        let residual = right - &left * &scaled;
        let total = right.add_scalar(-right.mean()).norm_squared();
        let unexplained = residual.norm_squared() / total;
        if unexplained.is_nan() || unexplained > 1.0 - EXPLAINED {
            return None;
        }
        #[allow(clippy::cast_precision_loss)]
        let sigma = (residual.norm_squared() / (rows - width) as f64).sqrt();
        Some(Fit { theta: scaled.component_div(&scale), r, scale, sigma })
    }

    /// Returns value and standard deviation of `weights · θ`.
    fn combination(&self, weights: &DVector<f64>) -> (f64, f64) {
        let scaled = weights.component_div(&self.scale);
        let variance = self.r.transpose().solve_lower_triangular(&scaled).map_or(f64::INFINITY, |x| x.norm_squared());
        (weights.dot(&self.theta), self.sigma * variance.sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Exact motion ν = a sin ωt of m ν̇ + k ν + k₂ ν|ν| = τ.
    fn motion(sign: f64) -> BTreeMap<String, Signal> {
        let (m, k, k2, a, w) = (186.0, 12.78, 95.32, 0.4, 0.7);
        let time: std::sync::Arc<[f64]> = (0..400).map(|i| 0.05 * f64::from(i)).collect();
        let nu = |t: f64| a * (w * t).sin();
        let tau = |t: f64| m * a * w * (w * t).cos() + k * nu(t) + k2 * nu(t) * nu(t).abs();
        let column = |f: &dyn Fn(f64) -> f64| Signal::new(time.clone(), time.iter().map(|t| f(*t)).collect::<Vec<_>>());
        BTreeMap::from([("r".into(), column(&|t| sign * nu(t))), ("tau_r".into(), column(&tau))])
    }

    /// Roll of I φ̈ + k φ̇ + g sin φ = τ, driven well below its natural frequency: τ has the
    /// opposite sign of φ̈, although the inertia is positive.
    #[test]
    fn a_righting_moment_is_no_negative_inertia() {
        let (i, k, g) = (0.4, 0.5, 5.0);
        let time: std::sync::Arc<[f64]> = (0..800).map(|n| 0.05 * f64::from(n)).collect();
        let phi = |t: f64| 0.2 * (0.6 * t).sin() + 0.1 * (1.1 * t).sin();
        let p = |t: f64| 0.12 * (0.6 * t).cos() + 0.11 * (1.1 * t).cos();
        let tau = |t: f64| -i * (0.072 * (0.6 * t).sin() + 0.121 * (1.1 * t).sin()) + k * p(t) + g * phi(t).sin();
        let column = |f: &dyn Fn(f64) -> f64| Signal::new(time.clone(), time.iter().map(|t| f(*t)).collect::<Vec<_>>());
        let mut signals = BTreeMap::from([("p".into(), column(&p)), ("tau_p".into(), column(&tau))]);
        assert!(check(&signals).is_empty(), "the angle is not known");
        signals.insert("phi".into(), column(&phi));
        assert!(check(&signals).is_empty());
        signals.insert("tau_p".into(), column(&|t| -tau(t)));
        assert_eq!(check(&signals).len(), 1, "the mirror is seen");
    }

    #[test]
    fn exact_motion_is_silent_and_its_mirror_is_not() {
        assert!(check(&motion(1.0)).is_empty());
        let seen = check(&motion(-1.0));
        assert_eq!(seen.len(), 1);
        assert!(
            seen[0].text.contains("negative inertia Ir = -18") && seen[0].text.contains("frame"),
            "{}",
            seen[0].text
        );
    }
}
