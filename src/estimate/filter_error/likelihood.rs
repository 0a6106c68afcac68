//! The likelihood of the innovations, and its derivatives by the parameters.
//!
//! ```text
//! −2 ln L(θ, η) = Σ (ρ(z) + c ln s)          z = e/√s;  ρ = z², c = 1;  with heavier tails: [`super::tails`]
//! θ: rows (∂e/∂θ)/√s of a triangular factor, gain and s held          (Gauss-Newton)
//! ```
//!
//! If innovations are held back, the factor c keeps the standard deviations of the noise right where
//! the noise is Gaussian. Åström, *Automatica* 16 (1980) 551-574.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};
use nalgebra::DMatrix;
use rayon::prelude::*;

use super::adjoint::Tape;
use super::beginning::KnownBeginning;
use super::noise::{Coordinate, NoiseModel};
use super::pass::filter;
use super::problem::{Batch, Filtered};
use super::sensor::Innovation;
use super::tails::{self, OUTLIER, share};
use crate::estimate::output_error::{Fold, LANES, fold_priors};
use crate::model::Model;
use crate::simd::{Machine, Wide, Widths as _, Work};

/// A stretch linearised at the current values.
#[derive(Debug, Clone)]
pub struct Linear {
    /// Triangular factor of [∂e/∂θ | e] / √s, row-major, `n × n`.
    r: Vec<f64>,
    n: usize,
    /// −2 ln L.
    pub cost: f64,
    /// Σ ln s.
    pub volume: f64,
    /// Number of samples.
    pub samples: usize,
    /// Number of innovations beyond five standard deviations.
    pub outliers: usize,
    /// Number of innovations that are held back.
    pub beyond: usize,
    /// Σ ψ², Σ ψ' and Σ (dρ½/dz)²: they give the information that remains where innovations are
    /// held back.
    pub held_back: [f64; 3],
}

impl Linear {
    /// Rows of the triangular factor; the innovation is the last element of each.
    pub(super) fn rows(&self) -> impl Iterator<Item = &[f64]> {
        self.r.chunks(self.n)
    }
}

/// The innovations of one output over a stretch.
#[derive(Debug, Clone, Default)]
pub(super) struct Innovations {
    /// Over their standard deviations, e/√s.
    pub z: Vec<f64>,
    /// e
    pub e: Vec<f64>,
    /// Σ s.
    pub expected: f64,
}

impl Filtered {
    /// Indices of the stretches, the longest first, so that those of similar length share a batch.
    fn by_length(&self) -> Vec<usize> {
        let steps = |k: &usize| {
            let s = self.problem.segments[*k];
            let steps_to = &self.problem.tracks[s.track].steps_to;
            steps_to[s.last + 1] - steps_to[s.first + 1]
        };
        let mut order: Vec<usize> = (0..self.problem.segments.len()).collect();
        order.sort_by_key(|k| std::cmp::Reverse(steps(k)));
        order
    }

    /// Indices of the stretches, in batches.
    fn batches(&self) -> Vec<Vec<usize>> {
        self.by_length().chunks(LANES).map(<[usize]>::to_vec).collect()
    }

    /// −2 ln L of each stretch at each of `points`, side by side.
    pub(super) fn costs_at(
        &self,
        points: &[&(Model, NoiseModel)],
        mobilities: &[DMatrix<f64>],
        limit: f64,
    ) -> Vec<Vec<f64>> {
        let all: Vec<(usize, usize)> =
            self.by_length().into_iter().flat_map(|stretch| (0..points.len()).map(move |m| (m, stretch))).collect();
        let of = |members: &[(usize, usize)]| {
            let noise = std::array::from_fn(|lane| points[members.get(lane).unwrap_or(&members[0]).0].1.clone());
            let own: Vec<(&Model, usize)> = members.iter().map(|(m, stretch)| (&points[*m].0, *stretch)).collect();
            let batch = self.batch_of_models::<LANES>(&own, noise, mobilities, limit);
            let (passed, _) = Machine::widest(Pass { batch, kept: Kept::Cost, tape: None });
            passed.into_iter().map(|p| p.linear.cost).collect()
        };
        let parts: Vec<Vec<f64>> = all.par_chunks(LANES).map(of).collect();
        let mut costs = vec![vec![0.0; self.problem.segments.len()]; points.len()];
        all.into_iter().zip(parts.into_iter().flatten()).for_each(|((m, stretch), cost)| costs[m][stretch] = cost);
        costs
    }

