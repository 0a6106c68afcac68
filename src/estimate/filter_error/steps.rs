//! Maximisation of the likelihood by alternating steps of the parameters and of the noise.
//!
//! ```text
//! θ:  min |r + J δ|² + λ|D δ|²        J = (∂e/∂θ)/√s      until −2 ln L would fall by less than 0.001
//! η:  (I + λ diag I) δ = −g           g, I: gradient and information of −ln L ([`super::noise_steps`])
//! ```
//!
//! [`super::ascent`] decides which steps are taken, and from where.

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

/// Multiple of what the next steps promise that a fit may still gain: a fit that is farther than
/// that from a rival is given up. In simulation, fits that had not converged promised at least a
/// third of what was left.
pub(super) const HOPE: f64 = 10.0;

/// Number of alternating steps near the maximum, after a step of the parameters has failed, before
/// joint steps are taken. Alternating steps that converge there do so in three; a curvature by
/// differences costs as much as twenty passes.
const CREEPING: usize = 4;

/// Share of the tolerance with which a fit ends. If a fall p of −2 ln L is left, a parameter is at
/// most √p standard deviations off: a tolerance of a hundredth leaves a tenth of a standard
/// deviation, this share of it a thirtieth. Near the maximum, learnt steps take three to ten passes
/// from the one to the other.
const SETTLED: f64 = 0.1;

/// Sum of the falls that parameter steps have promised since the last step of the noise, in
/// tolerances, up to which a climb may end.
const LEFT_BEHIND: f64 = 10.0;

/// Gain of the parameters between two gradients of the noise, as a share of the gain of the noise,
/// up to which the difference of the gradients is used for the curvature.
const SHARED: f64 = 0.1;

/// State of the search.
#[derive(Clone)]
pub(super) struct Search<'a> {
    pub(super) options: &'a FilterErrorOptions,
    pub(super) filtered: Filtered,
    pub(super) model: Model,
    pub(super) noise: NoiseModel,
    /// M⁻¹ of each stretch, for the parameters at the last step of the noise.
    pub(super) mobilities: Vec<DMatrix<f64>>,
    pub(super) limit: f64,
    /// Value of −2 ln L that the search must have hope of getting below, and whether it had none.
    pub(super) bar: f64,
    pub(super) given_up: bool,
    pub(super) plain: f64,
    /// Stretches linearised at the current point.
    pub(super) current: Vec<Linear>,
    /// Fall of −2 ln L that the last step of the noise promised.
    pub(super) noise_moves: f64,
    /// Correction of the rows for the gain that they hold fixed, after they have misled.
    pub(super) correction: Option<SlopeCorrection>,
    /// −2 ln L at the current point, priors included.
    pub(super) cost: f64,
    /// Least standard deviation of the noise of each output, and the given ones.
    pub(super) floors: Vec<f64>,
    pub(super) stated: Vec<Option<f64>>,
    /// Whether the noise of each output is given and larger than the range of the output: it is not
    /// estimated.
    pub(super) silent: Vec<bool>,
    /// Rms of the random force with which the search began, by degree of freedom; a force far below
    /// it counts as zero ([`super::noise_steps`]).
    pub(super) strengths: Vec<(crate::frame::Dof, f64)>,
    /// Shortest and longest correlation time, s.
    pub(super) times: (f64, f64),
    pub(super) damping: f64,
    /// The last information on the noise.
    pub(super) informed: Option<Informed>,
    /// Damping of the last step of the noise.
    pub(super) noise_damping: f64,
    /// Curvature learnt from the last steps of the noise.
    pub(super) quasi: QuasiNewton,
    /// Multiple of its length at which a step of the noise is taken.
    pub(super) stretch: f64,
    /// Ten times the fall of −2 ln L that a step has to promise to be taken.
    pub(super) tolerance: f64,
    pub(super) passes: usize,
    /// Whether an alternating step of the last climb failed although it had promised a gain, or
    /// promised little only because of its damping.
    pub(super) stuck: bool,
}

