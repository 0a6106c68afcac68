//! Steps of the noise up the likelihood.
//!
//! ```text
//! (I + λ diag I) δ = −g        g, I: gradient and information of −ln L by the logarithms of the noise
//! ```
//!
//! The gradient by the way back through the filter ([`super::adjoint`]), the curvature is Fisher's
//! information ([`super::information`]), kept while the noise hardly moves and corrected near the top by what the last steps
//! have shown ([`super::quasi_newton`]).

use nalgebra::{DMatrix, DVector};

use super::information::Asked;
use super::noise::Coordinate;
use super::options::Forces;
use super::start::Prior;
use super::steps::Search;

/// Share of a force's start below which it is nothing.
const NOTHING: f64 = 1e-3;

/// Least white part of a sensor's noise beside a correlated one: it adds less than a hundredth to what a sample tells
/// anew, and the likelihood would lead it to nothing for ever.
const LEAST_WHITE: f64 = 0.05;

/// Information of a logarithm that is added to each: one of which the data know less, a deviation of three and more, goes
/// no further than its slope asks, and does not shorten the steps of the others.
pub(super) const FLAT: f64 = 0.1;

/// A logarithm that cannot go a tenth of this further stands at its bound.
const NEAR: f64 = 0.1;

/// Least damping of the noise beside none, and by how much it is eased after a step that leads up.
const LEAST_DAMPING: f64 = 0.1;
const EASED: f64 = 0.03;

/// Damping beyond which no step leads up: what a millionth of one does not gain is not to be had.
const MOST_DAMPING: f64 = 1e6;

/// Times what the quadratic had for it that a step falls by, beyond which the next one is taken twice as long, and the most
/// times its length that it is taken.
const FLATTER: f64 = 1.3;
const STRETCHED: f64 = 8.0;

/// What a step has to promise at most for the curvature to be learnt from those before it.
pub(super) const NEAR_TOP: f64 = 30.0;

/// Part of a learnt step that is tried where the whole leads down.
const PART: f64 = 0.25;

/// Longest step of a logarithm.
pub(super) const FARTHEST: f64 = 2.0;

/// Move of a logarithm over which the information is taken as the same.
const LIKE: f64 = 0.5;

/// Fisher's information on the noise, which costs as much as a dozen passes.
#[derive(Clone)]
pub(super) struct Informed {
    /// On which unknowns, as logarithms.
    coordinates: Vec<Coordinate>,
    /// Where it was calculated.
    at: DVector<f64>,
    information: DMatrix<f64>,
}

impl Informed {
    /// Whether it is as good as that of these unknowns there.
    fn is_near(&self, coordinates: &[Coordinate], at: &DVector<f64>) -> bool {
        self.coordinates == coordinates && (at - &self.at).amax() < LIKE
    }
}

impl Search<'_> {
    /// Unknowns of the noise: those of forces that are estimated, of sensors, of coloured parts.
    pub(super) fn coordinates(&self) -> Vec<Coordinate> {
        let free = |c: &Coordinate| match c {
            Coordinate::ForceRms(_) | Coordinate::ForceTime(_) => self.options.forces.is_estimated(),
            Coordinate::Sensor(output) => !self.silent[*output],
            _ => true,
        };
        self.noise.coordinates().into_iter().filter(free).collect()
    }

    /// One step of the noise; returns by how much −2 ln L was to fall.
    pub(super) fn step_noise(&mut self) -> f64 {
        self.drop_nothings();
        let coordinates = self.coordinates();
        if coordinates.is_empty() {
            return 0.0;
        }
        self.follow_inertia();
        let (mut gradient, mut information) = self.scored(&coordinates);
        // what stands at its bound and would leave it stays there
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
        // twice the fall of −ln L that the quadratic promises to the whole step
        let Some(whole) = damped_step(0.0).map(|step| -gradient.dot(&step)) else { return 0.0 };
        let mut learnt =
            if whole < NEAR_TOP { self.quasi.step(&gradient, |gradient| damped(0.0, gradient)) } else { None };
        let (mut part, mut direction) = (1.0, learnt.clone());
        let whole = learnt.as_ref().map_or(whole, |step| whole.max(-gradient.dot(step)));
        if whole < 0.1 * self.tolerance {
            return whole.max(0.0);
        }
        // a step that was too long is not tried at its whole length again at once
        let remembered = self.noise_damping;
        let mut damping = remembered;
        loop {
            let from_steps = learnt.take().map(|step| part * step);
            let is_learnt = from_steps.is_some();
            let Some(mut step) = from_steps.or_else(|| damped_step(damping)) else { return 0.0 };
            let promised = -gradient.dot(&step);
            // a long step keeps its direction: of two that go together one alone may lead up, and a fit of a model that lacks much
            // ends elsewhere
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
                // where the likelihood rises by clearly more than the quadratic has it, its curvature is less, and steps are longer
                self.stretch =
                    if at_once && fell > FLATTER * promised { (2.0 * self.stretch).min(STRETCHED) } else { 1.0 };
                self.noise_damping = if damping * EASED < LEAST_DAMPING { 0.0 } else { damping * EASED };
                // of a learnt step the fall is as promised or not: that it promises little ends the search, and not that it fell little
                if at_once && damping > 0.0 || is_learnt {
                    return whole;
                }
                return if scale < 1.0 { promised } else { promised.min(fell.max(0.1 * self.tolerance)) };
            }
            if is_learnt {
                // a part of it, and where that leads down as well, what was learnt elsewhere does not hold here
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

    /// Whether a logarithm stands at its bound and would leave it down this slope.
    pub(super) fn is_bound(&self, coordinate: Coordinate, slope: f64) -> bool {
        let now = self.noise.at(coordinate);
        let there = self.bounded(coordinate, now - NEAR * slope.signum());
        (there - now).abs() < 0.1 * NEAR
    }

    /// Gradient and information of −ln L by the noise, priors included, and what is linearised here anew.
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

    /// A logarithm within what has a meaning.
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

    /// Takes out forces that have run to nothing.
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