    /// Runs one pass of the filter over every stretch.
    fn passed(
        &self,
        model: &Model,
        noise: &NoiseModel,
        mobilities: &[DMatrix<f64>],
        limit: f64,
        kept: Kept,
    ) -> Vec<Passed> {
        self.there_and_back(model, noise, mobilities, limit, kept, None::<&fn(&[usize], &Tape<LANES>)>).0
    }

    /// Linearises every stretch and returns the slope of −ln L by the logarithms `coordinates` of
    /// the noise; one forward pass serves both.
    pub(super) fn slopes(
        &self,
        model: &Model,
        noise: &NoiseModel,
        coordinates: &[Coordinate],
        mobilities: &[DMatrix<f64>],
        limit: f64,
    ) -> (Vec<Linear>, Vec<f64>) {
        let slopes = |_: &[usize], tape: &Tape<LANES>| coordinates.iter().map(|c| tape.slope(*c)).collect::<Vec<f64>>();
        let (passed, parts) = self.there_and_back(model, noise, mobilities, limit, Kept::Factor, Some(&slopes));
        let slopes = (0..coordinates.len()).map(|k| parts.iter().map(|part| part[k]).sum()).collect();
        (passed.into_iter().map(|p| p.linear).collect(), slopes)
    }

    /// What `read` extracts from the backward pass through each batch; it also receives the
    /// stretches of the batch.
    pub(super) fn back<T: Send>(
        &self,
        model: &Model,
        noise: &NoiseModel,
        mobilities: &[DMatrix<f64>],
        limit: f64,
        read: impl Fn(&[usize], &Tape<LANES>) -> T + Sync,
    ) -> Vec<T> {
        self.there_and_back(model, noise, mobilities, limit, Kept::Cost, Some(&read)).1
    }

    /// What is kept of the forward pass over each stretch, and, if `read` is given, what it
    /// extracts from the backward pass through each batch.
    fn there_and_back<T: Send>(
        &self,
        model: &Model,
        noise: &NoiseModel,
        mobilities: &[DMatrix<f64>],
        limit: f64,
        kept: Kept,
        read: Option<&(impl Fn(&[usize], &Tape<LANES>) -> T + Sync)>,
    ) -> (Vec<Passed>, Vec<T>) {
        let states = self.problem.dynamics.states.len();
        let of = |members: &Vec<usize>| {
            let noises = std::array::from_fn(|_| noise.clone());
            let batch = self.batch::<LANES>(model, members, noises, mobilities, limit);
            let tape = read.is_some().then(|| Tape::new(noise, states, limit, share(limit)));
            let (passed, tape) = Machine::widest(Pass { batch, kept, tape });
            (passed, read.zip(tape).map(|(read, tape)| read(members, &tape)))
        };
        let batches = self.batches();
        let (passed, read): (Vec<Vec<Passed>>, Vec<Option<T>>) = batches.par_iter().map(of).unzip();
        let of_batch = |(members, passed): (&Vec<usize>, Vec<Passed>)| members.clone().into_iter().zip(passed);
        let mut all: Vec<(usize, Passed)> = batches.iter().zip(passed).flat_map(of_batch).collect();
        all.sort_by_key(|(member, _)| *member);
        (all.into_iter().map(|(_, passed)| passed).collect(), read.into_iter().flatten().collect())
    }

    /// Σ ln|1 + P₀ I₀| of all stretches ([`super::beginning`]).
    pub(super) fn of_beginnings(
        &self,
        model: &Model,
        noise: &NoiseModel,
        mobilities: &[DMatrix<f64>],
        limit: f64,
    ) -> f64 {
        let passed = self.passed(model, noise, mobilities, limit, Kept::Beginnings);
        passed.into_iter().map(|p| p.beginning).sum()
    }

    /// Linearises every stretch at the values of `model` under `noise`; `mobilities` as by
    /// [`Filtered::mobilities`].
    pub(super) fn linearise(
        &self,
        model: &Model,
        noise: &NoiseModel,
        mobilities: &[DMatrix<f64>],
        limit: f64,
        sensitive: bool,
    ) -> Vec<Linear> {
        let kept = if sensitive { Kept::Factor } else { Kept::Cost };
        self.passed(model, noise, mobilities, limit, kept).into_iter().map(|p| p.linear).collect()
    }

