//! Initial states of runs whose velocities no channel logs, smoothed from all later samples.
//!
//! ```text
//! x̂₀ = x₀ − P₀ λ,    P̂₀ = P₀ − P₀ (2 Λ + λ λᵀ) P₀        λ = ∂L/∂x₀, Λ = ∂L/∂P₀ of L = −ln L
//! I = P̂₀⁻¹ − P₀⁻¹        information of the run alone;  the run begins with the variance 9/I about x̂₀
//! ```
//!
//! Fixes determine a velocity within seconds; a gyro determines the product u v, by the Munk
//! moment, within one. A filter that starts with the wrong signs, or with a small u and a large v,
//! follows the gyro and is sure of both before the fixes can contradict it. In simulation this was
//! 20 standard deviations off, and what the model cannot explain is then taken for a missing
//! effect. The first seconds are therefore filtered from each point of a grid over the initial
//! estimate, and the likeliest point is smoothed.

use nalgebra::DMatrix;

use super::adjoint::Tape;
use super::noise::NoiseModel;
use super::problem::{Filtered, Start};
use super::unseen_velocity::{self, UNKNOWN, WIDER};
use crate::chain::StateId;
use crate::estimate::output_error::{LANES, OutputErrorError, OutputErrorOptions};
use crate::model::Model;
use crate::run::Run;

/// Greatest number of times that an initial state is smoothed; each time the filter is linearised
/// about a better one.
const ROUNDS: usize = 3;

/// Standard deviation of the estimate of a speed, m/s, beyond which a grid is used: poses that
/// determine the speed better leave a single maximum.
const WIDE: f64 = 0.5 * UNKNOWN;

/// Points of the grid, in standard deviations of the initial estimate from its mean. In space there
/// are three speeds, and the grid is coarser.
const IN_PLANE: [f64; 5] = [-1.6, -0.8, 0.0, 0.8, 1.6];
const IN_SPACE: [f64; 3] = [-1.2, 0.0, 1.2];

/// Time of a run, s, that is filtered from each point: a vehicle forgets its initial state within a
/// few seconds.
const FIRST: f64 = 20.0;

/// What runs are filtered with.
#[derive(Clone, Copy)]
pub(super) struct At<'a> {
    pub model: &'a Model,
    pub noise: &'a NoiseModel,
    pub mobilities: &'a [DMatrix<f64>],
    pub limit: f64,
}

impl Filtered {
    /// Prepares runs that take no part in a fit for a filter under its `noise`: they begin where
    /// their own data say.
    ///
    /// # Errors
    /// As [`Filtered::new`].
    pub fn begun(
        model: &Model,
        runs: &[Run],
        (noise, limit): (&NoiseModel, f64),
        options: &OutputErrorOptions,
    ) -> Result<Filtered, OutputErrorError> {
        let mut filtered = Filtered::new(model, runs, options)?;
        if let Some(mobilities) = filtered.mobilities(model) {
            filtered.begin_smoothed(At { model, noise, mobilities: &mobilities, limit });
        }
        Ok(filtered)
    }

    /// Starts again where the runs say that velocities without a sensor began; returns whether
    /// there are such velocities.
    pub(super) fn begin_smoothed(&mut self, at: At<'_>) -> bool {
        let unseen = unseen_velocity::states(&self.problem);
        if unseen.is_empty() {
            return false;
        }
        let before = self.starts.clone();
        let costs = self.costs(at);
        self.begin_likeliest(at);
        self.smooth(&unseen, &before, at);
        // with a model that is far off, the filter may not be able to continue from the smoothed
        // initial state
        let now = self.costs(at);
        for (k, start) in before.into_iter().enumerate() {
            if now[k].is_nan() || now[k] > costs[k] {
                self.starts[k] = start;
            }
        }
        true
    }

