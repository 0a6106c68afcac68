//! Degrees of freedom that share free parameters, solved together without bias from noise in the
//! columns of their inertias.
//!
//! ```text
//! eᵢ = Δνᵢ − Δν̂ᵢ,   Δν̂ᵢ = (y − Σ_{j≠i} θⱼ cⱼ)/mᵢ        minimise Σᵢ wᵢ² |eᵢ|²,   wᵢ = 1/rms(eᵢ)
//! Gauss-Newton step:   Σ θⱼ c̃ⱼ = y + mᵢ (Δν̂ᵢ − Δνᵢ),   c̃ᵢ = Δν̂ᵢ,   c̃ⱼ = cⱼ else
//! ```
//!
//! The column of an inertia in its own balance is the increment Δν of a measured velocity: a
//! difference of two samples, whose noise is about as large as the difference itself. As a
//! regressor it pulls the inertia towards zero (Fuller, *Measurement Error Models*, Wiley 1987,
//! 1.1.1: 196 ± 6 for 300). In a single balance, the equation is solved per unit inertia, with Δν
//! on the left. If the inertia also stands in another balance (tied Coriolis terms), that form is
//! not linear any more, and Δν̂ replaces its column step by step. The other columns are integrals,
//! in which the noise averages out.

use super::row_fit::{RowFit, Together};
use crate::least_squares::LeastSquaresError;

/// Number of steps after which the search is given up.
const STEPS: usize = 60;

/// Greatest number of times that a step is halved to lower the cost.
const HALVINGS: i32 = 20;

/// Number of solutions as forces, each weighted by the residuals of the one before.
const PASSES: usize = 3;

/// Share of the right-hand side below which a residual is rounding.
const ROUNDING: f64 = 1e-9;

/// One balance among those that are solved together.
pub(super) struct Member {
    /// Index of its own inertia among the joint parameters, if it is free.
    pub own: Option<usize>,
    /// Its inertia from its balance alone, solved per unit inertia: the starting value.
    pub alone: Option<f64>,
    /// Root mean square of its right-hand side.
    pub size: f64,
    /// Number of its rows.
    pub rows: f64,
}

/// The weight of each balance at these parameters: the inverse of its residual as a force, by
/// `rms`.
pub(super) fn weights(members: &[Member], rms: impl Fn(usize, &[f64]) -> f64, theta: &[f64]) -> Vec<f64> {
    let one = |(k, member): (usize, &Member)| 1.0 / rms(k, theta).max(1e-12 * member.size.max(f64::MIN_POSITIVE));
    members.iter().enumerate().map(one).collect()
}

/// The joint solution, `None` if the search does not converge; it starts from parameters that are
/// `near` the solution, if there are any. `solve` solves all balances with the given weights and,
/// if parameters are given, with the increments predicted by them in the columns of the own
/// inertias; `rms` is the residual of a balance as a force.
///
/// # Errors
/// Those of `solve`.
pub(super) fn settled(
    members: &[Member],
    together: Together,
    near: Option<&[f64]>,
    mut solve: impl FnMut(Option<&[f64]>, &[f64]) -> Result<RowFit, LeastSquaresError>,
    rms: impl Fn(usize, &[f64]) -> f64,
) -> Result<Option<RowFit>, LeastSquaresError> {
    let sizes: Vec<f64> = members.iter().map(|m| m.size.max(f64::MIN_POSITIVE)).collect();
    // weights: the forces' own size, then the residuals of the step before; a perfect fit needs no
    // others
    let first: Vec<f64> = sizes.iter().map(|size| 1.0 / size).collect();
    let weights = |theta: &[f64]| weights(members, &rms, theta);
    // a solution sought from nearby is compared with others like it, to a part of their standard
    // deviations
    let rest = if near.is_some() { 1e-2 } else { 1e-6 };
    let mut theta = match near {
        Some(near) => near.to_vec(),
        None => {
            let mut linear = solve(None, &first)?;
            for _ in 1..PASSES {
                linear = solve(None, &weights(&linear.values))?;
            }
            if together == Together::AsForces {
                return Ok(Some(linear));
            }
            let mut theta = linear.values;
            for member in members {
                if let Some(own) = member.own {
                    theta[own] = member.alone.unwrap_or(theta[own].abs().max(f64::MIN_POSITIVE));
                }
            }
            theta
        }
    };
    // Σ n ln rms(e): its gradient is that of the weighted squares
    let cost = |theta: &[f64]| -> f64 {
        let of = |(k, member): (usize, &Member)| {
            let inertia = member.own.map_or(1.0, |own| theta[own]);
            member.rows * (rms(k, theta).max(ROUNDING * sizes[k]) / inertia).ln()
        };
        members.iter().enumerate().map(of).sum()
    };
    for _ in 0..STEPS {
        let fit = solve(Some(&theta), &weights(&theta))?;
        let within = |part: f64| {
            let near = |(k, (new, old)): (usize, (&f64, &f64))| {
                (new - old).abs() <= part * fit.std_paper[k] + ROUNDING * new.abs()
            };
            fit.values.iter().zip(&theta).enumerate().all(near)
        };
        let exact = sizes.iter().enumerate().all(|(k, size)| rms(k, &fit.values) <= ROUNDING * size);
        if exact || within(rest) {
            return Ok(Some(fit));
        }
        let before = cost(&theta);
        let shorter = (0..HALVINGS).map(|k| stepped(members, &theta, &fit.values, 0.5_f64.powi(k)));
        match shorter.into_iter().find(|theta| cost(theta) < before) {
            Some(better) => theta = better,
            // the remaining gain is below the rounding of the cost
            None => return Ok(within(1e-3).then_some(fit)),
        }
    }
    Ok(None)
}

/// A `part` of the way from `from` to `to`. Own inertias move in their logarithm, by a factor of e
/// at most, so that none becomes negative.
fn stepped(members: &[Member], from: &[f64], to: &[f64], part: f64) -> Vec<f64> {
    let is_own = |k: usize| members.iter().any(|member| member.own == Some(k));
    let one = |(k, (old, new)): (usize, (&f64, &f64))| match is_own(k) {
        true => old * (part * (new / old - 1.0).clamp(-1.0, 1.0)).exp(),
        false => old + part * (new - old),
    };
    from.iter().zip(to).enumerate().map(one).collect()
}