    /// The innovations by stretch and output.
    pub(super) fn innovations(
        &self,
        model: &Model,
        noise: &NoiseModel,
        mobilities: &[DMatrix<f64>],
        limit: f64,
    ) -> Vec<Vec<Innovations>> {
        let passed = self.passed(model, noise, mobilities, limit, Kept::Innovations);
        passed.into_iter().map(|p| p.innovations).collect()
    }

    /// Factor of the information of all stretches on the unknowns, priors included; its last column
    /// holds the innovations.
    pub(super) fn factor(&self, model: &Model, stretches: &[Linear]) -> Fold<1> {
        let p = self.problem.unknowns.len();
        let mut global = Fold::<1>::new(p + 1);
        for (linear, stretch) in stretches.iter().zip(&self.problem.segments) {
            let columns = self.problem.columns_of(stretch.track);
            for i in 0..linear.n {
                let mut row = vec![[0.0]; p + 1];
                for (direction, column) in columns.iter().enumerate() {
                    row[*column] = [linear.r[i * linear.n + direction]];
                }
                row[p] = [linear.r[i * linear.n + linear.n - 1]];
                global.push(row.into_iter());
            }
        }
        fold_priors(&mut global, model, &self.problem.unknowns);
        global
    }

    /// Products of the columns [∂e/∂θ | e] / √s of every stretch, `n × n`, where n is the number of
    /// directions plus one.
    pub(crate) fn products(
        &self,
        model: &Model,
        noise: &NoiseModel,
        mobilities: &[DMatrix<f64>],
        limit: f64,
    ) -> Vec<Mat<f64>> {
        let passed = self.passed(model, noise, mobilities, limit, Kept::Products);
        passed.into_iter().flat_map(|p| p.products).collect()
    }

    /// The same at the values of `model`, in consecutive blocks of `rows` samples; empty if the
    /// inertia is singular.
    pub(crate) fn products_in_blocks(
        &self,
        model: &Model,
        noise: &NoiseModel,
        limit: f64,
        rows: usize,
    ) -> Vec<Vec<Mat<f64>>> {
        let Some(mobilities) = self.mobilities(model) else { return Vec::new() };
        let passed = self.passed(model, noise, &mobilities, limit, Kept::Blocks(rows));
        passed.into_iter().map(|p| p.products).collect()
    }

    /// Triangular factor of the information of the runs on the unknowns under this noise, priors
    /// included; `None` if the inertia of `model` is singular.
    pub fn information_factor(&self, model: &Model, noise: &NoiseModel) -> Option<Fold<1>> {
        let mobilities = self.mobilities(model)?;
        let stretches = self.linearise(model, noise, &mobilities, f64::INFINITY, true);
        let mut factor = self.factor(model, &stretches);
        factor.fold();
        Some(factor)
    }
}

/// What is kept of a pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kept {
    /// The likelihood alone.
    Cost,
    /// The triangular factor of the rows.
    Factor,
    /// The products of the rows.
    Products,
    /// The products of each block of this many rows.
    Blocks(usize),
    /// The innovations themselves.
    Innovations,
    /// The terms of the initial states.
    Beginnings,
}

/// What a pass has kept of one stretch.
struct Passed {
    linear: Linear,
    products: Vec<Mat<f64>>,
    /// Innovations by output.
    innovations: Vec<Innovations>,
    /// ln|1 + P₀ I₀|; 0 if it was not requested.
    beginning: f64,
}

/// Number of rows that are multiplied at once.
const ROWS: usize = 256;

/// One pass over a batch. One type serves all kinds of [`Kept`], so that the filter is compiled
/// once for each machine.
struct Pass<'a> {
    batch: Batch<'a, LANES>,
    kept: Kept,
    /// Tape for the backward pass.
    tape: Option<Tape<LANES>>,
}

