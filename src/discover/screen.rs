//! Step 2: one pass of the filter scores every candidate.
//!
//! ```text
//! g = ∂e/∂α /√s at α = 0     what a little of the candidate would change of the innovations e
//! C = gᵀg − (gᵀG)(GᵀG)⁻¹(Gᵀg),   b = −(gᵀe − (gᵀG)(GᵀG)⁻¹Gᵀe)       G = ∂e/∂θ /√s of what is in the model
//! α̂ = C⁻¹ b,   z² = bᵀC⁻¹b ~ χ²(k) if nothing is missing
//! ```
//!
//! A name is accepted only if the least p-value of all candidates lies below the least p-value that chance produces.
//! The quantile of the latter is drawn from N(0, C), the candidates' own correlation. Candidates are scored in
//! chunks, and each chunk is drawn by itself: correlation between two chunks is neglected, which makes the threshold
//! lower. Rao, *Proceedings of the Cambridge Philosophical Society* 44 (1948) 50-57.

use std::collections::{BTreeMap, BTreeSet};

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par, Side};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use statrs::distribution::{ChiSquared, ContinuousCDF};
use statrs::function::gamma::ln_gamma;

use super::candidate::Candidate;
use super::columns::{Assembled, Columns, in_chunks};
use crate::estimate::filter_error::FilterErrorFit;
use crate::estimate::output_error::{OutputErrorError, OutputErrorOptions};
use crate::noise::Noise;
use crate::run::Run;

/// Share of signal after projection onto the columns of the model below which a candidate is indistinguishable from
/// the model.
pub(super) const INDISTINGUISHABLE: f64 = 0.003;

/// Number of draws of the least p-value by chance: the quantile at 1 % is then known to a fifth.
const DRAWS: usize = 2000;

/// Stream of the seed from which least p-values are drawn.
const STREAM: u64 = 0x5c0e;

/// Score of one probe of a candidate.
#[derive(Debug, Clone)]
pub struct Score {
    /// Index of the candidate.
    pub candidate: usize,
    /// Index of the probe in the candidate.
    pub probe: usize,
    /// Number of the candidate's parameters, all runs together.
    pub parameters: usize,
    /// z².
    pub statistic: f64,
    /// ln of the p-value of this candidate alone.
    pub log_p: f64,
    /// α̂: estimated strength of the candidate.
    pub estimate: Vec<f64>,
    /// Standard deviation of α̂.
    pub std: Vec<f64>,
    /// Share of the candidate's signal that a refit of the model cannot absorb, 0 to 1.
    pub left: f64,
}

/// Scores of all candidates.
#[derive(Debug, Clone)]
pub struct Screen {
    /// Scores, the least probable by chance first.
    pub scores: Vec<Score>,
    /// Threshold of ln p: by chance the best candidate lies below it with the probability `level`.
    pub threshold: f64,
}

impl Screen {
    /// Whether a candidate is beyond chance.
    pub(super) fn asks(&self) -> bool {
        self.scores.first().is_some_and(|best| best.log_p < self.threshold)
    }

    /// The best probe of each candidate, the least probable by chance first.
    pub(super) fn best_probes(&self) -> Vec<&Score> {
        self.best_probes_among(|_| true)
    }

    /// The same among the probes that are `asked`. A probe far from the truth may score best and with the wrong sign: a delay
    /// of 2 s where one of 0.2 s is true.
    pub(super) fn best_probes_among(&self, asked: impl Fn(&Score) -> bool) -> Vec<&Score> {
        let mut best: Vec<&Score> = Vec::new();
        for score in self.scores.iter().filter(|score| asked(score)) {
            if best.iter().all(|known| known.candidate != score.candidate) {
                best.push(score);
            }
        }
        best
    }
}

/// ln of the probability that χ² of `k` degrees of freedom exceeds `x`; also valid where the probability underflows
/// to 0.
pub(super) fn log_survival(x: f64, k: usize) -> f64 {
    let half = 0.5 * k.max(1) as f64;
    let p = ChiSquared::new(2.0 * half).map_or(1.0, |chi| chi.sf(x.max(0.0)));
    if p > 1e-200 { p.ln() } else { -0.5 * x + (half - 1.0) * (0.5 * x).ln() - ln_gamma(half) }
}

