//! Products of the candidates' columns, summed segment by segment so that no column is kept.
//!
//! ```text
//! left: ∂y/∂x₀, ∂y/∂θ of the model, residual;  right: ∂y/∂α of the candidates      every row times its weight
//! z̃ᵀz̃ = zᵀz − zᵀX₀ (X₀ᵀX₀)⁻¹ X₀ᵀz      and likewise for all other products
//! ```

use super::thin::Thin;
use crate::estimate::output_error::{LANES, Problem};
use crate::model::Model;
use crate::simulate::{Emission, integrate};
use crate::wide::{Lanes, Wide, Work};

/// Products of the `k` columns z of one probe in one segment, initial states projected out.
#[derive(Debug, Clone, Default)]
pub struct Products {
    /// z̃ᵀz̃, k × k.
    pub zz: Vec<f64>,
    /// z̃ᵀr, k.
    pub zr: Vec<f64>,
    /// Xᵀz̃, p × k; X: sensitivities of the model's own unknowns, by direction.
    pub xz: Vec<f64>,
    /// Σ z², k: before anything is projected out.
    pub raw: Vec<f64>,
}

/// The model's own products of one segment, initial states projected out.
#[derive(Debug, Clone, Default)]
pub struct Own {
    /// XᵀX, by direction.
    pub xx: Vec<f64>,
    /// Xᵀr.
    pub xr: Vec<f64>,
    /// rᵀr.
    pub rr: f64,
}

/// Products of one batch of segments: for each segment the model's own and those of each group of columns.
pub(super) struct Summing<'a> {
    pub problem: &'a Problem,
    pub thin: &'a Thin,
    pub model: &'a Model,
    /// Initial state of each segment.
    pub x0: &'a [Vec<f64>],
    pub batch: &'a [usize],
    /// Number of the model's own directions.
    pub own: usize,
    /// Columns of each group.
    pub groups: &'a [usize],
}

impl Work<LANES> for Summing<'_> {
    type Output = Vec<(Own, Vec<Products>)>;
    #[inline(always)]
    fn with<W: Wide<LANES>>(self, wide: W) -> Self::Output {
        batch_products(wide, &self)
    }
}

#[inline(always)]
fn batch_products<const L: usize, W: Wide<L>>(wide: W, what: &Summing<'_>) -> Vec<(Own, Vec<Products>)> {
    let Summing { problem, thin, model, x0, batch, own, groups } = *what;
    let (nx, outputs) = (problem.dynamics.states.len(), problem.dynamics.outputs.len());
    let candidates: usize = groups.iter().sum();
    let width = nx + own + candidates;
    // left: initial states, own directions, residual; right: candidates
    let left = nx + own + 1;
    let mut ll = Lanes::zeros(left * left);
    let mut lr = Lanes::zeros(left * candidates);
    let inner: usize = groups.iter().map(|k| k * k).sum();
    let mut rr = Lanes::zeros(inner);
    let (stretches, theta, start) = problem.lanes::<L>(model, x0, batch);
    let mut row = Lanes::zeros(left);
    let mut take = std::convert::identity(
        #[inline(always)]
        |at: &Emission<'_, L>| {
            for output in 0..outputs {
                let (mut weight, mut residual) = ([0.0; L], [0.0; L]);
                for lane in 0..L {
                    if let (Some(stretch), Some(k)) = (stretches[lane], at.grid[lane]) {
                        (weight[lane], residual[lane]) = thin.rows[stretch.track][k * outputs + output];
                    }
                }
                let jacobian = &at.jacobian[output * width..(output + 1) * width];
                // rows are scaled once: w² z = w (w z)
                let weight = wide.load(&weight);
                for (to, from) in row.iter_mut().zip(&jacobian[..nx + own]) {
                    *to = wide.store(wide.mul(wide.load(from), weight));
                }
                row[left - 1] = residual;
                for i in 0..left {
                    let x = wide.load(&row[i]);
                    for (to, y) in ll[i * left + i..(i + 1) * left].iter_mut().zip(&row[i..]) {
                        *to = wide.store(wide.plus(wide.load(to), x, wide.load(y)));
                    }
                    let scaled = wide.mul(x, weight);
                    let right = &mut lr[i * candidates..(i + 1) * candidates];
                    for (to, z) in right.iter_mut().zip(&jacobian[nx + own..]) {
                        *to = wide.store(wide.plus(wide.load(to), scaled, wide.load(z)));
                    }
                }
                let square = wide.mul(weight, weight);
                let (mut first, mut at_group) = (nx + own, 0);
                for k in groups {
                    for a in 0..*k {
                        for b in 0..*k {
                            let (za, zb) = (wide.load(&jacobian[first + a]), wide.load(&jacobian[first + b]));
                            let to = &mut rr[at_group + a * k + b];
                            *to = wide.store(wide.plus(wide.load(to), wide.mul(za, zb), square));
                        }
                    }
                    first += k;
                    at_group += k * k;
                }
            }
        },
    );
    integrate(wide, &problem.dynamics, &problem.tracks, &stretches, &theta, &start, true, &mut take);
    (0..batch.len())
        .map(|lane| {
            let pick = |table: &[[f64; L]]| table.iter().map(|x| x[lane]).collect::<Vec<f64>>();
            project(&pick(&ll), &pick(&lr), &pick(&rr), nx, own, groups)
        })
        .collect()
}

