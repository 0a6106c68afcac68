//! Steps of the noise that increase the likelihood.
//!
//! ```text
//! (I + λ diag I) δ = −g        g, I: gradient and information of −ln L by the logarithms of the noise
//! ```
//!
//! The gradient comes from the backward pass through the filter ([`super::adjoint`]). The curvature
//! is Fisher's information ([`super::information`]); it is kept while the noise hardly moves, and
//! near the maximum it is corrected by what the last steps have shown ([`super::quasi_newton`]).

use nalgebra::{DMatrix, DVector};

use super::information::Asked;
use super::noise::Coordinate;
use super::options::Forces;
use super::start::Prior;
use super::steps::Search;

/// Share of its starting value below which a force counts as zero.
const NOTHING: f64 = 1e-3;

/// Least white part of a sensor's noise beside a correlated one. A smaller white part adds less
/// than a hundredth to what a sample tells anew, and the likelihood would reduce it for ever.
const LEAST_WHITE: f64 = 0.05;

/// Information that is added to that of each logarithm. An unknown of which the data know less,
/// with a standard deviation of three or more, then goes no further than its slope asks, and does
/// not shorten the steps of the others.
pub(super) const FLAT: f64 = 0.1;

/// A logarithm that can move less than a tenth of this stands at its bound.
const NEAR: f64 = 0.1;

/// Least damping of the noise other than zero, and the factor by which damping is reduced after a
/// successful step.
const LEAST_DAMPING: f64 = 0.1;
const EASED: f64 = 0.03;

/// Damping beyond which a step is given up: if a millionth of a step gains nothing, nothing is to
/// be gained.
const MOST_DAMPING: f64 = 1e6;

/// Ratio of the actual to the promised fall beyond which the next step is taken twice as long, and
/// the greatest multiple of its length at which a step is taken.
const FLATTER: f64 = 1.3;
const STRETCHED: f64 = 8.0;

/// Fall of −2 ln L promised by a step, below which the curvature is learnt from the steps before
/// it.
pub(super) const NEAR_TOP: f64 = 30.0;

/// Share of a learnt step that is tried if the whole step lowers the likelihood.
const PART: f64 = 0.25;

/// Longest step of a logarithm.
pub(super) const FARTHEST: f64 = 2.0;

/// Change of a logarithm within which the information is taken as unchanged.
const LIKE: f64 = 0.5;

/// Fisher's information on the noise, which costs as much as a dozen passes.
#[derive(Clone)]
pub(super) struct Informed {
    /// The unknowns that it concerns.
    coordinates: Vec<Coordinate>,
    /// The point at which it was computed.
    at: DVector<f64>,
    information: DMatrix<f64>,
}

impl Informed {
    /// Whether it is still accurate enough for these unknowns at this point.
    fn is_near(&self, coordinates: &[Coordinate], at: &DVector<f64>) -> bool {
        self.coordinates == coordinates && (at - &self.at).amax() < LIKE
    }
}