/// χ² of `k` degrees of freedom whose [`log_survival`] is `log_p`, as far as 1 − p differs from 1.
pub(super) fn beyond_chance(log_p: f64, k: usize) -> f64 {
    let chance = log_p.exp().max(f64::EPSILON);
    ChiSquared::new(k.max(1) as f64).map_or(0.0, |chi| chi.inverse_cdf(1.0 - chance))
}

/// Scores `candidates` at a fit to `runs`; `level` is the probability of a false name where nothing is missing.
///
/// # Errors
/// [`OutputErrorError`] when a run lacks what a candidate reads.
pub fn screen(
    fit: &FilterErrorFit,
    runs: &[Run],
    candidates: &[Candidate],
    fitting: &OutputErrorOptions,
    (level, seed): (f64, u64),
) -> Result<Screen, OutputErrorError> {
    let parts = in_chunks(fit.into(), runs, candidates, fitting, |k, columns| {
        judged(fit, &columns, Noise::new(seed, STREAM + k as u64))
    })?;
    let mut least: Vec<f64> = vec![0.0; DRAWS];
    let mut scores = Vec::new();
    for (part, drawn) in parts {
        scores.extend(part);
        least.iter_mut().zip(drawn).for_each(|(a, b)| *a = a.min(b));
    }
    least.sort_by(f64::total_cmp);
    scores.sort_by(|a, b| a.log_p.total_cmp(&b.log_p));
    let at = ((level * DRAWS as f64) as usize).min(DRAWS - 1);
    Ok(Screen { scores, threshold: least[at] })
}

/// Scores of one chunk, and draws of its least ln p under chance.
fn judged(fit: &FilterErrorFit, columns: &Columns, mut noise: Noise) -> (Vec<Score>, Vec<f64>) {
    let Assembled { total, unknowns, probes } = columns.assembled(fit);
    let e = total.nrows() - 1;
    let raw: Vec<f64> = (unknowns..e).map(|k| total[(k, k)]).collect();
    let Some(projected) = project(&total, unknowns) else { return (Vec::new(), vec![0.0; DRAWS]) };
    let m = e - unknowns;
    let c = projected.view((0, 0), (m, m)).into_owned();
    let b: DVector<f64> = -projected.view((0, m), (m, 1)).column(0).into_owned();
    let mut scores = Vec::new();
    let mut factors: Vec<(Vec<usize>, Cholesky<f64, Dyn>)> = Vec::new();
    for (probe, at) in probes {
        let at: Vec<usize> = at.map(|k| k - unknowns).collect();
        let share = |k: &usize| if raw[*k] > 0.0 { (c[(*k, *k)].max(0.0) / raw[*k]).sqrt() } else { 0.0 };
        let left = at.iter().map(share).fold(0.0, f64::max);
        if left < INDISTINGUISHABLE {
            continue;
        }
        // drop a column of a run that the candidate does not affect, or that depends on the candidate's other columns
        let Some((at, factor)) = independent(&c, at, |k| INDISTINGUISHABLE * INDISTINGUISHABLE * raw[k]) else {
            continue;
        };
        let own = DVector::from_fn(at.len(), |i, _| b[at[i]]);
        let estimate = factor.solve(&own);
        let statistic = own.dot(&estimate).max(0.0);
        let inverse = factor.inverse();
        scores.push(Score {
            candidate: probe.candidate,
            probe: probe.probe,
            parameters: at.len(),
            statistic,
            log_p: log_survival(statistic, at.len()),
            estimate: estimate.iter().copied().collect(),
            std: (0..at.len()).map(|k| inverse[(k, k)].max(0.0).sqrt()).collect(),
            left,
        });
        factors.push((at, factor));
    }
    (scores, by_chance(&c, &factors, &mut noise))
}

/// Those of the columns `at` whose part independent of the earlier ones exceeds `least`, and the Cholesky factor of
/// their products; `None` if no column remains.
fn independent(
    c: &DMatrix<f64>,
    at: Vec<usize>,
    least: impl Fn(usize) -> f64,
) -> Option<(Vec<usize>, Cholesky<f64, Dyn>)> {
    let mut kept: Vec<usize> = Vec::new();
    let mut factor: Option<Cholesky<f64, Dyn>> = None;
    for k in at {
        let with = DVector::from_fn(kept.len(), |i, _| c[(kept[i], k)]);
        let explained = factor.as_ref().map_or(0.0, |factor| with.dot(&factor.solve(&with)));
        if c[(k, k)] - explained < least(k) {
            continue;
        }
        let before = kept.len();
        kept.push(k);
        factor = match factor {
            Some(factor) => Some(factor.insert_column(before, DVector::from_fn(kept.len(), |i, _| c[(kept[i], k)]))),
            None => DMatrix::from_element(1, 1, c[(k, k)]).cholesky(),
        };
    }
    Some((kept, factor?))
}

