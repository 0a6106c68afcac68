//! Standard deviations of the parameters if few data determine the noise itself only roughly.
//!
//! ```text
//! C = E[A⁻¹(η)],    ln η ~ N(ln η̂ + δ, F⁻¹)      A = JᵀJ of the parameters, F: information on the noise
//! δ = −½ F⁻¹ ∂ln|A|/∂ln η       to the maximum of the restricted likelihood, to first order
//! C = C₀ + Σ_a C′_a δ_a + ½ Σ_a C″_a λ_a      over the axes a of F⁻¹, by differences at ±√3 std
//! ```
//!
//! The likelihood underestimates the noise by what the parameters have absorbed, like a regression
//! that divides by n and not by n − p. Moreover, half a minute holds some thirty independent
//! samples of a force with a correlation time of a second: its rms is known to a fifth, its
//! correlation time to a factor of two. Patterson and Thompson, *Biometrika* 58 (1971) 545-554;
//! Kenward and Roger, *Biometrics* 53 (1997) 983-997; the differences are the sigma points of
//! Julier and Uhlmann, *Proc. IEEE* 92 (2004) 401-422.

use nalgebra::DMatrix;

use super::likelihood::Linear;
use super::noise::Coordinate;
use super::steps::Search;
use crate::estimate::output_error::{OutputErrorError, covariance};

/// Variance along an axis below which the noise is known well enough, to a third: the mean would
/// change standard deviations by 2 to 3 % and cost twelve passes.
const KNOWN: f64 = 0.1;

/// Distance of the sigma points in standard deviations: √3 gives the fourth moment of a Gaussian.
const OUT: f64 = 1.732_050_807_568_877_2;

/// Greatest change of a logarithm: the Gaussian holds near the maximum, and says little about what
/// lies farther off.
const FARTHEST: f64 = 1.5;

impl Search<'_> {
    /// Covariance of the parameters, row-major.
    pub(super) fn covariance(&mut self) -> Result<Vec<f64>, OutputErrorError> {
        let here = self.covariance_of(&self.current)?;
        let averaged = if self.options.refine { self.averaged(&here) } else { None };
        Ok(averaged.unwrap_or(here))
    }

    fn covariance_of(&self, linear: &[Linear]) -> Result<Vec<f64>, OutputErrorError> {
        let factor = self.filtered.factor(&self.model, linear);
        covariance::bread(&self.filtered.problem, &self.model, &factor)
    }

    /// The mean covariance over the uncertainty of the forces; `None` if they are known well
    /// enough, or the mean is no covariance.
    fn averaged(&mut self, here: &[f64]) -> Option<Vec<f64>> {
        let all = self.coordinates();
        let is_force = |k: &usize| matches!(all[*k], Coordinate::ForceRms(_) | Coordinate::ForceTime(_));
        let forces: Vec<usize> = (0..all.len()).filter(is_force).collect();
        if forces.is_empty() {
            return None;
        }
        let spread = self.scored(&all).1.cholesky()?.inverse();
        let axes =
            DMatrix::from_fn(forces.len(), forces.len(), |i, j| spread[(forces[i], forces[j])]).symmetric_eigen();
        if axes.eigenvalues.max() < KNOWN {
            return None;
        }
        let p = self.filtered.problem.unknowns.len();
        let mut mean = here.to_vec();
        // along all axes: those known well are those of σ, which the restricted likelihood moves
        // most (without them nothing is gained)
        for (axis, variance) in axes.eigenvectors.column_iter().zip(&axes.eigenvalues) {
            let under = |out: f64| {
                let mut noise = self.noise.clone();
                for (k, along) in forces.iter().zip(axis.iter()) {
                    let step = (out * variance.sqrt() * along).clamp(-FARTHEST, FARTHEST);
                    noise.set(all[*k], self.bounded(all[*k], noise.at(all[*k]) + step));
                }
                self.covariance_of(&self.linearised(&self.model, &noise).0).ok()
            };
            let (up, down) = (under(OUT)?, under(-OUT)?);
            // in standard deviations along the axis
            let shift = 0.5 * (volume(&up, p)? - volume(&down, p)?) / (2.0 * OUT);
            for (mean, ((up, down), here)) in mean.iter_mut().zip(up.iter().zip(&down).zip(here)) {
                *mean += shift * (up - down) / (2.0 * OUT) + (up + down - 2.0 * here) / (2.0 * OUT * OUT);
            }
        }
        volume(&mean, p).map(|_| mean)
    }
}

/// ln|C| of a covariance; `None` if it is not positive definite.
fn volume(covariance: &[f64], p: usize) -> Option<f64> {
    let factor = DMatrix::from_row_slice(p, p, covariance).cholesky()?;
    Some(2.0 * factor.l().diagonal().map(f64::ln).sum())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Coriolis;
    use crate::estimate::filter_error::{FilterErrorOptions, filter_error};
    use crate::frame::Dof;
    use crate::model::{Interpolation, Model};
    use crate::noise::Noise;
    use crate::run::{Run, Signal};

    /// 10 u̇ + 4 u = τ + d over `steps` of 0.1 s; d has an rms of 0.8 N and a correlation time of
    /// 1 s.
    fn pushed(steps: u32) -> Run {
        let (h, rms) = (0.1, 0.8);
        let time: Vec<f64> = (0..steps).map(|k| h * f64::from(k)).collect();
        let tau: Vec<f64> = time.iter().map(|t| if (t / 4.0).floor() % 2.0 < 1.0 { 6.0 } else { -3.0 }).collect();
        let (mut u, mut d, mut noise) = (0.0, 0.0, Noise::new(8, 1));
        let (decay, keeps) = (f64::exp(-0.4 * h), f64::exp(-h));
        let step = |tau: &f64| {
            let now = u + 0.005 * noise.normal();
            let still = (tau + d) / 4.0;
            u = still + (u - still) * decay;
            d = d * keeps + rms * f64::sqrt(1.0 - keeps * keeps) * noise.normal();
            now
        };
        let logged: Vec<f64> = tau.iter().map(step).collect();
        let mut run = Run { name: "pushed".into(), ..Run::default() };
        run.signals.insert("u".into(), Signal::new(time.clone().into(), logged));
        run.signals.insert("tau_u".into(), Signal::new(time.into(), tau));
        run
    }

    /// Standard deviations over those under the noise that was found.
    fn widened(steps: u32) -> Vec<f64> {
        let mut model = Model::with_effects(&[Dof::Surge], Coriolis::Tied, &["inertia", "linear_drag"]).unwrap();
        model.input = Interpolation::Hold;
        model.parameters.iter_mut().zip([9.0, 5.0]).for_each(|(p, value)| p.value = value);
        let fit = filter_error(&model, &[pushed(steps)], &FilterErrorOptions::default()).unwrap();
        assert_eq!(fit.noise.forces.len(), 1, "the force is found");
        let factor = fit.filtered.factor(&fit.model, &fit.linear);
        let plain = covariance::bread(&fit.filtered.problem, &fit.model, &factor).unwrap();
        (0..2).map(|k| (fit.covariance[3 * k] / plain[3 * k]).sqrt()).collect()
    }

    #[test]
    fn few_data_widen_the_deviations_and_many_do_not() {
        let few = widened(250);
        // the force, of which 25 s contain some twenty independent values, hides the drag; the
        // inertia shows in quicker motion
        assert!(few.iter().all(|ratio| *ratio > 1.0) && (1.02..1.5).contains(&few[1]), "{few:?}");
        assert_eq!(widened(3000), [1.0, 1.0]);
    }
}
