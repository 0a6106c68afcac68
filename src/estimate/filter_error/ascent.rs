//! From the noises at which a fit starts to the highest top of the likelihood.
//!
//! ```text
//! each noise: a climb to about its top;  of tops that are near the highest: to rest, outliers held back, noise refined
//! ```
//!
//! Where steps in turns have stuck on the way, steps of parameters and noise together go on ([`super::steps_together`]).
//! A random force whose σ has run to nothing is taken out, and what else the likelihood does not ask for
//! ([`super::refine`]). Where a sample is wild ([`super::outliers`]), all innovations are held back from then on, at
//! the deviations that they themselves ask for ([`super::tails`]).

use super::noise::NoiseModel;
use super::options::FilterErrorOptions;
use super::smoothed_beginning::At;
use super::steps::{Search, diverges};
use super::{FilterErrorFit, Filtered, Reached};
use crate::estimate::output_error::{HUBER, OutputErrorError};
use crate::model::Model;

/// Deviations at which innovations are held back once there are outliers. Where the noise is Gaussian but for them, 2: held back
/// at 1.345, the filter follows Gaussian innovations by 0.82 of its gain and finds a random force a fifth too strong to make up
/// for it, by 0.95 at 2. Where the innovations within five deviations are likelier to have the tails from [`HUBER`] on, that.
const HELD_BACK: f64 = 2.0;

/// Fall of −2 ln L that the next steps promise, below which the noise is about right.
const ABOUT: f64 = 1.0;

/// −2 ln L by which two tops may lie apart before the runs begin where they say ([`Filtered::begin_smoothed`]), and both be gone
/// on from. Where the higher one alone was, one campaign of twelve with noisy fixes ended in the lesser top, 5 deviations off.
const APART: f64 = 100.0;

/// The fit of a prepared problem from starting values of parameters and noise: of several noises from the one that leads
/// highest.
pub(super) fn maximised(
    model: &Model,
    filtered: Filtered,
    noises: Vec<NoiseModel>,
    options: &FilterErrorOptions,
) -> Result<FilterErrorFit, OutputErrorError> {
    let (mut searches, mut least) = (Vec::new(), f64::INFINITY);
    for (filtered, noise) in std::iter::repeat_n(filtered, noises.len()).zip(noises) {
        let search = about(model, filtered, noise, options, least + APART);
        least = search.as_ref().map_or(least, |search| least.min(search.cost));
        searches.push(search);
    }
    let near = searches.into_iter().filter(|search| search.as_ref().map_or(true, |s| s.cost <= least + APART));
    let tops = near.map(|search| search.and_then(|search| to_the_top(search, options)));
    tops.reduce(higher).unwrap_or_else(|| Err(diverges(model)))
}

/// The fit of the higher likelihood, every innovation as it is; the first error where there is none.
fn higher(
    one: Result<FilterErrorFit, OutputErrorError>,
    other: Result<FilterErrorFit, OutputErrorError>,
) -> Result<FilterErrorFit, OutputErrorError> {
    match (one, other) {
        (Ok(one), Ok(other)) => Ok(if other.plain < one.plain { other } else { one }),
        (Err(error), other) => other.map_err(|_| error),
        (one, Err(_)) => one,
    }
}

/// The rest of a search that has come [`about`] to its top.
fn to_the_top(mut search: Search<'_>, options: &FilterErrorOptions) -> Result<FilterErrorFit, OutputErrorError> {
    let Search { filtered, model: here, noise, mobilities, limit, .. } = &mut search;
    let at = At { model: here, noise, mobilities, limit: *limit };
    if filtered.begin_smoothed(at) {
        search.renew();
    }
    search.plain = search.cost;
    let mut converged = match options.limit {
        Some(limit) if limit.is_finite() => search.climb_held(limit),
        _ => search.climb(options.tolerance),
    };
    if options.limit.is_none() {
        if search.has_outliers() {
            (search, converged) = held_back(&search);
        } else if options.refine && search.is_pushed() {
            let (held, rests) = held_back(&search);
            if rests && held.of_density() < search.of_density() {
                (search, converged) = (held, true);
            }
        }
    }
    if search.given_up {
        return Err(search.gives_up());
    }
    if search.limit.is_infinite() {
        search.plain = search.cost;
    }
    if options.refine {
        converged = search.colour() && search.drop_forces() && converged;
        converged |= search.settle();
    }
    match search.stuck {
        true if options.higher.is_finite() => beyond(search, converged),
        true => search.finish(converged, Reached::Stuck),
        false => search.finish(converged, Reached::InTurns),
    }
}

/// The search with innovations held back, and whether it rests: at one limit the same whether another was tried before.
fn held_back<'a>(search: &Search<'a>) -> (Search<'a>, bool) {
    let climbed = |limit: f64| {
        let mut held = search.clone();
        let rests = held.climb_held(limit);
        (held, rests)
    };
    let held = climbed(HELD_BACK);
    if held.0.likelier(HUBER) > 0.0 { climbed(HUBER) } else { held }
}

