//! Update of the filter with one sample of one sensor.
//!
//! ```text
//! e = y − h(x) − b,    s = c P cᵀ + R,    K = P cᵀ/s,    x ← x + K e
//! ∂x/∂θ ← ∂x/∂θ + K ∂e/∂θ,    ∂e/∂θ = −(c ∂x/∂θ + ∂h/∂θ)
//! ```
//!
//! The update takes one scalar at a time, so that different rates, gaps and drop-outs need no
//! common grid. An innovation that is held back ([`super::tails`]) is taken in with s' in place of
//! s, like that of a less certain sensor. If it counted as much as any other, a filter that has
//! been left behind would be sure of itself, and hold back each sample that contradicts it.

use super::tails;
use super::transition::{Belief, Sensitivities, combined};
use crate::dynamics::Dynamics;
use crate::simd::{Lanes, Wide};
use crate::simulate::{Evaluator, Feed};
use crate::symbolic::Ends;

/// An innovation of each lane.
#[derive(Debug)]
pub(super) struct Innovation<'a, const L: usize> {
    /// Output that was measured.
    pub output: usize,
    /// 1 in lanes that have a sample, else 0.
    pub present: [f64; L],
    /// e, 0 without a sample.
    pub e: [f64; L],
    /// s, 1 without a sample.
    pub s: [f64; L],
    /// ∂e/∂θ; empty without sensitivities.
    pub gradient: &'a [[f64; L]],
    /// c, and the states outside which it is 0.
    pub c: &'a [[f64; L]],
    pub states: &'a [usize],
    /// K
    pub gain: &'a [[f64; L]],
    /// s', and the part of it that is the variance of the sensor.
    pub taken: [f64; L],
    pub variance: [f64; L],
}

/// The entries of an output's Jacobian.
#[derive(Debug, Clone, Default)]
struct Row {
    /// ∂h/∂x: index of the value in the plan (`None` for 1), and the state.
    by_state: Vec<(Option<usize>, usize)>,
    /// ∂h/∂θ: index of the value in the plan, and the column.
    direct: Vec<(usize, usize)>,
    /// State of its coloured noise.
    coloured: Option<usize>,
    /// All states that it sees, in order.
    states: Vec<usize>,
    /// Whether it is an angle, known up to whole turns.
    turns: bool,
}

/// The sensors of `L` lanes.
pub(super) struct Sensors<'a, const L: usize> {
    observe: Evaluator<'a, L>,
    rows: Vec<Row>,
    /// Variance of the white noise by output.
    variance: Vec<[f64; L]>,
    /// Whether the outputs are the first states.
    sees_states: bool,
    states: usize,
    /// State at which the outputs were evaluated, and the outputs there.
    at: Lanes<L>,
    predicted: Lanes<L>,
    c: Lanes<L>,
    gain: Lanes<L>,
    gradient: Lanes<L>,
    /// Number of standard deviations beyond which innovations are held back.
    limit: f64,
}

