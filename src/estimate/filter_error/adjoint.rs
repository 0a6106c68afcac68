//! The backward pass through the filter: the gradient of the likelihood by the noise, at the cost
//! of three passes, however many unknowns the noise has.
//!
//! ```text
//! λ = ∂L/∂x, Λ = ∂L/∂P, L = −ln L;  c, K = P cᵀ/s', F, W: of the forward pass
//! ψ, s': of the tails,  a = d ln(s'/s)/d ln|z|
//! sample:      ē = ψ/√s + (1 − a) λK + a Kᵀ Λ K s'/e
//!              s̄ = ½ (c − ψz)/s + (1 − ½a) (Kᵀ Λ K s' − λK e)/s,    ∂L/∂R = s̄
//!              ḡ = λ e/s' − 2 Λ K
//!              λ ← λ − cᵀ ē,        Λ ← Λ + ½ (ḡ c + cᵀ ḡᵀ) + s̄ cᵀc
//! prediction:  ∂L/∂F = 2 Λ F P + λ x ᵀ,   ∂L/∂(W Wᵀ) = Λ,     λ ← Fᵀ λ,   Λ ← Fᵀ Λ F
//! ```
//!
//! F and c are held at the values where the forward pass was linearised: the effect of their
//! dependence on the state is of the order of the innovations, whose mean is zero. Giles,
//! *Collected matrix derivative results for forward and reverse mode algorithmic differentiation*
//! (2008), for the rules; Griewank, *Optimization Methods and Software* 1 (1992) 35-54, for the
//! checkpoints from which the forward pass is repeated, so that no log is too long for the memory.

use super::gauss_markov;
use super::noise::{Coordinate, NoiseModel};
use super::sensor::Innovation;
use super::tails;
use super::transition::{Belief, Transition};
use crate::simd::{Lanes, Wide};

/// Half-width in ln T of the central differences of the process over a step; their error is of the
/// order of its square.
const MOVE: f64 = 1e-4;

/// An operation of the forward pass.
#[derive(Debug, Clone, Copy)]
enum Mark {
    /// A prediction.
    Step,
    /// A sample: its output, and the number of states that the output sees.
    Sample(usize, usize),
}

/// Derivatives by ln T of what a process does over a step.
#[derive(Debug, Clone, Copy, Default)]
struct Slopes {
    decay: f64,
    /// Of ln κ.
    mean: f64,
    /// Of ln cov(w_v) and ln cov(w_d, w_v).
    drift: f64,
    shared: f64,
    /// Of cov(w_d), and cov(w_d) itself.
    own: f64,
    variance: f64,
}

impl Slopes {
    fn of(time: f64, rms: f64, h: f64) -> Slopes {
        if h <= 0.0 {
            return Slopes::default();
        }
        let at = |log: f64| gauss_markov::step(rms, time * log.exp(), h);
        let (less, more) = (at(-MOVE), at(MOVE));
        let slope = |part: fn(&gauss_markov::Step) -> f64| (part(&more) - part(&less)) / (2.0 * MOVE);
        let by_log = |part: fn(&gauss_markov::Step) -> f64| {
            let slope = (part(&more).ln() - part(&less).ln()) / (2.0 * MOVE);
            if slope.is_finite() { slope } else { 0.0 }
        };
        let variance = |s: &gauss_markov::Step| s.shared * s.shared + s.own * s.own;
        Slopes {
            decay: slope(|s| s.decay),
            mean: by_log(|s| s.mean),
            drift: 2.0 * by_log(|s| s.drift),
            shared: by_log(|s| s.drift * s.shared),
            own: slope(variance),
            variance: variance(&at(0.0)),
        }
    }
}

/// The record of the forward pass that the backward pass needs, and the state of the backward pass.
pub(super) struct Tape<const L: usize> {
    noise: NoiseModel,
    /// Number of model states, and of all states.
    states: (usize, usize),
    /// Limit beyond which innovations are held back, and the factor c of the likelihood.
    limit: f64,
    share: f64,
    marks: Vec<Mark>,
    numbers: Vec<[f64; L]>,
    /// States that the samples see, in the order of the samples.
    seen: Vec<usize>,
    /// λ, Λ.
    lambda: Lanes<L>,
    curvature: Lanes<L>,
    /// Work space: Λ F, and Λ K or another vector.
    product: Lanes<L>,
    turned: Lanes<L>,
    /// Time step of each lane, and the slopes of the processes over it.
    h: [f64; L],
    slopes: Vec<[Slopes; L]>,
    /// ∂L by ln rms and ln T of each process, and by ln of the white standard deviation of each
    /// sensor.
    by_process: Vec<[[f64; L]; 2]>,
    by_sensor: Vec<[f64; L]>,
}

