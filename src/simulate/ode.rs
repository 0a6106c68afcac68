//! The classical Runge-Kutta scheme for a user's own function.
//!
//! ```text
//! ẏ = f(t, y)        y(t + h) = y + h/6 (k₁ + 2 k₂ + 2 k₃ + k₄)
//! k₁ = f(t, y),  k₂ = f(t + h/2, y + h/2 k₁),  k₃ = f(t + h/2, y + h/2 k₂),  k₄ = f(t + h, y + h k₃)
//! ```
//!
//! Kutta, *Zeitschrift für Mathematik und Physik* 46 (1901) 435-453. The order is four if f is
//! smooth within each step: put the instants at which an input jumps on the grid.

use thiserror::Error;

/// The reason why a solution cannot be found. `E` is the error of the user's function.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum OdeError<E> {
    /// A time stamp or an initial value is no finite number.
    #[error("{what} {index} is {value}, which is no finite number")]
    Input {
        /// `time stamp` or `initial value`.
        what: &'static str,
        /// Its index, from 0.
        index: usize,
        /// The value.
        value: f64,
    },
    /// No step between grid points.
    #[error("at least one step from grid point to grid point is needed, not 0")]
    NoSteps,
    /// The solution is no longer finite.
    #[error("component {component} of the solution is {value} at t = {time}; a smaller step may help")]
    NotFinite {
        /// Time of the end of the step, s.
        time: f64,
        /// Component, from 0.
        component: usize,
        /// The value.
        value: f64,
    },
    /// The user's function failed.
    #[error("the function failed at t = {time}: {error}")]
    Function {
        /// Time of the call, s.
        time: f64,
        /// Its error.
        error: E,
    },
}

/// Solves ẏ = f(t, y) from `y0` at the first of the instants `time` to each of the others, with
/// `substeps` equal steps from one to the next. `f` writes the rate of `y` at `t` into its last
/// argument, which has as many components as `y0`. Returns `time.len()` rows of `y0.len()` values,
/// the first of which is `y0`.
///
/// # Errors
/// [`OdeError`] for inputs or solutions that are not finite, and for errors of `f`.
pub fn rk4<E>(
    mut f: impl FnMut(f64, &[f64], &mut [f64]) -> Result<(), E>,
    time: &[f64],
    y0: &[f64],
    substeps: usize,
) -> Result<Vec<f64>, OdeError<E>> {
    for (what, list) in [("time stamp", time), ("initial value", y0)] {
        if let Some(index) = list.iter().position(|x| !x.is_finite()) {
            return Err(OdeError::Input { what, index, value: list[index] });
        }
    }
    if substeps == 0 {
        return Err(OdeError::NoSteps);
    }
    let mut rows = Vec::with_capacity(time.len() * y0.len());
    let mut y = y0.to_vec();
    if !time.is_empty() {
        rows.extend_from_slice(&y);
    }
    let (mut stage, mut rate, mut sum) = (y.clone(), vec![0.0; y.len()], vec![0.0; y.len()]);
    for pair in time.windows(2) {
        let step = (pair[1] - pair[0]) / substeps as f64;
        for part in 0..substeps {
            let begin = pair[0] + step * part as f64;
            let end = if part + 1 == substeps { pair[1] } else { begin + step };
            sum.fill(0.0);
            stage.copy_from_slice(&y);
            let stages =
                [(begin, 0.5, 1.0), (begin + 0.5 * step, 0.5, 2.0), (begin + 0.5 * step, 1.0, 2.0), (end, 0.0, 1.0)];
            for (t, ahead, weight) in stages {
                f(t, &stage, &mut rate).map_err(|error| OdeError::Function { time: t, error })?;
                for k in 0..y.len() {
                    sum[k] += weight * rate[k];
                    stage[k] = y[k] + ahead * step * rate[k];
                }
            }
            for k in 0..y.len() {
                y[k] += step / 6.0 * sum[k];
                if !y[k].is_finite() {
                    return Err(OdeError::NotFinite { time: end, component: k, value: y[k] });
                }
            }
        }
        rows.extend_from_slice(&y);
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use super::*;

    /// A cubic in t is integrated exactly: for it the scheme is Simpson's rule.
    #[test]
    fn exact_for_a_cubic_of_time() {
        let rate = |t: f64, _: &[f64], out: &mut [f64]| -> Result<(), Infallible> {
            out[0] = 4.0 * t * t * t - 2.0;
            Ok(())
        };
        let rows = rk4(rate, &[0.0, 1.0, 3.0], &[1.0], 1).unwrap();
        assert_eq!(rows, [1.0, 0.0, 76.0]);
        assert_eq!(rk4(rate, &[2.0, 0.0], &[12.0], 2), Ok(vec![12.0, 0.0]), "backwards in time");
        assert_eq!(rk4(rate, &[], &[12.0], 2), Ok(vec![]));
    }

    #[test]
    fn what_is_not_finite_is_refused_with_its_place() {
        let mut grow = |_: f64, y: &[f64], out: &mut [f64]| -> Result<(), &'static str> {
            out[0] = 0.0;
            out[1] = y[1] * y[1];
            if y[0] > 5.0 { Err("left the pool") } else { Ok(()) }
        };
        let mut solve = |time: &[f64], y0: &[f64], substeps| rk4(&mut grow, time, y0, substeps).unwrap_err();
        assert!(matches!(
            solve(&[0.0, f64::NAN], &[0.0, 1.0], 1),
            OdeError::Input { what: "time stamp", index: 1, .. }
        ));
        assert!(matches!(solve(&[0.0], &[f64::INFINITY], 1), OdeError::Input { what: "initial value", .. }));
        assert_eq!(solve(&[0.0, 1.0], &[0.0, 1.0], 0), OdeError::NoSteps);
        assert!(matches!(solve(&[0.0, 9.0], &[0.0, 1.0], 90), OdeError::NotFinite { component: 1, .. }));
        assert_eq!(solve(&[0.0, 9.0], &[6.0, 0.0], 1).to_string(), "the function failed at t = 0: left the pool");
    }
}