/// Fits the free parameters of a prepared problem under a fixed noise.
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

    /// Parameters that change no innovation and never will, because what they multiply is zero in
    /// these runs. A shape parameter, or one in the same term, is not among them: it may come to
    /// count with other values.
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

    /// −2 ln L of `stretches`, which are linearised at these values, priors included.
    fn cost_of(&self, stretches: &[Linear], model: &Model, noise: &NoiseModel) -> f64 {
        stretches.iter().map(|s| s.cost).sum::<f64>() + self.prior_costs(model, noise)
    }

    /// Contribution of the priors to −2 ln L at these values.
    pub(super) fn prior_costs(&self, model: &Model, noise: &NoiseModel) -> f64 {
        let coordinates = noise.coordinates();
        let prior = Prior::new(&coordinates, &self.stated).cost(noise, &coordinates);
        prior + prior_cost(model, &self.filtered.problem.unknowns)
    }

    /// Stores the stretches linearised at the current point, and −2 ln L.
    pub(super) fn take(&mut self, current: Vec<Linear>, cost: f64) {
        (self.current, self.cost) = (current, cost);
        if let Some(correction) = &mut self.correction {
            correction.fresh = false;
        }
    }

    /// Linearises at the current point, with the inertias there.
    pub(super) fn renew(&mut self) {
        self.follow_inertia();
        let (next, cost) = self.linearised(&self.model, &self.noise);
        self.take(next, cost);
        self.passes += 1;
    }

    /// Linearises at the current point, with the stored inertias; returns the gradient of −ln L by
    /// the noise.
    pub(super) fn renew_with_slopes(&mut self, coordinates: &[Coordinate]) -> Vec<f64> {
        let Search { filtered, model, noise, mobilities, limit, .. } = self;
        let (current, slopes) = filtered.slopes(model, noise, coordinates, mobilities, *limit);
        let cost = self.cost_of(&current, &self.model, &self.noise);
        self.take(current, cost);
        self.passes += 1;
        slopes
    }

    /// Updates M⁻¹, and the inputs that are read with delays, to the current point.
    pub(super) fn follow_inertia(&mut self) {
        if let Some(mobilities) = self.filtered.mobilities(&self.model) {
            self.mobilities = mobilities;
        }
        let delays = self.filtered.problem.dynamics.delays();
        if !delays.is_empty() {
            read_inputs(&mut self.filtered.problem, &self.model);
        }
    }

    /// Alternates steps until neither kind promises more than `tolerance`; returns whether that was
    /// reached.
    pub(super) fn climb(&mut self, tolerance: f64) -> bool {
        if self.given_up {
            return false;
        }
        let until = self.passes + self.options.iterations;
        self.quasi.forget();
        (self.correction, self.noise_moves) = (None, f64::INFINITY);
        // first the parameters alone: the noise is what a model leaves, and this model is not yet
        // that of the data
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
            // if a parameter step has failed near the maximum, the noise must converge before
            // another one can succeed
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
                // the noise belongs to the earlier parameters, and so do the inertias through which
                // the forces act
                if self.to_the_top() && moved > LEFT_BEHIND * tolerance {
                    self.noise_moves = f64::INFINITY;
                    continue;
                }
                // the correction may be outdated; and the last steps of a fit end at the maximum of
                // the likelihood, not at that of the rows
                if self.correction.as_ref().map_or(self.to_the_top(), |correction| !correction.fresh) {
                    self.correct_slopes();
                    if self.promised() > tolerance {
                        parameters_move = f64::INFINITY;
                        continue;
                    }
                }
                // a damped step promises little at any point
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

    /// Whether the search ends at the maximum of the likelihood itself, wherever the rows lead: in
    /// its last steps only. Alternatives that are compared before (noises with and without a force
    /// or a colour, refits of a discovery) all end where the rows lead; otherwise one of two alone
    /// might have gone farther.
    pub(super) fn to_the_top(&self) -> bool {
        self.tolerance < self.options.tolerance && self.options.higher.is_finite()
    }

    /// Takes the last steps, to [`SETTLED`] times the tolerance, so that where earlier climbs ended
    /// does not decide the result. Returns whether that was reached.
    pub(super) fn settle(&mut self) -> bool {
        self.tolerance = SETTLED * self.options.tolerance;
        self.climb(self.tolerance)
    }

    /// Climbs with innovations held back beyond `limit`, from the current point.
    pub(super) fn climb_held(&mut self, limit: f64) -> bool {
        (self.limit, self.bar) = (limit, self.options.bar);
        self.renew();
        self.climb(self.options.tolerance)
    }

    pub(super) fn gives_up(&self) -> OutputErrorError {
        OutputErrorError::GivenUp { passes: self.passes, cost: self.cost }
    }

    /// Whether an innovation is beyond five standard deviations, whatever its cause.
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

    /// By how much −2 ln L would fall with a whole step of the parameters.
    pub(super) fn promised(&self) -> f64 {
        damped_step(&self.corrected_factor(), &self.model, &self.filtered.problem.unknowns, 0.0).1
    }

    /// −2 ln L of a normalised density, Gaussian within the limit and with heavier tails beyond.
    pub(super) fn of_density(&self) -> f64 {
        let (c, more) = (share(self.limit), of_heavy_tails(self.limit));
        let of = |linear: &Linear| (1.0 - c) * linear.volume + more * linear.samples as f64;
        self.cost + self.current.iter().map(of).sum::<f64>()
    }

    /// By how much −2 ln L of the innovations within five standard deviations would be lower with
    /// tails from `limit` on.
    pub(super) fn likelier(&self, limit: f64) -> f64 {
        let Search { filtered, model, noise, mobilities, .. } = self;
        let innovations = filtered.innovations(model, noise, mobilities, self.limit);
        tails::likelier(innovations.iter().flatten().flat_map(|of| of.z.iter().copied()), limit, self.limit)
    }

    /// Takes one step of the parameters, damped until the likelihood does not fall; returns by how
    /// much −2 ln L was predicted to fall, or 0 if no damping succeeds. A step that promises less
    /// than a tenth of the tolerance is not taken.
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
            // if a ten-thousandth of a step gains nothing, nothing is to be gained: the derivative
            // is not exact, because it holds the gain fixed
            if self.damping > 1e4 {
                (self.damping, self.stuck) = (1e-2, true);
                return 0.0;
            }
        }
    }
}

/// The error of a model that diverges, with its values.
pub(super) fn diverges(model: &Model) -> OutputErrorError {
    let name = |p: &crate::model::Parameter| format!("{} {} = {}", p.term, p.spec.name, p.value);
    OutputErrorError::Diverges { values: model.parameters.iter().map(name).collect::<Vec<_>>().join(", ") }
}

/// Shortest and longest correlation time that the runs could show, s: half of the shortest mean
/// sample interval of a stretch, and half of the longest stretch.
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