/// The system minus its projection on the first `own` columns.
pub(super) fn project(total: &DMatrix<f64>, own: usize) -> Option<DMatrix<f64>> {
    let n = total.nrows();
    let rest = total.view((own, own), (n - own, n - own)).into_owned();
    if own == 0 {
        return Some(rest);
    }
    let scale: Vec<f64> = (0..own).map(|k| total[(k, k)].max(f64::MIN_POSITIVE).sqrt()).collect();
    let a = DMatrix::from_fn(own, own, |i, j| total[(i, j)] / (scale[i] * scale[j]));
    let b = DMatrix::from_fn(own, n - own, |i, j| total[(i, own + j)] / scale[i]);
    let solved = a.cholesky()?.l().solve_lower_triangular(&b)?;
    Some(rest - solved.transpose() * solved)
}

/// A root R of a covariance C = R Rᵀ, whose rows may be zero or depend on others; `None` if C is not finite.
///
/// Triangular where rounding allows it; otherwise by eigenvalues, of which negative ones are rounding errors.
pub(super) fn root(c: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let m = c.nrows();
    let scale: Vec<f64> = (0..m).map(|k| c[(k, k)].max(f64::MIN_POSITIVE).sqrt()).collect();
    // a millionth on the diagonal lets dependent columns be drawn too
    let correlation =
        DMatrix::from_fn(m, m, |i, j| c[(i, j)] / (scale[i] * scale[j]) + 1e-6 * f64::from(u8::from(i == j)));
    let root = match correlation.clone().cholesky() {
        Some(factor) => factor.l(),
        None => by_eigenvalues(&correlation)?,
    };
    Some(DMatrix::from_fn(m, m, |i, j| root[(i, j)] * scale[i]))
}

/// U √Λ of a symmetric matrix U Λ Uᵀ.
fn by_eigenvalues(matrix: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let m = matrix.nrows();
    let eigen = Mat::from_fn(m, m, |i, j| matrix[(i, j)]).self_adjoint_eigen(Side::Lower).ok()?;
    let (vectors, values) = (eigen.U(), eigen.S().column_vector());
    let root = DMatrix::from_fn(m, m, |i, j| vectors[(i, j)] * values[j].max(0.0).sqrt());
    root.iter().all(|x| x.is_finite()).then_some(root)
}

