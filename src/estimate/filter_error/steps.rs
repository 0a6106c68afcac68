//! The maximum of the likelihood: steps of the parameters and steps of the noise in turns.
//!
//! ```text
//! θ:  min |r + J δ|² + λ|D δ|²        J = (∂e/∂θ)/√s                    until −2 ln L would fall by less than a thousandth
//! η:  (I + λ diag I) δ = −g           g, I: gradient and information of −ln L ([`super::noise_steps`])
//! ```
//!
//! Which steps are taken from where: [`super::ascent`].

use nalgebra::DMatrix;

use super::Filtered;
use super::likelihood::Linear;
use super::noise::{Coordinate, NoiseModel};
use super::noise_steps::{Informed, NEAR_TOP};
use super::options::FilterErrorOptions;
use super::quasi_newton::QuasiNewton;
use super::slope_correction::SlopeCorrection;
use super::start::{self, Prior};
use super::tails::{self, of_heavy_tails, share};
use crate::estimate::output_error::{OutputErrorError, damped_step, move_by, prior_cost, read_inputs, value};
use crate::model::Model;
use crate::progress;

/// Times what the next steps promise that a fit may still gain: one that is farther than that from a rival is given up. Of
/// fits in simulation that had not come to rest the promise was a third of what was left on the way, and more.
pub(super) const HOPE: f64 = 10.0;

/// Steps in turns near the top, once a step of the parameters has led astray, after which both go together: turns that come to rest
/// there do so in three, and a curvature by differences costs as much as twenty passes.
const CREEPING: usize = 4;

/// Share of the tolerance with which a fit ends. A fall p of −2 ln L that is left is a parameter √p deviations off, at most: a
/// tolerance of a hundredth leaves a tenth of a deviation, this a thirtieth. Near the top learnt steps take three to ten passes
/// from the one to the other.
const SETTLED: f64 = 0.1;

/// Times the tolerance that the parameters may have moved in all since the last step of the noise where a climb ends.
const LEFT_BEHIND: f64 = 10.0;

/// Share of what the noise gained by which the parameters may move between two of its gradients.
const SHARED: f64 = 0.1;

/// Where the search stands.
#[derive(Clone)]
pub(super) struct Search<'a> {
    pub(super) options: &'a FilterErrorOptions,
    pub(super) filtered: Filtered,
    pub(super) model: Model,
    pub(super) noise: NoiseModel,
    /// M⁻¹ of each stretch, of the parameters at the last step of the noise.
    pub(super) mobilities: Vec<DMatrix<f64>>,
    pub(super) limit: f64,
    /// −2 ln L that there has to be hope of coming below, and whether there was none.
    pub(super) bar: f64,
    pub(super) given_up: bool,
    pub(super) plain: f64,
    /// Stretches linearised here.
    pub(super) current: Vec<Linear>,
    /// Fall of −2 ln L that the last step of the noise has promised.
    pub(super) noise_moves: f64,
    /// What the gain that is held has kept from the rows, once it has led astray.
    pub(super) correction: Option<SlopeCorrection>,
    /// −2 ln L here, priors included.
    pub(super) cost: f64,
    /// Least deviation of each output's noise, and stated ones.
    pub(super) floors: Vec<f64>,
    pub(super) stated: Vec<Option<f64>>,
    /// Outputs whose noise is stated beyond all that they show: it stays.
    pub(super) silent: Vec<bool>,
    /// Strength of a force with which the search began, by degree of freedom; far below it there is none
    /// ([`super::noise_steps`]).
    pub(super) strengths: Vec<(crate::frame::Dof, f64)>,
    /// Shortest and longest correlation time, s.
    pub(super) times: (f64, f64),
    pub(super) damping: f64,
    /// What the last information on the noise was.
    pub(super) informed: Option<Informed>,
    /// Damping of the last step of the noise.
    pub(super) noise_damping: f64,
    /// What the last steps of the noise have shown of its curvature.
    pub(super) quasi: QuasiNewton,
    /// Times its length that a step of the noise is taken.
    pub(super) stretch: f64,
    /// Fall of −2 ln L that a step has to promise to be taken, ten times.
    pub(super) tolerance: f64,
    pub(super) passes: usize,
    /// Whether a step in turns of the last climb led nowhere where it had promised something, or promised little for its damping
    /// alone.
    pub(super) stuck: bool,
}