impl Work<LANES> for Pass<'_> {
    type Output = (Vec<Passed>, Option<Tape<LANES>>);
    #[inline(always)]
    fn with<W: Wide<LANES>>(self, wide: W) -> Self::Output {
        let Pass { batch, kept, mut tape } = self;
        let (limit, members) = (batch.limit, batch.stretches.iter().flatten().count());
        let (directions, outputs) = (batch.problem.dynamics.directions.len(), batch.problem.dynamics.outputs.len());
        let multiplied = matches!(kept, Kept::Products | Kept::Blocks(_));
        let height = if let Kept::Blocks(rows) = kept { rows } else { ROWS };
        let sensitive = (multiplied || kept == Kept::Factor) && directions > 0;
        let n = if sensitive { directions + 1 } else { 1 };
        let c = share(limit);
        let mut fold = Fold::with(wide, n);
        let (mut cost, mut volume) = ([0.0; LANES], [0.0; LANES]);
        let (mut samples, mut outliers, mut beyond) = ([0; LANES], [0; LANES], [0; LANES]);
        let mut held_back = [[0.0; 3]; LANES];
        let size = if multiplied { n } else { 0 };
        let mut products = vec![vec![Mat::<f64>::zeros(size, size)]; members];
        // each row is stored as a column, so that it is written in one piece
        let mut rows = vec![Mat::<f64>::zeros(size, if size > 0 { height } else { 0 }); members];
        let mut filled = vec![0; members];
        let mut innovations =
            vec![vec![Innovations::default(); if kept == Kept::Innovations { outputs } else { 0 }]; members];
        let mut take = std::convert::identity(
            #[inline(always)]
            |at: &Innovation<'_, LANES>| {
                let (mut weight, mut value) = ([0.0; LANES], [0.0; LANES]);
                for lane in 0..LANES {
                    if at.present[lane] == 0.0 {
                        continue;
                    }
                    let root = at.s[lane].sqrt();
                    let z = at.e[lane] / root;
                    let (tempered, slope) = tails::root(z, limit);
                    (value[lane], weight[lane]) = (tempered, slope / root);
                    let log = at.s[lane].ln();
                    volume[lane] += log;
                    cost[lane] += tempered * tempered + c * log;
                    samples[lane] += 1;
                    outliers[lane] += usize::from(z.abs() > OUTLIER);
                    beyond[lane] += usize::from(z.abs() > limit);
                    let sums = [(tempered * slope).powi(2), tails::place(z, limit).slope(z), slope * slope];
                    held_back[lane].iter_mut().zip(sums).for_each(|(sum, x)| *sum += x);
                    if kept == Kept::Innovations {
                        let of = &mut innovations[lane][at.output];
                        of.z.push(z);
                        of.e.push(at.e[lane]);
                        of.expected += at.s[lane];
                    }
                }
                if kept == Kept::Factor && sensitive {
                    let weight = wide.load(&weight);
                    let row = at.gradient.iter().map(
                        #[inline(always)]
                        |g| wide.store(wide.mul(wide.only_where(wide.load(g), weight), weight)),
                    );
                    fold.push(row.chain(std::iter::once(value)));
                }
                if !multiplied {
                    return;
                }
                for lane in (0..members).filter(|lane| at.present[*lane] > 0.0) {
                    let row = filled[lane];
                    for (column, g) in at.gradient.iter().enumerate() {
                        rows[lane][(column, row)] = g[lane] * weight[lane];
                    }
                    rows[lane][(n - 1, row)] = value[lane];
                    filled[lane] += 1;
                    if filled[lane] == height {
                        multiply(&mut products[lane], &rows[lane], height);
                        filled[lane] = 0;
                        if matches!(kept, Kept::Blocks(_)) {
                            products[lane].push(Mat::zeros(size, size));
                        }
                    }
                }
            },
        );
        let mut known = (kept == Kept::Beginnings).then(|| KnownBeginning::new(&batch));
        filter(wide, batch, sensitive, tape.as_mut(), known.as_mut(), &mut take);
        fold.fold();
        if multiplied {
            (0..members).for_each(|lane| multiply(&mut products[lane], &rows[lane], filled[lane]));
        }
        let linear = |lane: usize| Linear {
            r: (0..n * n).map(|k| if n == 1 { 0.0 } else { fold.at(k / n, k % n)[lane] }).collect(),
            n,
            cost: cost[lane],
            volume: volume[lane],
            samples: samples[lane],
            outliers: outliers[lane],
            beyond: beyond[lane],
            held_back: held_back[lane],
        };
        let kept = products.into_iter().zip(innovations).enumerate();
        let passed = kept.map(|(lane, (products, innovations))| Passed {
            linear: linear(lane),
            products,
            innovations,
            beginning: known.as_ref().map_or(0.0, |known| known.more[lane]),
        });
        (passed.collect(), tape)
    }
}

/// Adds rowsᵀ rows to the last of `products`, for the first `count` rows; each row is a column of
/// `rows`.
fn multiply(products: &mut [Mat<f64>], rows: &Mat<f64>, count: usize) {
    let (Some(product), rows) = (products.last_mut(), rows.get(.., ..count)) else { return };
    matmul(product.as_mut(), Accum::Add, rows, rows.transpose(), 1.0, Par::Seq);
}
