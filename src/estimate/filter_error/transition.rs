//! One step of the filter: the state by Runge-Kutta, its Jacobian by the same four stages, and the
//! effect of the noise.
//!
//! ```text
//! x₊ = x + h/6 (k₁ + 2k₂ + 2k₃ + k₄)
//! B₄ = h/6,  B₃ = h/3 + B₄ hJ₄,  B₂ = h/3 + B₃ hJ₃/2,  B₁ = h/6 + B₂ hJ₂/2
//! Φ = 1 + Σ B_g J_g        ∂x₊/∂θ = Φ ∂x/∂θ + Σ B_g (∂f/∂θ)_g        ∂x₊/∂d = Σ B_g M⁻¹ κ
//! ```
//!
//! J_g is ∂f/∂x at stage g. The B_g serve all columns, so that a parameter costs a few dozen
//! products. The random force d acts as a constant over a step, at its mean κ d. M⁻¹ is that of the
//! last fit, so that the noise does not depend on θ.

use super::gauss_markov::{self, Step};
use super::noise::NoiseModel;
use super::ud::{Covariance, First, Work};
use crate::dynamics::{Dynamics, Entry};
use crate::noise::Noise;
use crate::simd::{Lanes, Wide};
use crate::simulate::{Evaluator, Feed};
use crate::symbolic::Ends;

/// Distance of the next stage from the beginning of the step, in steps, and the instant of its
/// inputs if it is another one.
const STAGES: [(f64, Option<usize>); 4] = [(0.5, Some(1)), (0.5, None), (1.0, Some(2)), (0.0, None)];

/// Estimate of the state: the model's states, then the Gauss-Markov processes.
#[derive(Debug, Clone)]
pub(super) struct Belief<const L: usize> {
    /// Mean.
    pub x: Lanes<L>,
    /// Covariance.
    pub p: Covariance<L>,
}

impl Belief<1> {
    /// Moves the state to a random draw from its estimate.
    pub fn draw(&mut self, noise: &mut Noise) {
        for (x, by) in self.x.iter_mut().zip(self.p.drawn(noise)) {
            x[0] += by;
        }
    }
}

/// ∂x/∂θ of the filtered state, row by row.
#[derive(Debug)]
pub(super) struct Sensitivities<const L: usize> {
    /// `states × columns`.
    pub s: Lanes<L>,
    /// Number of parameters.
    pub columns: usize,
    next: Lanes<L>,
}

impl<const L: usize> Sensitivities<L> {
    /// The sensitivities of a state that does not depend on the parameters.
    pub fn none(states: usize, columns: usize) -> Sensitivities<L> {
        Sensitivities { s: Lanes::zeros(states * columns), next: Lanes::zeros(states * columns), columns }
    }
}

/// The processes of each lane over a step, recomputed only if the step changes.
#[derive(Debug)]
struct Processes<const L: usize> {
    models: [NoiseModel; L],
    h: [f64; L],
    steps: Vec<[Step; L]>,
}

impl<const L: usize> Processes<L> {
    fn new(models: [NoiseModel; L]) -> Processes<L> {
        let still = gauss_markov::step(0.0, 1.0, 0.0);
        let count = models[0].processes();
        Processes { models, h: [0.0; L], steps: vec![[still; L]; count] }
    }

    fn over(&mut self, h: [f64; L]) {
        for lane in 0..L {
            // a step that differs only by rounding has the same processes
            if (h[lane] - self.h[lane]).abs() <= 1e-9 * h[lane] {
                continue;
            }
            self.h[lane] = h[lane];
            let model = &self.models[lane];
            let forces = model.forces.iter().map(|f| (f.rms, f.time));
            let coloured = model.coloured().map(|(_, c)| (c.rms, c.time));
            for (k, (rms, time)) in forces.chain(coloured).enumerate() {
                self.steps[k][lane] = gauss_markov::step(rms, time, h[lane]);
            }
        }
    }

    #[inline(always)]
    fn get(&self, k: usize, part: impl Fn(&Step) -> f64) -> [f64; L] {
        let mut parts = [0.0; L];
        for lane in 0..L {
            parts[lane] = part(&self.steps[k][lane]);
        }
        parts
    }
}

