//! Cross-validation without refits: each run as the other runs predict it.
//!
//! ```text
//! −2 ln p(y_k | others) = −2 ln L_k + g_oᵀ A_o⁻¹ g_o − gᵀ A⁻¹ g + ln det A − ln det A_o
//! A = JᵀJ, g = Jᵀr: of all runs, priors included;   A_o = A − A_k, g_o = g − g_k: of all runs but k
//! ```
//!
//! All are taken at the estimate from all runs. The parameters are integrated out over their
//! distribution given the other runs: p(y_k | others) = p(all) / p(others), where each is the integral
//! over the parameters in a quadratic approximation (Laplace). This is exact where innovations are
//! linear in θ, even from a fit that stops short of its maximum. The estimate from the others alone
//! is no prediction where they hardly determine a parameter, because its value may then be
//! anything.

use std::collections::BTreeSet;

use nalgebra::{DMatrix, DVector};

use super::FilterErrorFit;

/// Share of a parameter's information that counts as known without the run: if the others say
/// nothing, its standard deviation is a thousand times as wide.
const WIDE: f64 = 1e-6;

impl FilterErrorFit {
    /// Sum of −2 ln p(y_k | others) over the runs k; infinite if an information matrix is not
    /// positive definite.
    pub fn left_out_cost(&self) -> f64 {
        let p = self.filtered.problem.unknowns.len();
        let factor = self.filtered.factor(&self.model, &self.linear);
        let r = DMatrix::from_fn(p, p, |i, j| if i <= j { factor.at(i, j)[0] } else { 0.0 });
        let information = r.transpose() * &r;
        let slope = r.transpose() * DVector::from_fn(p, |i, _| factor.at(i, p)[0]);
        let wide = DMatrix::from_diagonal(&(information.diagonal() * WIDE).add_scalar(f64::MIN_POSITIVE));
        let Some(all) = marginal(&information + &wide, &slope) else { return f64::INFINITY };
        let tracks: BTreeSet<usize> = self.filtered.problem.segments.iter().map(|s| s.track).collect();
        let predicted = |track: usize| {
            let (own_information, own_slope) = self.of_track(track);
            let others = marginal(&information - own_information + &wide, &(&slope - own_slope))?;
            Some(all - others)
        };
        let own: f64 = self.linear.iter().map(|l| l.cost).sum();
        own + tracks.into_iter().map(|track| predicted(track).unwrap_or(f64::INFINITY)).sum::<f64>()
    }

    /// JᵀJ and Jᵀr of one run, over the unknowns of all runs.
    fn of_track(&self, track: usize) -> (DMatrix<f64>, DVector<f64>) {
        let p = self.filtered.problem.unknowns.len();
        let (mut information, mut slope) = (DMatrix::zeros(p, p), DVector::zeros(p));
        let columns = self.filtered.problem.columns_of(track);
        let stretches = self.linear.iter().zip(&self.filtered.problem.segments);
        for (linear, _) in stretches.filter(|(_, s)| s.track == track) {
            for row in linear.rows() {
                let (residual, row) = (row[row.len() - 1], &row[..row.len() - 1]);
                for (i, to_i) in columns.iter().enumerate() {
                    slope[*to_i] += row[i] * residual;
                    for (j, to_j) in columns.iter().enumerate() {
                        information[(*to_i, *to_j)] += row[i] * row[j];
                    }
                }
            }
        }
        (information, slope)
    }
}

/// ln det A − gᵀ A⁻¹ g: the contribution of the integral over the parameters to −2 ln L; `None` if
/// A is not positive definite.
fn marginal(information: DMatrix<f64>, slope: &DVector<f64>) -> Option<f64> {
    let factor = information.cholesky()?;
    Some(factor.ln_determinant() - slope.dot(&factor.solve(slope)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::filter_error::{FilterErrorOptions, Forces, filter_error};
    use crate::tank::{BlindOptions, blind};

    #[test]
    fn runs_predicted_in_turn_cost_more_than_runs_fitted_by_about_the_parameters() {
        let campaign = blind(&BlindOptions { duration: 40.0, ..BlindOptions::default() }).expect("the tank sails");
        let options = FilterErrorOptions { forces: Forces::None, refine: false, ..FilterErrorOptions::default() };
        let fit = filter_error(&campaign.truth, &campaign.runs, &options).expect("the truth fits");
        let own: f64 = fit.linear.iter().map(|l| l.cost).sum();
        let (p, runs) = (fit.filtered.problem.unknowns.len() as f64, campaign.runs.len() as f64);
        let more = fit.left_out_cost() - own;
        // about two for each parameter if runs are alike; at most ln(1/WIDE) if only one run shows
        // a parameter
        assert!(more > p && more < p * runs * (1.0 / WIDE).ln(), "{more} of {p} parameters, {runs} runs");
    }

    #[test]
    fn exact_evidence_of_a_mean() {
        // y = θ + noise: three runs of one sample each; p(y_k | others) = N(mean of the others, 1 + 1/2)
        let y = [0.3, -0.4, 1.0];
        let (a, g) = (DMatrix::from_element(1, 1, 3.0), DVector::from_element(1, y.iter().sum()));
        let all = marginal(a, &g).unwrap();
        for k in 0..3 {
            let others = g[0] - y[k];
            let by_formula = y[k] * y[k] + all
                - marginal(DMatrix::from_element(1, 1, 2.0), &DVector::from_element(1, others)).unwrap();
            let exact = (y[k] - 0.5 * others).powi(2) / 1.5 + 1.5_f64.ln();
            assert!((by_formula - exact).abs() < 1e-12, "{by_formula} {exact}");
        }
    }
}