/// ln of the least p-value of all scores, drawn from N(0, C).
///
/// Among scores with equally many parameters the greatest z² has the least p-value: one probability per draw and number
/// of parameters is enough.
fn by_chance(c: &DMatrix<f64>, factors: &[(Vec<usize>, Cholesky<f64, Dyn>)], noise: &mut Noise) -> Vec<f64> {
    // what remains of a column that no score reads, after projection on the model's columns, is rounding
    let read: BTreeSet<usize> = factors.iter().flat_map(|(at, _)| at.iter().copied()).collect();
    let place: BTreeMap<usize, usize> = read.iter().enumerate().map(|(to, from)| (*from, to)).collect();
    let read: Vec<usize> = read.into_iter().collect();
    let m = read.len();
    let c = DMatrix::from_fn(m, m, |i, j| c[(read[i], read[j])]);
    // if nothing can be drawn, no candidate is beyond chance
    let Some(root) = root(&c) else { return vec![f64::NEG_INFINITY; DRAWS] };
    let root = Mat::from_fn(m, m, |i, j| root[(i, j)]);
    let normal = Mat::from_fn(m, DRAWS, |_, _| noise.normal());
    let mut drawn = Mat::<f64>::zeros(m, DRAWS);
    matmul(drawn.as_mut(), Accum::Replace, &root, &normal, 1.0, Par::Seq);
    let mut greatest: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
    for (at, factor) in factors {
        let most = greatest.entry(at.len()).or_insert_with(|| vec![0.0; DRAWS]);
        // looked up once, and not for each draw
        let rows: Vec<usize> = at.iter().map(|k| place[k]).collect();
        let own = DMatrix::from_fn(rows.len(), DRAWS, |i, d| drawn[(rows[i], d)]);
        let Some(white) = factor.l_dirty().solve_lower_triangular(&own) else { continue };
        for (most, column) in most.iter_mut().zip(white.column_iter()) {
            *most = most.max(column.norm_squared());
        }
    }
    (0..DRAWS).map(|d| greatest.iter().map(|(k, most)| log_survival(most[d], *k)).fold(0.0, f64::min)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// −2 ln p of χ²(2) is x itself; the asymptote takes over where the probability is below 1e-200.
    #[test]
    fn exact_survival_far_out() {
        for x in [1.0, 50.0, 900.0, 1000.0, 1e4] {
            assert!((log_survival(x, 2) + 0.5 * x).abs() < 1e-9 * x, "{x}");
        }
        assert!(log_survival(1000.0, 1) < log_survival(1000.0, 3));
    }

    /// As far as 1 − p holds eight digits of p.
    #[test]
    fn exact_inverse_of_the_survival() {
        for (log_p, k) in [(-1.0, 1), (-8.5, 2), (-12.0, 5)] {
            assert!((log_survival(beyond_chance(log_p, k), k) - log_p).abs() < 1e-8, "{log_p} {k}");
        }
        // beyond that it stays a number
        assert!(beyond_chance(-500.0, 1).is_finite());
    }

    /// Columns that depend on others, one that is zero, and one that rounding has made slightly indefinite.
    #[test]
    fn a_root_of_what_is_hardly_a_covariance() {
        let mut x = DMatrix::from_fn(6, 5, |i, j| ((3 * i + 7 * j) as f64).sin());
        for i in 0..6 {
            (x[(i, 3)], x[(i, 4)]) = (2.0 * x[(i, 0)] - x[(i, 1)], 0.0);
        }
        let mut c = x.transpose() * &x;
        c[(3, 3)] *= 1.0 - 1e-4;
        let found = root(&c).unwrap();
        // exact but for the indefinite part, 10⁻⁴ of the greatest element, and the millionth on the diagonal
        assert!((&found * found.transpose() - &c).norm() < 2e-4 * c.norm());
        assert_eq!(root(&DMatrix::from_element(2, 2, f64::NAN)), None);
    }

    /// If columns are indistinguishable the threshold is still that of one score: ln 0.01 at the level of 1 %.
    #[test]
    fn chance_of_columns_that_are_the_same_is_that_of_one() {
        let c = DMatrix::from_fn(3, 3, |i, j| if i == j { 1.0 } else { 1.0 + 1e-4 });
        let factors: Vec<_> = (0..3).map(|k| (vec![k], DMatrix::identity(1, 1).cholesky().unwrap())).collect();
        let mut drawn = by_chance(&c, &factors, &mut Noise::new(1, 1));
        drawn.sort_by(f64::total_cmp);
        let at = drawn[DRAWS / 100];
        // of 2000 draws the first hundredth is known to some 20 %
        assert!((at - 0.01f64.ln()).abs() < 0.5, "{at}");
    }

    /// Of four columns, the second is twice the first and the last the sum of first and third: two are independent.
    #[test]
    fn columns_that_others_are_say_nothing() {
        let mut x = DMatrix::from_fn(6, 4, |i, j| ((3 * i + 7 * j) as f64).sin());
        for i in 0..6 {
            (x[(i, 1)], x[(i, 3)]) = (2.0 * x[(i, 0)], x[(i, 0)] + x[(i, 2)]);
        }
        let c = x.transpose() * &x;
        let (kept, factor) = independent(&c, vec![0, 1, 2, 3], |k| 1e-5 * c[(k, k)]).unwrap();
        assert_eq!(kept, [0, 2]);
        let det = c[(0, 0)] * c[(2, 2)] - c[(0, 2)] * c[(0, 2)];
        assert!((factor.determinant() / det - 1.0).abs() < 1e-12);
        assert!(independent(&c, vec![0, 1], |_| f64::INFINITY).is_none());
    }

    /// Projection leaves nothing of a column that is a multiple of the model's, and all of an orthogonal one.
    #[test]
    fn law_projection_takes_out_what_the_model_has() {
        let x = DMatrix::from_row_slice(4, 3, &[1.0, 2.0, 0.0, 1.0, 2.0, 0.0, 1.0, 2.0, 1.0, 1.0, 2.0, -1.0]);
        let left = project(&(x.transpose() * &x), 1).unwrap();
        assert!(left[(0, 0)].abs() < 1e-12 && (left[(1, 1)] - 2.0).abs() < 1e-12);
    }
}