/// One step of the filter in `L` lanes.
pub(super) struct Transition<'a, const L: usize> {
    dynamics: &'a Dynamics,
    rates: Evaluator<'a, L>,
    processes: Processes<L>,
    /// M⁻¹, `velocities × forces`.
    mobility: Vec<[f64; L]>,
    velocities: usize,
    forces: usize,
    /// Rows of each column of the B_g that may be nonzero.
    reached: Vec<Vec<usize>>,
    /// Φ: transition matrix of all states.
    phi: Lanes<L>,
    /// W: effect of unit noise sources, `states × sources`.
    w: Lanes<L>,
    b: [Lanes<L>; 4],
    jacobian: [Lanes<L>; 4],
    direct: [Lanes<L>; 4],
    sum: Lanes<L>,
    acceleration: Lanes<L>,
    work: Work<L>,
}

impl<'a, const L: usize> Transition<'a, L> {
    /// The step of a compiled model whose parameters are in the registers of `rates`.
    pub fn new(
        dynamics: &'a Dynamics,
        rates: Evaluator<'a, L>,
        noise: [NoiseModel; L],
        mobility: Vec<[f64; L]>,
    ) -> Transition<'a, L> {
        let (nx, forces, all) = (dynamics.states.len(), noise[0].forces.len(), noise[0].processes());
        let n = nx + all;
        let sources = 3 * forces + (all - forces);
        let (by_state, by_parameter) = (dynamics.rates.by_state.len(), dynamics.rates.by_parameter.len());
        // a process depends on itself alone and has noise sources of its own
        let process = |k: usize| First { column: nx + k, source: if k < forces { 3 * k } else { 2 * forces + k } };
        let first = (0..nx).map(|_| First::default()).chain((0..all).map(process)).collect();
        let (velocities, follows) = (dynamics.velocities().len(), follows(&dynamics.rates.by_state, nx));
        let reached = (0..nx).map(|k| (0..nx).filter(|i| follows[*i][k]).collect()).collect();
        // a force drives the velocities
        let driven = |i: usize| if follows[i][..velocities].contains(&true) { nx..nx + forces } else { nx..nx };
        let of_state = |i: usize| (0..nx).filter(|k| follows[i][*k]).chain(driven(i)).collect();
        let filled = (0..nx).map(of_state).chain((nx..n).map(|k| vec![k])).collect();
        Transition {
            dynamics,
            rates,
            processes: Processes::new(noise),
            mobility,
            velocities,
            forces,
            reached,
            phi: Lanes::zeros(n * n),
            w: Lanes::zeros(n * sources),
            b: std::array::from_fn(|_| Lanes::zeros(nx * nx)),
            jacobian: std::array::from_fn(|_| Lanes::zeros(by_state)),
            direct: std::array::from_fn(|_| Lanes::zeros(by_parameter)),
            sum: Lanes::zeros(nx.max(nx * nx)),
            acceleration: Lanes::zeros(velocities),
            work: Work::new(first, filled, sources),
        }
    }

    /// Carries the estimate over the step that `feed` has reached. The Jacobians stay for
    /// [`Transition::carry`].
    #[inline(always)]
    pub fn predict<W: Wide<L>>(&mut self, wide: W, feed: &Feed<'_, L>, belief: &mut Belief<L>) {
        self.processes.over(feed.h);
        let nx = self.dynamics.states.len();
        self.random_acceleration(wide, &belief.x[nx..]);
        self.integrate(wide, feed, &mut belief.x);
        self.products(wide, &feed.h);
        self.spread(wide, &feed.h);
        for k in 0..self.processes.steps.len() {
            let decay = wide.load(&self.processes.get(k, |s| s.decay));
            belief.x[nx + k] = wide.store(wide.mul(decay, wide.load(&belief.x[nx + k])));
        }
        belief.p.predict(wide, &self.phi, &self.w, &mut self.work);
    }

    /// Carries another covariance over the step that was predicted last.
    #[inline(always)]
    pub fn spread_also<W: Wide<L>>(&mut self, wide: W, p: &mut Covariance<L>) {
        p.predict(wide, &self.phi, &self.w, &mut self.work);
    }

    /// F and W of the step that was predicted last, and the number of columns of W.
    pub fn kept(&self) -> (&[[f64; L]], &[[f64; L]], usize) {
        (&self.phi, &self.w, self.w.len() / self.work.states().max(1))
    }

    /// M⁻¹ κ d
    #[inline(always)]
    fn random_acceleration<W: Wide<L>>(&mut self, wide: W, d: &[[f64; L]]) {
        for row in 0..self.velocities {
            let mut sum = wide.splat(0.0);
            for k in 0..self.forces {
                let mean = wide.mul(wide.load(&self.processes.get(k, |s| s.mean)), wide.load(&d[k]));
                sum = wide.plus(sum, wide.load(&self.mobility[row * self.forces + k]), mean);
            }
            self.acceleration[row] = wide.store(sum);
        }
    }

    /// Integrates the state over the step, and keeps the Jacobians of each stage.
    #[inline(always)]
    fn integrate<W: Wide<L>>(&mut self, wide: W, feed: &Feed<'_, L>, x: &mut [[f64; L]]) {
        let nx = self.dynamics.states.len();
        let (by_state, by_parameter) = (self.jacobian[0].len(), self.direct[0].len());
        let h = wide.load(&feed.h);
        feed.put(wide, 0, self.rates.ends().others);
        let Ends { states, sizes, .. } = self.rates.ends();
        for k in 0..nx {
            (states[k], sizes[k]) = (x[k], wide.store(wide.abs(wide.load(&x[k]))));
        }
        for (stage, (next, instant)) in STAGES.into_iter().enumerate() {
            self.rates.evaluate(wide);
            let weight = [1.0, 2.0, 2.0, 1.0][stage] / 6.0;
            let (share, reach) = (wide.mul(h, wide.splat(weight)), wide.mul(h, wide.splat(next)));
            let Ends { states, sizes, others, values } = self.rates.ends();
            for k in 0..nx {
                let mut rate = wide.load(&values[k]);
                if k < self.velocities {
                    rate = wide.add(rate, wide.load(&self.acceleration[k]));
                }
                let before = if stage == 0 { wide.load(&x[k]) } else { wide.load(&self.sum[k]) };
                self.sum[k] = wide.store(wide.plus(before, share, rate));
                let there = wide.plus(wide.load(&x[k]), reach, rate);
                (states[k], sizes[k]) = (wide.store(there), wide.store(wide.abs(there)));
            }
            self.jacobian[stage].copy_from_slice(&values[nx..nx + by_state]);
            self.direct[stage].copy_from_slice(&values[nx + by_state..nx + by_state + by_parameter]);
            if let Some(instant) = instant {
                feed.put(wide, instant, others);
            }
        }
        x[..nx].copy_from_slice(&self.sum[..nx]);
    }

    /// Computes the B_g, and Φ with its columns for the random forces.
    #[inline(always)]
    fn products<W: Wide<L>>(&mut self, wide: W, h: &[f64; L]) {
        let nx = self.dynamics.states.len();
        let n = nx + self.processes.steps.len();
        let entries = &self.dynamics.rates.by_state;
        let (phi, mobility, reached) = (&mut self.phi[..], &self.mobility[..], &self.reached[..]);
        let h = wide.load(h);
        let (sixth, third) = (wide.mul(h, wide.splat(1.0 / 6.0)), wide.mul(h, wide.splat(1.0 / 3.0)));
        identity(wide, &mut self.b[3], nx, sixth);
        for (stage, own, reach) in [(2, third, 1.0), (1, third, 0.5), (0, sixth, 0.5)] {
            let (before, after) = self.b.split_at_mut(stage + 1);
            identity(wide, &mut before[stage], nx, own);
            let reach = wide.mul(h, wide.splat(reach));
            let j = (&entries[..], &self.jacobian[stage + 1][..]);
            times(wide, (&mut before[stage], nx), (&after[0], nx), reached, j, reach);
        }
        wide.clear(phi);
        for k in 0..nx {
            phi[k * n + k] = [1.0; L];
        }
        for stage in 0..4 {
            let j = (&entries[..], &self.jacobian[stage][..]);
            times(wide, (phi, n), (&self.b[stage], nx), reached, j, wide.splat(1.0));
        }
        let ([b0, b1, b2, b3], sums) = (&self.b, &mut self.sum[..]);
        let (b0, b1, b2, b3) = (&b0[..], &b1[..], &b2[..], &b3[..]);
        for i in 0..nx {
            for row in 0..self.velocities {
                let at = i * nx + row;
                let mut sum = wide.load(&b0[at]);
                for b in [b1, b2, b3] {
                    sum = wide.add(sum, wide.load(&b[at]));
                }
                sums[row] = wide.store(sum);
            }
            for k in 0..self.forces {
                let mut sum = wide.splat(0.0);
                for row in 0..self.velocities {
                    sum = wide.plus(sum, wide.load(&sums[row]), wide.load(&mobility[row * self.forces + k]));
                }
                let mean = wide.load(&self.processes.get(k, |s| s.mean));
                phi[i * n + nx + k] = wide.store(wide.mul(sum, mean));
            }
        }
        for k in 0..self.processes.steps.len() {
            phi[(nx + k) * n + nx + k] = self.processes.get(k, |s| s.decay);
        }
    }

    /// Computes W: the effect of the noise on the processes, of a random force on the velocities
    /// and, through them, on the states that they drive.
    #[inline(always)]
    fn spread<W: Wide<L>>(&mut self, wide: W, h: &[f64; L]) {
        let nx = self.dynamics.states.len();
        let all = self.processes.steps.len();
        let sources = 3 * self.forces + (all - self.forces);
        let h = wide.load(h);
        let w = &mut self.w[..];
        // if noise changes a velocity by e, the states that it drives change by h/2 J e, and by
        // h/√12 J e from an independent source
        let (half, own) = (wide.mul(h, wide.splat(0.5)), wide.mul(h, wide.splat(1.0 / 12f64.sqrt())));
        wide.clear(w);
        for k in 0..self.forces {
            let drift = wide.load(&self.processes.get(k, |s| s.drift));
            for row in 0..self.velocities {
                let drift = wide.mul(wide.load(&self.mobility[row * self.forces + k]), drift);
                w[row * sources + 3 * k] = wide.store(drift);
            }
            for (entry, j) in self.dynamics.rates.by_state.iter().zip(self.jacobian[3].iter()) {
                if entry.row < self.velocities || entry.column >= self.velocities {
                    continue;
                }
                let by = wide.mul(wide.load(j), wide.load(&w[entry.column * sources + 3 * k]));
                for (column, share) in [(3 * k, half), (3 * k + 2, own)] {
                    let at = &mut w[entry.row * sources + column];
                    *at = wide.store(wide.plus(wide.load(at), share, by));
                }
            }
            let state = (nx + k) * sources + 3 * k;
            w[state] = self.processes.get(k, |s| s.shared);
            w[state + 1] = self.processes.get(k, |s| s.own);
        }
        for k in self.forces..all {
            w[(nx + k) * sources + 2 * self.forces + k] = self.processes.get(k, |s| s.shared.hypot(s.own));
        }
    }

    /// Carries ∂x/∂θ over the step that was predicted last.
    #[inline(always)]
    pub fn carry<W: Wide<L>>(&self, wide: W, sensitivities: &mut Sensitivities<L>) {
        let nx = self.dynamics.states.len();
        let n = nx + self.processes.steps.len();
        let p = sensitivities.columns;
        let Sensitivities { s, next, .. } = &mut *sensitivities;
        let (s, next, phi) = (&s[..], &mut next[..], &self.phi[..]);
        for i in 0..n {
            let row = &mut next[i * p..(i + 1) * p];
            let (phi, filled) = (&phi[i * n..(i + 1) * n], self.work.filled(i));
            combined(wide, phi, filled, s, row);
        }
        for (direct, b) in self.direct.iter().zip(&self.b) {
            let b = &b[..];
            for (entry, value) in self.dynamics.rates.by_parameter.iter().zip(direct.iter()) {
                let value = wide.load(value);
                for i in &self.reached[entry.row] {
                    let to = &mut next[i * p + entry.column];
                    *to = wide.store(wide.plus(wide.load(to), wide.load(&b[i * nx + entry.row]), value));
                }
            }
        }
        std::mem::swap(&mut sensitivities.s, &mut sensitivities.next);
    }
}