impl<const L: usize> Tape<L> {
    /// Creates the tape of a filter with `states` model states under `noise`, the same in all
    /// lanes; `limit` and c (`share`) as in the likelihood.
    pub fn new(noise: &NoiseModel, states: usize, limit: f64, share: f64) -> Tape<L> {
        let n = states + noise.processes();
        Tape {
            states: (states, n),
            limit,
            share,
            marks: Vec::new(),
            numbers: Vec::new(),
            seen: Vec::new(),
            lambda: Lanes::zeros(n),
            curvature: Lanes::zeros(n * n),
            product: Lanes::zeros(n * n),
            turned: Lanes::zeros(n),
            h: [0.0; L],
            slopes: vec![[Slopes::default(); L]; noise.processes()],
            by_process: vec![[[0.0; L]; 2]; noise.processes()],
            by_sensor: vec![[0.0; L]; noise.sensors.len()],
            noise: noise.clone(),
        }
    }

    /// Records a sample.
    #[inline(always)]
    pub fn sample(&mut self, at: &Innovation<'_, L>) {
        self.numbers.extend_from_slice(at.gain);
        self.numbers.extend(at.states.iter().map(|state| at.c[*state]));
        self.numbers.extend([at.present, at.e, at.s]);
        self.seen.extend_from_slice(at.states);
        self.marks.push(Mark::Sample(at.output, at.states.len()));
    }

    /// Records what a prediction starts from: column of P and mean of each process.
    #[inline(always)]
    pub fn before<W: Wide<L>>(&mut self, wide: W, belief: &Belief<L>) {
        let (nx, n) = self.states;
        for process in nx..n {
            belief.p.column(wide, process, &mut self.turned);
            self.numbers.extend_from_slice(&self.turned);
            self.numbers.push(belief.x[process]);
        }
    }

    /// Records a prediction.
    #[inline(always)]
    pub fn step(&mut self, transition: &Transition<'_, L>, h: [f64; L]) {
        let (nx, n) = self.states;
        let (phi, w, sources) = transition.kept();
        self.numbers.extend_from_slice(&phi[..nx * n]);
        self.numbers.extend((nx..n).map(|k| phi[k * n + k]));
        for force in 0..self.noise.forces.len() {
            self.numbers.extend((0..nx).map(|i| w[i * sources + 3 * force]));
            self.numbers.extend((0..nx).map(|i| w[i * sources + 3 * force + 2]));
            self.numbers.push(w[(nx + force) * sources + 3 * force]);
        }
        self.numbers.push(h);
        self.marks.push(Mark::Step);
    }

    /// Runs the backward pass over the record, and clears the record.
    #[inline(always)]
    pub fn unwind<W: Wide<L>>(&mut self, wide: W) {
        while let Some(mark) = self.marks.pop() {
            match mark {
                Mark::Sample(output, sees) => self.back_over_sample(wide, output, sees),
                Mark::Step => self.back_over_step(wide),
            }
        }
    }