    /// Starts from the likeliest point of the grid of speeds over the initial estimate, with half a
    /// mesh as standard deviation.
    fn begin_likeliest(&mut self, at: At<'_>) {
        let is_speed = |state: &usize| match self.problem.dynamics.states[*state] {
            StateId::Velocity(dof) => !dof.is_rotation(),
            _ => false,
        };
        let is_wide = |state: &usize| self.starts.iter().any(|start| start.variance[*state] > WIDE * WIDE);
        let unseen = unseen_velocity::states(&self.problem);
        let speeds: Vec<usize> = unseen.into_iter().filter(is_speed).filter(is_wide).collect();
        if speeds.is_empty() {
            return;
        }
        let mut brief = self.clone();
        for stretch in &mut brief.problem.segments {
            let time = &self.problem.tracks[stretch.track].time;
            let until = time[stretch.first] + FIRST;
            stretch.last = stretch.last.min(time.partition_point(|t| *t <= until).max(stretch.first + 1));
        }
        let grid: &[f64] = if speeds.len() > 2 { &IN_SPACE } else { &IN_PLANE };
        let mesh = grid[1] - grid[0];
        let mut least = vec![f64::INFINITY; self.starts.len()];
        let believed = self.starts.clone();
        for point in 0..grid.len().pow(speeds.len() as u32) {
            for (start, believed) in brief.starts.iter_mut().zip(&believed) {
                for (k, state) in speeds.iter().enumerate() {
                    let step = grid[point / grid.len().pow(k as u32) % grid.len()];
                    start.x[*state] = believed.x[*state] + step * believed.variance[*state].sqrt();
                    start.variance[*state] = believed.variance[*state] * (0.5 * mesh).powi(2);
                }
            }
            for (k, cost) in brief.costs(at).into_iter().enumerate() {
                if cost < least[k] {
                    (least[k], self.starts[k]) = (cost, brief.starts[k].clone());
                }
            }
        }
    }

    /// Smooths the initial states until none moves by more than its standard deviation.
    fn smooth(&mut self, unseen: &[usize], before: &[Start], at: At<'_>) {
        let read = |members: &[usize], tape: &Tape<LANES>| {
            (members.to_vec(), unseen.iter().map(|state| tape.by_beginning(*state)).collect::<Vec<_>>())
        };
        for _ in 0..ROUNDS {
            let mut rests = true;
            for (members, slopes) in self.back(at.model, at.noise, at.mobilities, at.limit, read) {
                for (lane, stretch) in members.into_iter().enumerate() {
                    let start = &mut self.starts[stretch];
                    for (state, [slope, curvature]) in unseen.iter().zip(&slopes) {
                        let (believed, slope, curvature) = (start.variance[*state], slope[lane], curvature[lane]);
                        let told = believed - believed * believed * (2.0 * curvature + slope * slope);
                        if !(slope.is_finite() && told.is_finite() && told > 0.0) {
                            continue;
                        }
                        let step = -believed * slope;
                        start.x[*state] += step;
                        let of_run = (1.0 / told - 1.0 / believed).max(0.0);
                        start.variance[*state] = (WIDER.powi(2) / of_run).min(before[stretch].variance[*state]);
                        rests &= step.abs() < told.sqrt();
                    }
                }
            }
            if rests {
                break;
            }
        }
    }