/// Projects the first `nx` columns out of all products, one column after the other (Cholesky on the left block).
fn project(ll: &[f64], lr: &[f64], rr: &[f64], nx: usize, own: usize, groups: &[usize]) -> (Own, Vec<Products>) {
    let left = nx + own + 1;
    let candidates: usize = groups.iter().sum();
    let (mut ll, mut lr, mut rr) = (ll.to_vec(), lr.to_vec(), rr.to_vec());
    let raw: Vec<f64> = diagonal(&rr, groups);
    for s in 0..nx {
        let pivot = ll[s * left + s];
        let size = pivot.abs();
        if size < 1e-12 {
            continue;
        }
        let (head, tail) = (ll[s * left..(s + 1) * left].to_vec(), lr[s * candidates..(s + 1) * candidates].to_vec());
        for i in s + 1..left {
            let factor = head[i] / pivot;
            for j in i..left {
                ll[i * left + j] -= factor * head[j];
            }
            for (to, z) in lr[i * candidates..(i + 1) * candidates].iter_mut().zip(&tail) {
                *to -= factor * z;
            }
        }
        let (mut first, mut at) = (0, 0);
        for k in groups {
            for a in 0..*k {
                for b in 0..*k {
                    rr[at + a * k + b] -= tail[first + a] * tail[first + b] / pivot;
                }
            }
            first += k;
            at += k * k;
        }
    }
    let upper = |i: usize, j: usize| ll[(nx + i.min(j)) * left + nx + i.max(j)];
    let model = Own {
        xx: (0..own * own).map(|k| upper(k / own, k % own)).collect(),
        xr: (0..own).map(|i| upper(i, own)).collect(),
        rr: upper(own, own),
    };
    let (mut first, mut at) = (0, 0);
    let products = groups
        .iter()
        .map(|k| {
            let column = |i: usize| (0..*k).map(|a| lr[(nx + i) * candidates + first + a]).collect::<Vec<f64>>();
            let result = Products {
                zz: rr[at..at + k * k].to_vec(),
                zr: column(own),
                xz: (0..own).flat_map(column).collect(),
                raw: raw[first..first + k].to_vec(),
            };
            first += k;
            at += k * k;
            result
        })
        .collect();
    (model, products)
}

fn diagonal(rr: &[f64], groups: &[usize]) -> Vec<f64> {
    let mut at = 0;
    let mut all = Vec::new();
    for k in groups {
        all.extend((0..*k).map(|a| rr[at + a * k + a]));
        at += k * k;
    }
    all
}