    #[inline(always)]
    fn back_over_sample<W: Wide<L>>(&mut self, wide: W, output: usize, sees: usize) {
        let n = self.states.1;
        let numbers = &self.numbers[self.numbers.len() - (n + sees + 3)..];
        let (gain, rest) = numbers.split_at(n);
        let (c, rest) = rest.split_at(sees);
        let [present, e, s] = [rest[0], rest[1], rest[2]];
        let seen = &self.seen[self.seen.len() - sees..];
        // λ K, Λ K and Kᵀ Λ K
        let (mut along, mut bent) = (wide.splat(0.0), wide.splat(0.0));
        for i in 0..n {
            let own = wide.load(&gain[i]);
            along = wide.plus(along, wide.load(&self.lambda[i]), own);
            let mut sum = wide.splat(0.0);
            for j in 0..n {
                sum = wide.plus(sum, wide.load(&self.curvature[i * n + j]), wide.load(&gain[j]));
            }
            self.turned[i] = wide.store(sum);
            bent = wide.plus(bent, sum, own);
        }
        let (along, bent) = (wide.store(along), wide.store(bent));
        let (mut by_e, mut by_s, mut moved) = ([0.0; L], [0.0; L], [0.0; L]);
        for lane in 0..L {
            if present[lane] == 0.0 {
                continue;
            }
            let (e, s) = (e[lane], s[lane]);
            let root = s.sqrt();
            let z = e / root;
            let place = tails::place(z, self.limit);
            let (psi, bend, taken) = (place.pull.copysign(z), place.bend, place.taken(z, s));
            // x₊ = x + g e/s', P₊ = P − g gᵀ/s'
            let of_gain = if bend > 0.0 { bend * bent[lane] * taken / e } else { 0.0 };
            by_e[lane] = psi / root + (1.0 - bend) * along[lane] + of_gain;
            by_s[lane] =
                (0.5 * (self.share - psi * z) + (1.0 - 0.5 * bend) * (bent[lane] * taken - along[lane] * e)) / s;
            moved[lane] = e / taken;
            self.by_sensor[output][lane] +=
                2.0 * self.noise.sensors[output].std * self.noise.sensors[output].std * by_s[lane];
        }
        let (by_e, by_s, moved) = (wide.load(&by_e), wide.load(&by_s), wide.load(&moved));
        let half = wide.splat(0.5);
        // ½ ḡ
        for i in 0..n {
            let pull = wide.mul(wide.mul(wide.load(&self.lambda[i]), moved), half);
            self.turned[i] = wide.store(wide.sub(pull, wide.load(&self.turned[i])));
        }
        for (i, c) in seen.iter().zip(c) {
            let c = wide.load(c);
            self.lambda[*i] = wide.store(wide.sub(wide.load(&self.lambda[*i]), wide.mul(c, by_e)));
            for j in 0..n {
                let add = wide.mul(wide.load(&self.turned[j]), c);
                for at in [i * n + j, j * n + i] {
                    self.curvature[at] = wide.store(wide.add(wide.load(&self.curvature[at]), add));
                }
            }
        }
        for (i, a) in seen.iter().zip(c) {
            let a = wide.mul(wide.load(a), by_s);
            for (j, b) in seen.iter().zip(c) {
                let at = i * n + j;
                self.curvature[at] = wide.store(wide.plus(wide.load(&self.curvature[at]), a, wide.load(b)));
            }
        }
        self.numbers.truncate(self.numbers.len() - (n + sees + 3));
        self.seen.truncate(self.seen.len() - sees);
    }