impl Transition<'_, 1> {
    /// Adds a random draw of the noise of the step that was predicted last.
    pub fn push(&self, x: &mut [[f64; 1]], noise: &mut Noise) {
        let sources = self.w.len() / x.len().max(1);
        let unit: Vec<f64> = (0..sources).map(|_| noise.normal()).collect();
        for (i, x) in x.iter_mut().enumerate() {
            let row = &self.w[i * sources..(i + 1) * sources];
            x[0] += row.iter().zip(&unit).map(|(w, unit)| w[0] * unit).sum::<f64>();
        }
    }
}

/// `diagonal` times the identity.
#[inline(always)]
fn identity<W: Wide<L>, const L: usize>(wide: W, to: &mut [[f64; L]], n: usize, diagonal: W::Value) {
    wide.clear(to);
    for k in 0..n {
        to[k * n + k] = wide.store(diagonal);
    }
}

/// Whether state i depends on state k over a step, directly or through others; elsewhere the B_g,
/// and Φ, are 0.
fn follows(entries: &[Entry], nx: usize) -> Vec<Vec<bool>> {
    let mut follows: Vec<Vec<bool>> = (0..nx).map(|i| (0..nx).map(|k| i == k).collect()).collect();
    entries.iter().for_each(|entry| follows[entry.row][entry.column] = true);
    for between in 0..nx {
        let further = follows[between].clone();
        for row in follows.iter_mut().filter(|row| row[between]) {
            row.iter_mut().zip(&further).for_each(|(follows, further)| *follows |= further);
        }
    }
    follows
}

