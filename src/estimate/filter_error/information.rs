//! Information of the likelihood on the unknowns of the noise.
//!
//! ```text
//! Iᵢⱼ = Σ ½ ∂ᵢs ∂ⱼs/s² + ∂ᵢe ∂ⱼe/s          i, j: logarithms of the noise          (Fisher scoring)
//! ```
//!
//! Computed with filters that run side by side, one per lane, each with one unknown slightly
//! larger: exact to the step of 1e-4, without a second set of equations. Åström, *Automatica* 16
//! (1980) 551-574.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::noise::{Coordinate, NoiseModel};
use super::pass::filter;
use super::problem::{Batch, Filtered};
use super::sensor::Innovation;
use crate::frame::Dof;
use crate::model::Model;
use crate::simd::{Machine, Wide, Widths as _, Work};
use crate::simulate::Stretch;

/// Step by which a logarithm of the noise is moved: its square is negligible, and so are roundings.
const STEP: f64 = 1e-4;

/// Number of filters side by side: one unchanged, the others with one unknown moved each.
const TOGETHER: usize = 16;

/// Rows of a stretch from which a step of the noise takes the information: this number or this
/// share (one in `SHARE`), whichever is more. A sample of a settled filter adds as much as any
/// other, because the expected information does not depend on the data.
const ROWS: usize = 256;
const SHARE: usize = 4;

/// The samples from which the information is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Asked {
    /// Every sample.
    All,
    /// The beginning of every stretch, scaled up to all of it.
    Beginnings,
}

impl Asked {
    /// Number of rows used of a stretch of `all` rows.
    fn rows(self, all: usize) -> usize {
        match self {
            Asked::All => all,
            Asked::Beginnings => all.min(ROWS.max(all / SHARE)),
        }
    }
}

impl Filtered {
    /// Information of −ln L on the logarithms `coordinates` of the noise.
    pub(super) fn noise_information(
        &self,
        model: &Model,
        noise: &NoiseModel,
        coordinates: &[Coordinate],
        mobilities: &[DMatrix<f64>],
        limit: f64,
        asked: Asked,
    ) -> DMatrix<f64> {
        let moved = |coordinate: Option<&Coordinate>| {
            let mut other = noise.clone();
            if let Some(c) = coordinate {
                other.set(*c, noise.at(*c) + STEP);
            }
            other
        };
        let count = coordinates.len();
        // coordinates of different groups share hardly any information: it is left out
        let order: Vec<usize> = self.by_dof(coordinates, noise);
        let groups: Vec<&[usize]> = order.chunks(count.div_ceil(count.div_ceil(TOGETHER - 1)).max(1)).collect();
        let jobs: Vec<(usize, &[usize])> =
            (0..self.problem.segments.len()).flat_map(|k| groups.iter().map(move |g| (k, *g))).collect();
        let of = |(stretch, group): &(usize, &[usize])| {
            let models = std::array::from_fn(|lane| {
                moved(lane.checked_sub(1).and_then(|i| group.get(i)).map(|c| &coordinates[*c]))
            });
            let mut batch = self.batch::<TOGETHER>(model, &[*stretch; TOGETHER], models, mobilities, limit);
            let Stretch { first, last, .. } = self.problem.segments[*stretch];
            let all = last + 1 - first;
            let rows = asked.rows(all);
            batch.stretches.iter_mut().flatten().for_each(|part| part.last = first + rows - 1);
            (Machine::widest(Informing { batch, count: group.len() }), all as f64 / rows as f64)
        };
        let parts: Vec<([[f64; TOGETHER]; TOGETHER], f64)> = jobs.par_iter().map(of).collect();
        let mut total = DMatrix::zeros(count, count);
        for ((_, group), (part, stands_for)) in jobs.iter().zip(&parts) {
            for (a, i) in group.iter().enumerate() {
                for (b, j) in group.iter().enumerate() {
                    total[(*i, *j)] += stands_for * part[a.max(b)][a.min(b)];
                }
            }
        }
        total
    }

    /// Indices of the coordinates, those of one degree of freedom side by side.
    fn by_dof(&self, coordinates: &[Coordinate], noise: &NoiseModel) -> Vec<usize> {
        let of_output = |c: usize| {
            let name = &self.problem.dynamics.outputs[c];
            let own = |dof: &Dof| dof.velocity() == name || dof.position() == name;
            Dof::ALL.iter().position(own).unwrap_or(Dof::ALL.len())
        };
        let place = |c: &Coordinate| match *c {
            Coordinate::ForceRms(i) | Coordinate::ForceTime(i) => noise.forces[i].dof.index(),
            Coordinate::Sensor(c) | Coordinate::ColouredRms(c) | Coordinate::ColouredTime(c) => of_output(c),
        };
        let mut order: Vec<usize> = (0..coordinates.len()).collect();
        order.sort_by_key(|k| place(&coordinates[*k]));
        order
    }
}

struct Informing<'a> {
    batch: Batch<'a, TOGETHER>,
    count: usize,
}

impl Work<TOGETHER> for Informing<'_> {
    /// Sums of the products, lower triangle.
    type Output = [[f64; TOGETHER]; TOGETHER];
    #[inline(always)]
    fn with<W: Wide<TOGETHER>>(self, wide: W) -> Self::Output {
        let Informing { batch, count } = self;
        let mut information = [[0.0; TOGETHER]; TOGETHER];
        let mut take = std::convert::identity(
            #[inline(always)]
            |at: &Innovation<'_, TOGETHER>| {
                if at.present[0] == 0.0 {
                    return;
                }
                let (e, s) = (at.e[0], at.s[0]);
                let root = s.sqrt();
                let (mut ds, mut de) = ([0.0; TOGETHER], [0.0; TOGETHER]);
                for k in 0..count {
                    ds[k] = (at.s[k + 1] - s) / (STEP * s);
                    de[k] = (at.e[k + 1] - e) / (STEP * root);
                }
                for i in 0..count {
                    for j in 0..=i {
                        information[i][j] += 0.5 * ds[i] * ds[j] + de[i] * de[j];
                    }
                }
            },
        );
        filter(wide, batch, false, None, None, &mut take);
        information
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::filter_error::FilterErrorOptions;
    use crate::estimate::filter_error::noise::{RandomForce, SensorNoise};
    use crate::tank::{BlindOptions, blind};

    /// Three quarters of the samples are left out. A filter settles within seconds, and these weigh
    /// more in the beginning of a run than in all of it.
    #[test]
    fn the_beginnings_of_runs_stand_for_all_of_them() {
        let campaign = blind(&BlindOptions { duration: 300.0, ..BlindOptions::default() }).unwrap();
        let filtered = Filtered::new(&campaign.truth, &campaign.runs, &FilterErrorOptions::default().base).unwrap();
        let dofs = filtered.problem.dynamics.velocities();
        let noise = NoiseModel {
            forces: dofs.iter().map(|dof| RandomForce { dof: *dof, rms: 1.0, time: 1.0 }).collect(),
            sensors: filtered.problem.sigma.iter().map(|std| SensorNoise { std: *std, coloured: None }).collect(),
        };
        let mobilities = filtered.mobilities(&campaign.truth).unwrap();
        let of = |asked: Asked| {
            let unknowns = noise.coordinates();
            filtered.noise_information(&campaign.truth, &noise, &unknowns, &mobilities, f64::INFINITY, asked)
        };
        let (all, part) = (of(Asked::All), of(Asked::Beginnings));
        for k in 0..all.nrows() {
            let ratio = part[(k, k)] / all[(k, k)];
            assert!((ratio - 1.0).abs() < 0.1, "{k}: {ratio}");
        }
    }
}