    #[inline(always)]
    fn back_over_step<W: Wide<L>>(&mut self, wide: W) {
        let (nx, n) = self.states;
        let (processes, forces) = (n - nx, self.noise.forces.len());
        let size = processes * (n + 1) + nx * n + processes + forces * (2 * nx + 1) + 1;
        let begin = self.numbers.len() - size;
        let (before, rest) = self.numbers[begin..].split_at(processes * (n + 1));
        let (phi, rest) = rest.split_at(nx * n);
        let (decay, rest) = rest.split_at(processes);
        let (driven, h) = rest.split_at(forces * (2 * nx + 1));
        for lane in 0..L {
            if h[0][lane].to_bits() != self.h[lane].to_bits() {
                let coloured = self.noise.coloured().map(|(_, c)| (c.rms, c.time));
                let all = self.noise.forces.iter().map(|f| (f.rms, f.time)).chain(coloured);
                for (slopes, (rms, time)) in self.slopes.iter_mut().zip(all) {
                    slopes[lane] = Slopes::of(time, rms, h[0][lane]);
                }
                self.h[lane] = h[0][lane];
            }
        }
        let curvature = std::convert::identity(
            #[inline(always)]
            |i: usize, j: usize| wide.load(&self.curvature[i * n + j]),
        );
        // Λ F, row by row
        for i in 0..n {
            let row = &mut self.product[i * n..(i + 1) * n];
            wide.clear(&mut row[..nx]);
            for k in nx..n {
                row[k] = wide.store(wide.mul(curvature(i, k), wide.load(&decay[k - nx])));
            }
            for k in 0..nx {
                let factor = curvature(i, k);
                for (to, f) in row.iter_mut().zip(&phi[k * n..(k + 1) * n]) {
                    *to = wide.store(wide.plus(wide.load(to), factor, wide.load(f)));
                }
            }
        }
        for process in 0..processes {
            let at = nx + process;
            let (column, mean) = before[process * (n + 1)..(process + 1) * (n + 1)].split_at(n);
            let mean = wide.load(&mean[0]);
            // ∂L/∂F in the column of the process
            let by_f = std::convert::identity(
                #[inline(always)]
                |i: usize| {
                    let mut sum = wide.splat(0.0);
                    for j in 0..n {
                        sum = wide.plus(sum, wide.load(&self.product[i * n + j]), wide.load(&column[j]));
                    }
                    wide.plus(wide.add(sum, sum), wide.load(&self.lambda[i]), mean)
                },
            );
            let mut by_mean = wide.splat(0.0);
            let (mut drifts, mut goes_with, mut shared) = (wide.splat(0.0), wide.splat(0.0), [0.0; L]);
            if process < forces {
                for i in 0..nx {
                    by_mean = wide.plus(by_mean, by_f(i), wide.load(&phi[i * n + at]));
                }
                let own = &driven[process * (2 * nx + 1)..(process + 1) * (2 * nx + 1)];
                shared = own[2 * nx];
                for i in 0..nx {
                    let (v, u) = (&own[..nx], &own[nx..2 * nx]);
                    goes_with = wide.plus(goes_with, curvature(at, i), wide.load(&v[i]));
                    let (mut by_v, mut by_u) = (wide.splat(0.0), wide.splat(0.0));
                    for j in 0..nx {
                        by_v = wide.plus(by_v, curvature(i, j), wide.load(&v[j]));
                        by_u = wide.plus(by_u, curvature(i, j), wide.load(&u[j]));
                    }
                    drifts = wide.plus(wide.plus(drifts, by_v, wide.load(&v[i])), by_u, wide.load(&u[i]));
                }
            }
            let by_decay = wide.store(by_f(at));
            let (by_mean, drifts, goes_with) = (wide.store(by_mean), wide.store(drifts), wide.store(goes_with));
            let stays = self.curvature[at * n + at];
            for lane in 0..L {
                let slopes = self.slopes[process][lane];
                let together = 2.0 * goes_with[lane] * shared[lane];
                let [by_rms, by_time] = &mut self.by_process[process];
                by_rms[lane] += 2.0 * (drifts[lane] + together + stays[lane] * slopes.variance);
                by_time[lane] += by_mean[lane] * slopes.mean
                    + by_decay[lane] * slopes.decay
                    + drifts[lane] * slopes.drift
                    + together * slopes.shared
                    + stays[lane] * slopes.own;
            }
        }
        // Fᵀ λ, Fᵀ Λ F
        self.turned.copy_from_slice(&self.lambda);
        for j in 0..n {
            let mut sum = wide.splat(0.0);
            for i in 0..nx {
                sum = wide.plus(sum, wide.load(&phi[i * n + j]), wide.load(&self.turned[i]));
            }
            if j >= nx {
                sum = wide.plus(sum, wide.load(&decay[j - nx]), wide.load(&self.turned[j]));
            }
            self.lambda[j] = wide.store(sum);
        }
        for i in 0..n {
            for j in i..n {
                let mut sum = wide.splat(0.0);
                for k in 0..nx {
                    sum = wide.plus(sum, wide.load(&phi[k * n + i]), wide.load(&self.product[k * n + j]));
                }
                if i >= nx {
                    sum = wide.plus(sum, wide.load(&decay[i - nx]), wide.load(&self.product[i * n + j]));
                }
                let sum = wide.store(sum);
                (self.curvature[i * n + j], self.curvature[j * n + i]) = (sum, sum);
            }
        }
        self.numbers.truncate(begin);
    }

    /// ∂L by a state at the beginning and by its variance, by lane. Valid after the backward pass
    /// has reached the beginning.
    pub fn by_beginning(&self, state: usize) -> [[f64; L]; 2] {
        [self.lambda[state], self.curvature[state * self.states.1 + state]]
    }