    /// −2 ln L of each stretch.
    fn costs(&self, at: At<'_>) -> Vec<f64> {
        let stretches = self.linearise(at.model, at.noise, at.mobilities, at.limit, false);
        stretches.into_iter().map(|stretch| stretch.cost).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Coriolis;
    use crate::estimate::filter_error::{FilterErrorOptions, RandomForce, SensorNoise};
    use crate::frame::Dof;
    use crate::model::Interpolation;
    use crate::noise::Noise;
    use crate::run::Signal;

    const INERTIA: [f64; 3] = [46.0, 64.0, 7.5];
    const DRAG: [f64; 3] = [20.0, 60.0, 9.0];

    /// A boat that turns and drifts at the first sample, by Euler's rule in steps of 1 ms. It logs
    /// fixes of half a metre at 2 Hz, a compass of 1.5 degrees and a gyro at 10 Hz, but no speed. τ
    /// is 20 N ahead and steps of ± 3 N m.
    fn run(nu: [f64; 3]) -> Run {
        let ([mut u, mut v, mut r], [mut x, mut y, mut psi]) = (nu, [0.0_f64; 3]);
        let [m, n, inertia] = INERTIA;
        let mut noise = Noise::new(4, 1);
        let mut columns: [Vec<(f64, f64)>; 6] = Default::default();
        for k in 0..400 {
            let t = 0.1 * f64::from(k);
            let tau = [20.0, 0.0, if (t / 3.0).floor() % 2.0 < 1.0 { -3.0 } else { 3.0 }];
            let slow = k % 5 == 0;
            let rows = [(x, 0.5, slow), (y, 0.5, slow), (psi, 0.026, true), (r, 0.008, true)];
            for (column, (value, std, is_logged)) in columns.iter_mut().zip(rows) {
                if is_logged {
                    column.push((t, value + std * noise.normal()));
                }
            }
            columns[4].push((t, tau[0]));
            columns[5].push((t, tau[2]));
            for _ in 0..100 {
                let h = 1e-3;
                (x, y) = (x + h * (u * psi.cos() - v * psi.sin()), y + h * (u * psi.sin() + v * psi.cos()));
                psi += h * r;
                let du = (tau[0] - DRAG[0] * u + n * v * r) / m;
                let dv = (-DRAG[1] * v - m * u * r) / n;
                let dr = (tau[2] - DRAG[2] * r - (n - m) * u * v) / inertia;
                (u, v, r) = (u + h * du, v + h * dv, r + h * dr);
            }
        }
        let mut run = Run { name: "turns".into(), ..Run::default() };
        for (name, column) in ["x", "y", "psi", "r", "tau_u", "tau_r"].into_iter().zip(columns) {
            let (time, values): (Vec<f64>, Vec<f64>) = column.into_iter().unzip();
            run.signals.insert(name.into(), Signal::new(time.into(), values));
        }
        run
    }

    /// If it starts with the wrong signs of u and v, the filter keeps them, and so does smoothing;
    /// from the likeliest point of the grid it ends at the truth.
    #[test]
    fn the_signs_of_surge_and_sway_are_those_of_the_fixes() {
        let effects = ["inertia", "linear_drag", "coriolis_surge", "coriolis_sway", "coriolis_yaw"];
        let mut model = Model::with_effects(&[Dof::Surge, Dof::Sway, Dof::Yaw], Coriolis::Tied, &effects).unwrap();
        model.input = Interpolation::Hold;
        let values = INERTIA.into_iter().chain(DRAG);
        model.parameters.iter_mut().zip(values).for_each(|(p, value)| p.value = value);
        let truth = [0.63, 0.2, -0.7];
        let options = FilterErrorOptions::default();
        let mut filtered = Filtered::new(&model, &[run(truth)], &options.base).unwrap();
        let sensors = filtered.problem.dynamics.outputs.iter().map(|output| SensorNoise {
            std: match output.as_str() {
                "r" => 0.008,
                "psi" => 0.026,
                _ => 0.5,
            },
            coloured: None,
        });
        let force = RandomForce { dof: Dof::Yaw, rms: 0.2, time: 1.0 };
        let noise = NoiseModel { forces: vec![force], sensors: sensors.collect() };
        let mobilities = filtered.mobilities(&model).unwrap();
        let at = At { model: &model, noise: &noise, mobilities: &mobilities, limit: f64::INFINITY };

        let unseen = unseen_velocity::states(&filtered.problem);
        for (state, value) in unseen.iter().zip([-0.6, -0.2]) {
            (filtered.starts[0].x[*state], filtered.starts[0].variance[*state]) = (value, 0.5);
        }
        let mut smoothed = filtered.clone();
        smoothed.smooth(&unseen, &filtered.starts, at);
        let off = |filtered: &Filtered| {
            let of = |(state, truth): (&usize, f64)| (filtered.starts[0].x[*state] - truth).abs();
            unseen.iter().zip(truth).map(of).fold(0.0, f64::max)
        };
        assert!(off(&smoothed) > 0.8, "it is trapped: {:?}", smoothed.starts);
        assert!(filtered.begin_smoothed(at));
        // the fixes and the gyro determine it to some 0.05 m/s: three of these
        assert!(off(&filtered) < 0.15, "{:?}", filtered.starts);
    }
}