/// The fit where steps in turns have stuck: where steps of both together lead, if that is higher.
fn beyond(turns: Search<'_>, converged: bool) -> Result<FilterErrorFit, OutputErrorError> {
    let mut top = turns.clone();
    let mut rests = top.climb_together(top.tolerance);
    if top.cost > turns.cost - turns.options.higher {
        return turns.finish(converged, Reached::Stuck);
    }
    if turns.options.refine {
        let forces = top.noise.forces.len();
        top.drop_forces();
        // what is left has been climbed in turns, which may have stuck again
        if top.noise.forces.len() < forces {
            rests = top.climb_together(top.tolerance);
        }
    }
    // where there is no top that the runs determine, nothing is left that they do
    top.finish(rests, Reached::Together).or_else(|_| turns.finish(false, Reached::Stuck))
}

/// The search as far as [`ABOUT`] from a noise; given up where there is no hope of coming below `bar`, either.
fn about<'a>(
    model: &Model,
    filtered: Filtered,
    noise: NoiseModel,
    options: &'a FilterErrorOptions,
    bar: f64,
) -> Result<Search<'a>, OutputErrorError> {
    let mut search = Search::new(model, filtered, noise, options)?;
    let own = if options.limit.is_none_or(f64::is_infinite) { options.bar } else { f64::INFINITY };
    search.bar = own.min(bar);
    let unseen = search.unseen().into_iter().map(|k| &model.parameters[k]);
    let (parameters, values): (Vec<String>, Vec<f64>) = unseen.map(|p| (p.full_name(), p.value)).unzip();
    if !parameters.is_empty() {
        return Err(OutputErrorError::NotIdentified { parameters, values });
    }
    // outliers show as soon as the noise is about right; and from far off innovations that are held back lead slowly
    search.climb(options.tolerance.max(ABOUT));
    search.bar = own;
    if search.given_up { Err(search.gives_up()) } else { Ok(search) }
}

impl Search<'_> {
    /// The fit where the search has come to.
    pub(super) fn finish(mut self, converged: bool, reached: Reached) -> Result<FilterErrorFit, OutputErrorError> {
        if !self.cost.is_finite() {
            return Err(diverges(&self.model));
        }
        let p = self.filtered.problem.unknowns.len();
        let mut covariance = if p == 0 { Vec::new() } else { self.covariance()? };
        let sum = |k: usize| self.current.iter().map(|s| s.held_back[k]).sum::<f64>();
        let samples: usize = self.current.iter().map(|s| s.samples).sum();
        if self.limit.is_finite() {
            let n = samples as f64;
            let scale = sum(0) / n / (sum(1) / n).powi(2) * (sum(2) / n);
            covariance.iter_mut().for_each(|c| *c *= scale);
        }
        let unknowns = self.filtered.problem.unknowns.clone();
        for (k, unknown) in unknowns.iter().enumerate() {
            let std = covariance[k * p + k].sqrt();
            let parameter = &mut self.model.parameters[unknown.parameter];
            // of a parameter per run the largest is shown
            let other = if unknown.run.is_some_and(|r| r > 0) { parameter.std.unwrap_or(0.0) } else { 0.0 };
            parameter.std = Some(std.max(other));
        }
        Ok(FilterErrorFit {
            noise_unknowns: self.coordinates(),
            stated: self.stated,
            model: self.model,
            noise: self.noise,
            filtered: self.filtered,
            covariance,
            cost: self.cost,
            plain: self.plain,
            samples,
            limit: self.limit,
            linear: self.current,
            iterations: self.passes,
            converged,
            reached,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::filter_error::start;
    use crate::tank::{BlindOptions, blind};

    #[test]
    fn what_has_stuck_goes_on_where_that_leads_higher_and_is_as_it_was_elsewhere() {
        let campaign = blind(&BlindOptions { duration: 40.0, ..BlindOptions::default() }).expect("the tank sails");
        let mut model = campaign.truth;
        model.parameters.iter_mut().filter(|p| !p.fixed).for_each(|p| p.value *= 1.2);
        let options = FilterErrorOptions { refine: false, ..FilterErrorOptions::default() };
        let filtered = Filtered::new(&model, &campaign.runs, &options.base).expect("the runs are whole");
        let noise = start::noises(&filtered, &model, &campaign.runs, &options.forces).remove(0);
        let begun = Search::new(&model, filtered, noise, &options).expect("it does not run away");
        let mut top = begun.clone();
        assert!(top.climb(options.tolerance));
        // from where steps in turns began, as if the first one had led nowhere
        let gone_on = beyond(begun.clone(), false).expect("the runs determine it");
        assert!(gone_on.converged && gone_on.reached == Reached::Together);
        // both promise less than the tolerance; a gain held in the rows is worth a few of it
        assert!((gone_on.cost - top.cost).abs() < 10.0 * options.tolerance, "{} {}", gone_on.cost, top.cost);
        // from the top nothing leads higher by one
        let (cost, values) = (top.cost, top.model.parameters.iter().map(|p| p.value).collect::<Vec<_>>());
        let stayed = beyond(top, true).expect("the runs determine it");
        assert!(stayed.converged && stayed.reached == Reached::Stuck && stayed.cost == cost);
        assert!(stayed.model.parameters.iter().zip(values).all(|(p, value)| p.value == value));
        // a refit nearby goes the same way
        assert_eq!(gone_on.nearby(&options).higher, 0.0);
        assert_eq!(stayed.nearby(&options).higher, f64::INFINITY);
    }
}