/// The free parameters of a prepared problem under a noise that stays.
pub(super) fn parameters_under(
    model: &Model,
    filtered: Filtered,
    noise: NoiseModel,
    limit: f64,
    options: &FilterErrorOptions,
) -> Result<Model, OutputErrorError> {
    let mut search = Search::new(model, filtered, noise, options)?;
    search.limit = limit;
    search.renew();
    for _ in 0..options.iterations {
        if search.step_parameters() < options.tolerance {
            break;
        }
    }
    Ok(search.model)
}

impl<'a> Search<'a> {
    pub(super) fn new(
        model: &Model,
        filtered: Filtered,
        noise: NoiseModel,
        options: &'a FilterErrorOptions,
    ) -> Result<Search<'a>, OutputErrorError> {
        let mobilities = filtered.mobilities(model).ok_or_else(|| diverges(model))?;
        let floors = start::floors(&filtered);
        let outputs = &filtered.problem.dynamics.outputs;
        let stated: Vec<Option<f64>> =
            outputs.iter().map(|o| options.base.sigma.as_ref().and_then(|s| s.get(o).copied())).collect();
        let silent =
            filtered.silent(&noise).into_iter().zip(&stated).map(|(s, stated)| s && stated.is_some()).collect();
        let mut search = Search {
            options,
            model: model.clone(),
            strengths: noise.forces.iter().map(|f| (f.dof, f.rms)).collect(),
            times: times(&filtered),
            informed: None,
            noise,
            mobilities,
            limit: f64::INFINITY,
            bar: f64::INFINITY,
            given_up: false,
            plain: f64::INFINITY,
            current: Vec::new(),
            noise_moves: f64::INFINITY,
            correction: None,
            cost: f64::INFINITY,
            floors,
            stated,
            silent,
            damping: 1e-6,
            noise_damping: 0.0,
            quasi: QuasiNewton::default(),
            stretch: 1.0,
            passes: 0,
            stuck: false,
            tolerance: options.tolerance,
            filtered,
        };
        search.renew();
        if !search.cost.is_finite() {
            return Err(diverges(model));
        }
        let samples: usize = search.current.iter().map(|s| s.samples).sum();
        let unknowns = search.filtered.problem.unknowns.len();
        if samples <= unknowns {
            return Err(OutputErrorError::TooFewSamples { samples, unknowns });
        }
        Ok(search)
    }

    /// Parameters that change no innovation at all, and never will: what they multiply is nothing in these runs. A shape, or
    /// what stands beside one, may come to count with other values.
    pub(super) fn unseen(&self) -> Vec<usize> {
        let problem = &self.filtered.problem;
        let mut seen = vec![false; problem.unknowns.len()];
        for (linear, stretch) in self.current.iter().zip(&problem.segments) {
            for (direction, unknown) in problem.columns_of(stretch.track).into_iter().enumerate() {
                seen[unknown] |= linear.rows().any(|row| row[direction] != 0.0);
            }
        }
        let lasts = |parameter: &usize| {
            let own = &self.model.parameters[*parameter];
            let mut beside = self.model.parameters.iter().filter(|p| p.term == own.term);
            own.prior.is_none() && beside.all(|p| p.spec.is_linear())
        };
        let unseen = problem.unknowns.iter().zip(seen).filter(|(_, seen)| !seen).map(|(unknown, _)| unknown.parameter);
        unseen.filter(lasts).collect()
    }

    pub(super) fn linearised(&self, model: &Model, noise: &NoiseModel) -> (Vec<Linear>, f64) {
        let stretches = self.filtered.linearise(model, noise, &self.mobilities, self.limit, true);
        let cost = self.cost_of(&stretches, model, noise);
        (stretches, cost)
    }

    /// −2 ln L of `stretches` linearised at these values, priors included.
    fn cost_of(&self, stretches: &[Linear], model: &Model, noise: &NoiseModel) -> f64 {
        stretches.iter().map(|s| s.cost).sum::<f64>() + self.prior_costs(model, noise)
    }

    /// What the priors add to −2 ln L at these values.
    pub(super) fn prior_costs(&self, model: &Model, noise: &NoiseModel) -> f64 {
        let coordinates = noise.coordinates();
        let prior = Prior::new(&coordinates, &self.stated).cost(noise, &coordinates);
        prior + prior_cost(model, &self.filtered.problem.unknowns)
    }

    /// Takes the stretches as linearised here, and −2 ln L.
    pub(super) fn take(&mut self, current: Vec<Linear>, cost: f64) {
        (self.current, self.cost) = (current, cost);
        if let Some(correction) = &mut self.correction {
            correction.fresh = false;
        }
    }

    /// Linearises here, with the inertias of here.
    pub(super) fn renew(&mut self) {
        self.follow_inertia();
        let (next, cost) = self.linearised(&self.model, &self.noise);
        self.take(next, cost);
        self.passes += 1;
    }

    /// Linearises here with the inertias at hand; the gradient of −ln L by the noise.
    pub(super) fn renew_with_slopes(&mut self, coordinates: &[Coordinate]) -> Vec<f64> {
        let Search { filtered, model, noise, mobilities, limit, .. } = self;
        let (current, slopes) = filtered.slopes(model, noise, coordinates, mobilities, *limit);
        let cost = self.cost_of(&current, &self.model, &self.noise);
        self.take(current, cost);
        self.passes += 1;
        slopes
    }

    /// M⁻¹, and what is read at delays, as they are here.
    pub(super) fn follow_inertia(&mut self) {
        if let Some(mobilities) = self.filtered.mobilities(&self.model) {
            self.mobilities = mobilities;
        }
        let delays = self.filtered.problem.dynamics.delays();
        if !delays.is_empty() {
            read_inputs(&mut self.filtered.problem, &self.model);
        }
    }

    /// Steps in turns until neither promises more than `tolerance`; whether that was reached.
    pub(super) fn climb(&mut self, tolerance: f64) -> bool {
        if self.given_up {
            return false;
        }
        let until = self.passes + self.options.iterations;
        self.quasi.forget();
        (self.correction, self.noise_moves) = (None, f64::INFINITY);
        // first the parameters alone: noise is what a model leaves, and this one is not yet that of the data
        for _ in 0..4 {
            if self.step_parameters() < 1.0 {
                break;
            }
        }
        let (mut parameters_move, mut moved) = (f64::INFINITY, 0.0);
        self.stuck = false;
        let (mut near, mut led_nowhere) = (0, false);
        while self.passes < until {
            if self.noise_moves >= tolerance || parameters_move >= 1.0 {
                (self.noise_moves, moved) = (self.step_noise(), 0.0);
            }
            let noise_moves = self.noise_moves;
            if noise_moves >= NEAR_TOP {
                self.correction = None;
            }
            // where their step has led nowhere, near the top the noise comes to rest before another one may lead anywhere
            if !led_nowhere || !(tolerance..NEAR_TOP).contains(&noise_moves) {
                let before = std::mem::take(&mut self.stuck);
                parameters_move = self.step_parameters();
                led_nowhere = self.stuck;
                self.stuck |= before;
            }
            moved += parameters_move;
            if parameters_move > SHARED * noise_moves {
                self.quasi.pause();
            }
            if self.options.told {
                progress::tell("fitting by filter error", self.passes, 0);
            }
            if noise_moves < tolerance && parameters_move < tolerance {
                // the noise is that of where the parameters were, and so are the inertias by which forces push
                if self.to_the_top() && moved > LEFT_BEHIND * tolerance {
                    self.noise_moves = f64::INFINITY;
                    continue;
                }
                // what has corrected the rows on the way may have become another; and the last steps of a fit end at the top of the
                // likelihood, not where the rows have it
                if self.correction.as_ref().map_or(self.to_the_top(), |correction| !correction.fresh) {
                    self.correct_slopes();
                    if self.promised() > tolerance {
                        parameters_move = f64::INFINITY;
                        continue;
                    }
                }
                // a damped step promises little from anywhere
                self.stuck |= self.promised() > tolerance;
                return true;
            }
            if self.correction.is_some() && noise_moves + parameters_move < NEAR_TOP {
                near += 1;
                if near == CREEPING && self.climb_together(tolerance) {
                    return true;
                }
            }
            if self.cost - HOPE * (noise_moves + parameters_move) > self.bar {
                self.given_up = true;
                return false;
            }
        }
        false
    }

    /// Whether the search ends at the top of the likelihood wherever the rows lead: in its last steps. What is held against each
    /// other before (noises with a force or a colour and without, refits of a discovery) all ends where the rows have it: of two one
    /// alone may have gone farther.
    pub(super) fn to_the_top(&self) -> bool {
        self.tolerance < self.options.tolerance && self.options.higher.is_finite()
    }

    /// The last steps, to a [`SETTLED`] of the tolerance: what ends the ways before decides nothing then. Whether that was
    /// reached.
    pub(super) fn settle(&mut self) -> bool {
        self.tolerance = SETTLED * self.options.tolerance;
        self.climb(self.tolerance)
    }

    /// The same with innovations held back at `limit`, from here on.
    pub(super) fn climb_held(&mut self, limit: f64) -> bool {
        (self.limit, self.bar) = (limit, self.options.bar);
        self.renew();
        self.climb(self.options.tolerance)
    }

    pub(super) fn gives_up(&self) -> OutputErrorError {
        OutputErrorError::GivenUp { passes: self.passes, cost: self.cost }
    }

    /// Whether an innovation is beyond five deviations, whatever has made it.
    pub(super) fn is_pushed(&self) -> bool {
        self.current.iter().any(|s| s.outliers > 0)
    }

    /// Whether a sample is wild ([`super::outliers`]).
    pub(super) fn has_outliers(&self) -> bool {
        self.is_pushed() && {
            let Search { filtered, model, noise, mobilities, limit, .. } = self;
            filtered.wild_samples(&filtered.innovations(model, noise, mobilities, *limit)) > 0
        }
    }

    /// By how much −2 ln L would fall by a whole step of the parameters.
    pub(super) fn promised(&self) -> f64 {
        damped_step(&self.corrected_factor(), &self.model, &self.filtered.problem.unknowns, 0.0).1
    }

    /// −2 ln L as that of a density, Gaussian within the limit and with the tails of one that is held back beyond.
    pub(super) fn of_density(&self) -> f64 {
        let (c, more) = (share(self.limit), of_heavy_tails(self.limit));
        let of = |linear: &Linear| (1.0 - c) * linear.volume + more * linear.samples as f64;
        self.cost + self.current.iter().map(of).sum::<f64>()
    }

    /// By how much −2 ln L of what is within five deviations would be lower with tails from `limit` on.
    pub(super) fn likelier(&self, limit: f64) -> f64 {
        let Search { filtered, model, noise, mobilities, .. } = self;
        let innovations = filtered.innovations(model, noise, mobilities, self.limit);
        tails::likelier(innovations.iter().flatten().flat_map(|of| of.z.iter().copied()), limit, self.limit)
    }

    /// One step of the parameters, as far as the likelihood rises; returns by how much −2 ln L was to fall.
    fn step_parameters(&mut self) -> f64 {
        let unknowns = self.filtered.problem.unknowns.clone();
        if unknowns.is_empty() {
            return 0.0;
        }
        if self.filtered.problem.follow(&self.model) {
            self.renew();
        }
        let delays = self.filtered.problem.dynamics.delays();
        let (mut factor, undamped) = (self.corrected_factor(), self.damping);
        loop {
            let (step, predicted) = damped_step(&factor, &self.model, &unknowns, self.damping);
            if predicted < 0.1 * self.tolerance {
                return predicted;
            }
            let mut trial = self.model.clone();
            for (unknown, delta) in unknowns.iter().zip(&step) {
                move_by(&mut trial, *unknown, *delta);
            }
            let late = |u: &crate::estimate::output_error::Unknown| {
                delays.contains(&u.parameter) && value(&trial, *u).to_bits() != value(&self.model, *u).to_bits()
            };
            let late = unknowns.iter().any(late);
            if late {
                read_inputs(&mut self.filtered.problem, &trial);
            }
            let (next, cost) = self.linearised(&trial, &self.noise);
            self.passes += 1;
            if cost.is_finite() && cost <= self.cost + 1e-9 * self.cost.abs() {
                self.model = trial;
                self.take(next, cost);
                self.damping = (self.damping * 0.1).max(1e-12);
                return predicted;
            }
            if late {
                read_inputs(&mut self.filtered.problem, &self.model);
            }
            if self.takes_slopes_anew() {
                (factor, self.damping) = (self.corrected_factor(), undamped);
                continue;
            }
            self.damping = (self.damping * 10.0).max(1e-4);
            // what a hundredth of a step does not gain is not to be had: the gain held in the derivative is not exact
            if self.damping > 1e4 {
                (self.damping, self.stuck) = (1e-2, true);
                return 0.0;
            }
        }
    }
}

/// The model that runs away, with its values.
pub(super) fn diverges(model: &Model) -> OutputErrorError {
    let name = |p: &crate::model::Parameter| format!("{} {} = {}", p.term, p.spec.name, p.value);
    OutputErrorError::Diverges { values: model.parameters.iter().map(name).collect::<Vec<_>>().join(", ") }
}

/// Shortest and longest correlation time that the runs could show, s: half of the shortest interval of the samples, and
/// half of the longest stretch.
fn times(filtered: &Filtered) -> (f64, f64) {
    let problem = &filtered.problem;
    let (mut shortest, mut longest) = (f64::INFINITY, 0.0_f64);
    for s in &problem.segments {
        let time = &problem.tracks[s.track].time[s.first..=s.last];
        let span = time[time.len() - 1] - time[0];
        longest = longest.max(span);
        shortest = shortest.min(span / (time.len() - 1) as f64);
    }
    (0.5 * shortest, (0.5 * longest).max(shortest))
}