impl Search<'_> {
    /// The estimated unknowns of the noise: of forces if these are estimated, of sensors, of
    /// coloured parts.
    pub(super) fn coordinates(&self) -> Vec<Coordinate> {
        let free = |c: &Coordinate| match c {
            Coordinate::ForceRms(_) | Coordinate::ForceTime(_) => self.options.forces.is_estimated(),
            Coordinate::Sensor(output) => !self.silent[*output],
            _ => true,
        };
        self.noise.coordinates().into_iter().filter(free).collect()
    }

    /// Takes one step of the noise; returns by how much −2 ln L was predicted to fall.
    pub(super) fn step_noise(&mut self) -> f64 {
        self.drop_nothings();
        let coordinates = self.coordinates();
        if coordinates.is_empty() {
            return 0.0;
        }
        self.follow_inertia();
        let (mut gradient, mut information) = self.scored(&coordinates);
        // an unknown that stands at its bound and would leave it stays there
        let mut held = vec![false; coordinates.len()];
        for (k, c) in coordinates.iter().enumerate() {
            if self.is_bound(*c, gradient[k]) {
                held[k] = true;
                gradient[k] = 0.0;
                information.row_mut(k).fill(0.0);
                information.column_mut(k).fill(0.0);
                information[(k, k)] = 1.0;
            }
        }
        let at = DVector::from_iterator(coordinates.len(), coordinates.iter().map(|c| self.noise.at(*c)));
        self.quasi.learn(&at, &gradient, &held);
        let damped = |damping: f64, gradient: &DVector<f64>| {
            let mut damped = information.clone();
            for k in 0..coordinates.len() {
                damped[(k, k)] = damped[(k, k)] * (1.0 + damping) + FLAT;
            }
            Some(damped.cholesky()?.solve(gradient))
        };
        let damped_step = |damping: f64| damped(damping, &-&gradient);
        // twice the fall of −ln L that the quadratic promises for the whole step
        let Some(whole) = damped_step(0.0).map(|step| -gradient.dot(&step)) else { return 0.0 };
        let mut learnt =
            if whole < NEAR_TOP { self.quasi.step(&gradient, |gradient| damped(0.0, gradient)) } else { None };
        let (mut part, mut direction) = (1.0, learnt.clone());
        let whole = learnt.as_ref().map_or(whole, |step| whole.max(-gradient.dot(step)));
        if whole < 0.1 * self.tolerance {
            return whole.max(0.0);
        }
        // a step that was too long is not tried at full length again at once
        let remembered = self.noise_damping;
        let mut damping = remembered;
        loop {
            let from_steps = learnt.take().map(|step| part * step);
            let is_learnt = from_steps.is_some();
            let Some(mut step) = from_steps.or_else(|| damped_step(damping)) else { return 0.0 };
            let promised = -gradient.dot(&step);
            // a long step keeps its direction: of two unknowns that go together, one alone may lead
            // up, and the fit of a model that lacks much would end elsewhere
            let scale = (FARTHEST / step.amax().max(f64::MIN_POSITIVE)).min(if is_learnt { 1.0 } else { self.stretch });
            let mut trial = self.noise.clone();
            for (k, c) in coordinates.iter().enumerate() {
                let now = trial.at(*c);
                let next = self.bounded(*c, now + scale * step[k]);
                trial.set(*c, next);
                step[k] = next - now;
            }
            let (next, cost) = self.linearised(&self.model, &trial);
            self.passes += 1;
            if cost.is_finite() && cost <= self.cost + 1e-9 * self.cost.abs() {
                let fell = self.cost - cost;
                self.noise = trial;
                self.take(next, cost);
                let at_once = damping <= remembered;
                // where the likelihood rises by clearly more than the quadratic promises, its
                // curvature is smaller, and steps are made longer
                self.stretch =
                    if at_once && fell > FLATTER * promised { (2.0 * self.stretch).min(STRETCHED) } else { 1.0 };
                self.noise_damping = if damping * EASED < LEAST_DAMPING { 0.0 } else { damping * EASED };
                // a learnt step ends the search if it promises little, but not if the fall is small
                if at_once && damping > 0.0 || is_learnt {
                    return whole;
                }
                return if scale < 1.0 { promised } else { promised.min(fell.max(0.1 * self.tolerance)) };
            }
            if is_learnt {
                // try a part of it; if that leads down as well, what was learnt elsewhere does not
                // hold here
                match part {
                    1.0 => (part, learnt) = (PART, direction.take()),
                    _ => self.quasi.forget(),
                }
                continue;
            }
            (damping, self.stretch) = (f64::max(damping * 10.0, LEAST_DAMPING), 1.0);
            if damping > MOST_DAMPING {
                self.stuck = true;
                return 0.0;
            }
        }
    }

    /// Whether a logarithm stands at its bound and would leave it in descending this slope.
    pub(super) fn is_bound(&self, coordinate: Coordinate, slope: f64) -> bool {
        let now = self.noise.at(coordinate);
        let there = self.bounded(coordinate, now - NEAR * slope.signum());
        (there - now).abs() < 0.1 * NEAR
    }

    /// Gradient and information of −ln L by the noise, priors included. Linearises the stretches
    /// anew at the current point.
    pub(super) fn scored(&mut self, coordinates: &[Coordinate]) -> (DVector<f64>, DMatrix<f64>) {
        let mut gradient = DVector::from_vec(self.renew_with_slopes(coordinates));
        let Search { filtered, model, noise, mobilities, limit, informed, .. } = self;
        let at = DVector::from_iterator(coordinates.len(), coordinates.iter().map(|c| noise.at(*c)));
        if !informed.as_ref().is_some_and(|known| known.is_near(coordinates, &at)) {
            let information =
                filtered.noise_information(model, noise, coordinates, mobilities, *limit, Asked::Beginnings);
            *informed = Some(Informed { coordinates: coordinates.to_vec(), at: at.clone(), information });
        }
        let count = coordinates.len();
        let mut information =
            informed.as_ref().map_or_else(|| DMatrix::identity(count, count), |known| known.information.clone());
        let prior = Prior::new(coordinates, &self.stated);
        prior.inform(&mut information);
        for (k, of) in prior.of.iter().enumerate() {
            if let Some((mean, std)) = of {
                gradient[k] += (at[k] - mean) / (std * std);
            }
        }
        (gradient, information)
    }

    /// A logarithm, clamped to the range in which it has a meaning.
    pub(super) fn bounded(&self, coordinate: Coordinate, log: f64) -> f64 {
        match coordinate {
            Coordinate::Sensor(output) => {
                let coloured = self.noise.sensors[output].coloured.map_or(0.0, |c| LEAST_WHITE * c.rms);
                log.max(self.floors[output].max(coloured).ln())
            }
            Coordinate::ForceTime(_) | Coordinate::ColouredTime(_) => log.clamp(self.times.0.ln(), self.times.1.ln()),
            Coordinate::ForceRms(i) => {
                let most = match &self.options.forces {
                    Forces::Estimate { most } => most.get(&self.noise.forces[i].dof).copied(),
                    _ => None,
                };
                log.max((0.5 * NOTHING * self.strength(i)).ln()).min(most.unwrap_or(f64::INFINITY).ln())
            }
            Coordinate::ColouredRms(output) => log.max((1e-2 * self.floors[output]).ln()),
        }
    }

    fn strength(&self, force: usize) -> f64 {
        let dof = self.noise.forces[force].dof;
        self.strengths.iter().find(|(known, _)| *known == dof).map_or(0.0, |(_, strength)| *strength)
    }

    /// Removes the forces that have run to zero.
    pub(super) fn drop_nothings(&mut self) {
        if !self.options.forces.is_estimated() {
            return;
        }
        let keep: Vec<bool> =
            (0..self.noise.forces.len()).map(|i| self.noise.forces[i].rms > NOTHING * self.strength(i)).collect();
        let mut keep = keep.into_iter();
        self.noise.forces.retain(|_| keep.next().unwrap_or(true));
    }
}