/// to ← Σ aₖ sₖ over the rows `filled` of s, which are as long as `to`.
#[inline(always)]
pub(super) fn combined<W: Wide<L>, const L: usize>(
    wide: W,
    a: &[[f64; L]],
    filled: &[usize],
    s: &[[f64; L]],
    to: &mut [[f64; L]],
) {
    let width = to.len();
    let (fours, rest) = to.as_chunks_mut::<4>();
    let done = 4 * fours.len();
    for (at, to) in fours.iter_mut().enumerate() {
        summed(wide, a, filled, &s[4 * at..], width, to);
    }
    for (at, to) in rest.as_chunks_mut::<1>().0.iter_mut().enumerate() {
        summed(wide, a, filled, &s[done + at..], width, to);
    }
}

/// `C` of these sums, which stay in registers and do not wait for each other.
#[inline(always)]
fn summed<const C: usize, W: Wide<L>, const L: usize>(
    wide: W,
    a: &[[f64; L]],
    filled: &[usize],
    s: &[[f64; L]],
    width: usize,
    to: &mut [[f64; L]; C],
) {
    let mut sums = [wide.splat(0.0); C];
    for k in filled {
        let (a, from) = (wide.load(&a[*k]), &s[k * width..k * width + C]);
        for c in 0..C {
            sums[c] = wide.plus(sums[c], a, wide.load(&from[c]));
        }
    }
    for c in 0..C {
        to[c] = wide.store(sums[c]);
    }
}

/// to ← to + factor · b J with J sparse. `to` has rows of `width` elements and `b` rows of `n`;
/// column k of b may be nonzero in the rows `reached[k]` only.
#[inline(always)]
fn times<W: Wide<L>, const L: usize>(
    wide: W,
    (to, width): (&mut [[f64; L]], usize),
    (b, n): (&[[f64; L]], usize),
    reached: &[Vec<usize>],
    (entries, j): (&[Entry], &[[f64; L]]),
    factor: W::Value,
) {
    for (entry, value) in entries.iter().zip(j) {
        let value = wide.mul(wide.load(value), factor);
        for i in &reached[entry.row] {
            let at = &mut to[i * width + entry.column];
            *at = wide.store(wide.plus(wide.load(at), wide.load(&b[i * n + entry.row]), value));
        }
    }
}