impl<'a, const L: usize> Sensors<'a, L> {
    /// The sensors of a compiled model; `coloured` gives the outputs whose noise has states, from
    /// `states` + `forces` on.
    pub fn new(
        dynamics: &Dynamics,
        observe: Evaluator<'a, L>,
        variance: Vec<[f64; L]>,
        (forces, coloured): (usize, &[usize]),
        columns: usize,
        limit: f64,
    ) -> Sensors<'a, L> {
        let (nx, ny) = (dynamics.states.len(), dynamics.outputs.len());
        let functions = &dynamics.observation;
        let sees_states = functions.plan.is_states(ny);
        let mut rows = vec![Row::default(); ny];
        if sees_states {
            rows.iter_mut().enumerate().for_each(|(k, row)| row.by_state.push((None, k)));
        } else {
            for (k, entry) in functions.by_state.iter().enumerate() {
                rows[entry.row].by_state.push((Some(ny + k), entry.column));
            }
            for (k, entry) in functions.by_parameter.iter().enumerate() {
                rows[entry.row].direct.push((ny + functions.by_state.len() + k, entry.column));
            }
        }
        for (k, output) in coloured.iter().enumerate() {
            rows[*output].coloured = Some(nx + forces + k);
        }
        for (row, name) in rows.iter_mut().zip(&dynamics.outputs) {
            row.turns = matches!(name.as_str(), "phi" | "psi");
            row.states = row.by_state.iter().map(|(_, state)| *state).chain(row.coloured).collect();
            row.states.sort_unstable();
            row.states.dedup();
        }
        let n = nx + forces + coloured.len();
        Sensors {
            observe,
            rows,
            variance,
            sees_states,
            states: nx,
            at: Lanes::zeros(nx),
            predicted: Lanes::zeros(ny),
            c: Lanes::zeros(n),
            gain: Lanes::zeros(n),
            gradient: Lanes::zeros(columns),
            limit,
        }
    }

    /// Evaluates the outputs at the predicted state; `instant` selects the inputs.
    #[inline(always)]
    pub fn look<W: Wide<L>>(&mut self, wide: W, feed: &Feed<'_, L>, instant: usize, x: &[[f64; L]]) {
        let (nx, ny) = (self.states, self.rows.len());
        self.at.copy_from_slice(&x[..nx]);
        if self.sees_states {
            self.predicted.copy_from_slice(&x[..ny]);
            return;
        }
        let Ends { states, sizes, others, .. } = self.observe.ends();
        feed.put(wide, instant, others);
        for k in 0..nx {
            (states[k], sizes[k]) = (x[k], wide.store(wide.abs(wide.load(&x[k]))));
        }
        self.observe.evaluate(wide);
        self.predicted.copy_from_slice(&self.observe.ends().values[..ny]);
    }

    /// Sets c of an output, 0 in lanes without a sample, and returns the output as predicted from
    /// the present state.
    #[inline(always)]
    fn row<W: Wide<L>>(&mut self, wide: W, output: usize, present: &[f64; L], x: &[[f64; L]]) -> W::Value {
        let row = &self.rows[output];
        let present = wide.load(present);
        wide.clear(&mut self.c);
        let mut y = wide.load(&self.predicted[output]);
        for (value, state) in &row.by_state {
            let c = match value {
                None => wide.splat(1.0),
                Some(value) => wide.load(&self.observe.ends().values[*value]),
            };
            y = wide.plus(y, c, wide.sub(wide.load(&x[*state]), wide.load(&self.at[*state])));
            self.c[*state] = wide.store(wide.only_where(c, present));
        }
        if let Some(state) = row.coloured {
            y = wide.add(y, wide.load(&x[state]));
            self.c[state] = wide.store(present);
        }
        y
    }

    /// Takes the samples `measured` of an output into account; NaN if a lane has none.
    #[inline(always)]
    pub fn update<W: Wide<L>>(
        &mut self,
        wide: W,
        output: usize,
        measured: &[f64; L],
        belief: &mut Belief<L>,
        sensitivities: &mut Option<Sensitivities<L>>,
        take: &mut impl FnMut(&Innovation<'_, L>),
    ) {
        let mut present = [0.0; L];
        for lane in 0..L {
            present[lane] = if measured[lane].is_nan() { 0.0 } else { 1.0 };
        }
        let predicted = wide.store(self.row(wide, output, &present, &belief.x));
        let turns = self.rows[output].turns;
        let (mut e, mut own) = ([0.0; L], [1.0; L]);
        for lane in (0..L).filter(|lane| present[*lane] > 0.0) {
            let difference = measured[lane] - predicted[lane];
            e[lane] = if turns { shortest(difference) } else { difference };
            own[lane] = self.variance[output][lane];
        }
        let (mut variance, mut expected) = (own, None);
        if self.limit.is_finite() {
            let s = wide.store(wide.add(belief.p.variance(wide, &self.c), wide.load(&own)));
            for lane in 0..L {
                // if s is not a number, nothing is held back, and the likelihood shows it
                let z = e[lane] / s[lane].sqrt();
                variance[lane] += (tails::place(z, self.limit).taken(z, s[lane]) - s[lane]).max(0.0);
            }
            expected = Some(s);
        }
        let at = (&self.c[..], &self.rows[output].states[..]);
        let taken = wide.store(belief.p.update(wide, at, wide.load(&variance), &mut self.gain));
        let s = expected.unwrap_or(taken);
        if let Some(sensitivities) = sensitivities {
            self.gradient(wide, output, &present, sensitivities);
        }
        let gradient = if sensitivities.is_some() { &self.gradient[..] } else { &[] };
        let (c, states, gain) = (&self.c[..], &self.rows[output].states[..], &self.gain[..]);
        take(&Innovation { output, present, e, s, gradient, c, states, gain, taken, variance });
        let e = wide.load(&e);
        for (x, gain) in belief.x.iter_mut().zip(self.gain.iter()) {
            *x = wide.store(wide.plus(wide.load(x), wide.load(gain), e));
        }
        if let Some(Sensitivities { s, columns, .. }) = sensitivities {
            for (row, gain) in s.chunks_exact_mut(*columns).zip(self.gain.iter()) {
                let gain = wide.load(gain);
                for (x, g) in row.iter_mut().zip(self.gradient.iter()) {
                    *x = wide.store(wide.plus(wide.load(x), gain, wide.load(g)));
                }
            }
        }
    }

    /// ∂e/∂θ = −(c ∂x/∂θ + ∂h/∂θ).
    #[inline(always)]
    fn gradient<W: Wide<L>>(&mut self, wide: W, output: usize, present: &[f64; L], sensitivities: &Sensitivities<L>) {
        let row = &self.rows[output];
        combined(wide, &self.c, &row.states, &sensitivities.s, &mut self.gradient);
        for to in self.gradient.iter_mut() {
            *to = wide.store(wide.neg(wide.load(to)));
        }
        let present = wide.load(present);
        for (value, column) in &row.direct {
            let direct = wide.only_where(wide.load(&self.observe.ends().values[*value]), present);
            let to = &mut self.gradient[*column];
            *to = wide.store(wide.sub(wide.load(to), direct));
        }
    }

    /// Whether an output is an angle, known up to whole turns.
    pub fn is_turn(&self, output: usize) -> bool {
        self.rows[output].turns
    }

    /// The predicted output, and the variance with which its sample is expected.
    #[inline(always)]
    pub fn expect<W: Wide<L>>(&mut self, wide: W, output: usize, belief: &Belief<L>) -> ([f64; L], [f64; L]) {
        let y = wide.store(self.row(wide, output, &[1.0; L], &belief.x));
        let variance = wide.add(belief.p.variance(wide, &self.c), wide.load(&self.variance[output]));
        (y, wide.store(variance))
    }
}

/// The difference of two angles, in [−π, π].
pub(super) fn shortest(difference: f64) -> f64 {
    difference - std::f64::consts::TAU * (difference / std::f64::consts::TAU).round()
}