    /// ∂L by the logarithm of an unknown, summed over all lanes. Valid after the backward pass has
    /// reached the beginning.
    pub fn slope(&self, coordinate: Coordinate) -> f64 {
        let (nx, n) = self.states;
        // a process begins with its stationary variance rms²
        let process = |k: usize, rms: f64| -> f64 {
            let at = (nx + k) * n + nx + k;
            (0..L).map(|lane| self.by_process[k][0][lane] + 2.0 * rms * rms * self.curvature[at][lane]).sum()
        };
        let coloured = |output: usize| {
            let own = self.noise.coloured().position(|(c, _)| c == output);
            own.map(|k| (self.noise.forces.len() + k, self.noise.sensors[output].coloured.map_or(0.0, |c| c.rms)))
        };
        let time = |k: usize| self.by_process[k][1].iter().sum();
        match coordinate {
            Coordinate::ForceRms(k) => process(k, self.noise.forces[k].rms),
            Coordinate::ForceTime(k) => time(k),
            Coordinate::Sensor(output) => self.by_sensor[output].iter().sum(),
            Coordinate::ColouredRms(output) => coloured(output).map_or(0.0, |(k, rms)| process(k, rms)),
            Coordinate::ColouredTime(output) => coloured(output).map_or(0.0, |(k, _)| time(k)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::filter_error::information::Asked;
    use crate::estimate::filter_error::noise::{Coloured, RandomForce, SensorNoise};
    use crate::estimate::filter_error::{FilterErrorOptions, Filtered};
    use crate::tank::{BlindOptions, blind};

    /// Slopes of the likelihood by the backward pass and by central differences, both times the
    /// standard deviation of the unknown by its own information: [slope, difference].
    fn compared(options: &BlindOptions, limit: f64) -> Vec<(Coordinate, [f64; 2])> {
        let campaign = blind(options).unwrap();
        let model = &campaign.truth;
        let filtered = Filtered::new(model, &campaign.runs, &FilterErrorOptions::default().base).unwrap();
        let mobilities = filtered.mobilities(model).unwrap();
        let dynamics = &filtered.problem.dynamics;
        let force =
            |(k, dof): (usize, &crate::frame::Dof)| RandomForce { dof: *dof, rms: 0.5, time: [0.3, 2.0][k % 2] };
        let sensor = |(k, std): (usize, &f64)| {
            let coloured = (k == 1).then_some(Coloured { rms: 0.5 * std, time: 0.4 });
            SensorNoise { std: 1.5 * std, coloured }
        };
        let mut noise = NoiseModel {
            forces: dynamics.velocities().iter().enumerate().map(force).collect(),
            sensors: filtered.problem.sigma.iter().enumerate().map(sensor).collect(),
        };
        let unknowns = noise.coordinates();
        let (_, slopes) = filtered.slopes(model, &noise, &unknowns, &mobilities, limit);
        let information = filtered.noise_information(model, &noise, &unknowns, &mobilities, limit, Asked::All);
        let mut cost = |unknown: Coordinate, by: f64| {
            let here = noise.at(unknown);
            noise.set(unknown, here + by);
            let linear = filtered.linearise(model, &noise, &mobilities, limit, false);
            noise.set(unknown, here);
            0.5 * linear.iter().map(|l| l.cost).sum::<f64>()
        };
        let mut all = Vec::new();
        for (k, unknown) in unknowns.into_iter().enumerate() {
            let step = 1e-3;
            let difference = (cost(unknown, step) - cost(unknown, -step)) / (2.0 * step);
            let deviation = information[(k, k)].sqrt().recip();
            all.push((unknown, [slopes[k] * deviation, difference * deviation]));
        }
        all
    }

    /// The backward pass neglects that F depends on the state: an error of about a thousandth of a
    /// standard deviation and of the slope itself. Runs of 300 s have several legs, which are taken
    /// back one after the other.
    #[test]
    fn slopes_of_the_likelihood_are_those_of_its_differences() {
        let plane = BlindOptions { duration: 60.0, ..BlindOptions::default() };
        let cases = [
            (plane.clone(), f64::INFINITY),
            (plane.clone(), 2.0),
            (BlindOptions { duration: 300.0, ..plane.clone() }, f64::INFINITY),
            (BlindOptions { six: true, ..plane }, f64::INFINITY),
        ];
        for (k, (options, limit)) in cases.into_iter().enumerate() {
            for (unknown, [slope, difference]) in compared(&options, limit) {
                assert!(
                    (slope - difference).abs() < 0.002 * (1.0 + difference.abs()),
                    "{k} {unknown:?}: {slope} {difference}"
                );
            }
        }
    }
}
