//! From the noise models at which a fit starts to the highest maximum of the likelihood.
//!
//! ```text
//! each starting noise:              climb close to a maximum
//! maxima that are near the highest: climb to rest, hold back outliers, refine the noise
//! ```
//!
//! If alternating steps get stuck on the way, joint steps of parameters and noise continue
//! ([`super::steps_together`]). A random force whose σ has run to zero is removed, and so is other
//! noise that the likelihood does not ask for ([`super::refine`]). If a sample is wild
//! ([`super::outliers`]), innovations beyond a limit are held back from then on; the innovations
//! themselves decide between two limits ([`super::tails`]).

use super::noise::NoiseModel;
use super::options::FilterErrorOptions;
use super::smoothed_beginning::At;
use super::steps::{Search, diverges};
use super::{FilterErrorFit, Filtered, Reached};
use crate::estimate::output_error::{HUBER, OutputErrorError};
use crate::model::Model;

/// Limit, in standard deviations, beyond which innovations are held back once there are outliers: 2
/// if the noise is Gaussian apart from the outliers. With a limit of 1.345 the filter follows
/// Gaussian innovations with 0.82 of its gain, and finds a random force a fifth too strong to
/// compensate; with 2 it follows them with 0.95 of its gain. If the innovations within five
/// standard deviations are more likely with tails from [`HUBER`] on, that limit is used.
const HELD_BACK: f64 = 2.0;

/// Fall of −2 ln L promised by the next steps, below which the noise is roughly right.
const ABOUT: f64 = 1.0;

/// Difference in −2 ln L up to which two maxima are both pursued: they may lie so far apart before
/// the runs begin where their data say ([`Filtered::begin_smoothed`]). When only the higher one was
/// pursued, one campaign of twelve with noisy fixes ended in the lesser maximum, 5 standard
/// deviations off.
const APART: f64 = 100.0;

/// Fits a prepared problem from starting values of parameters and noise; of several noises, returns
/// the fit from the one that leads highest.
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

/// The fit of the higher likelihood, compared before any innovation was held back; the first error
/// if both failed.
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

/// Continues a search that has come [`about`] to its maximum.
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

/// The search with innovations held back, and whether it has converged. The result for one limit
/// does not depend on whether another was tried before.
fn held_back<'a>(search: &Search<'a>) -> (Search<'a>, bool) {
    let climbed = |limit: f64| {
        let mut held = search.clone();
        let rests = held.climb_held(limit);
        (held, rests)
    };
    let held = climbed(HELD_BACK);
    if held.0.likelier(HUBER) > 0.0 { climbed(HUBER) } else { held }
}

/// The fit after alternating steps got stuck: that of joint steps if it is higher by
/// `options.higher`.
fn beyond(turns: Search<'_>, converged: bool) -> Result<FilterErrorFit, OutputErrorError> {
    let mut top = turns.clone();
    let mut rests = top.climb_together(top.tolerance);
    if top.cost > turns.cost - turns.options.higher {
        return turns.finish(converged, Reached::Stuck);
    }
    if turns.options.refine {
        let forces = top.noise.forces.len();
        top.drop_forces();
        // what is left has been climbed with alternating steps, which may have got stuck again
        if top.noise.forces.len() < forces {
            rests = top.climb_together(top.tolerance);
        }
    }
    // if the runs do not determine a maximum there, the fit of the alternating steps is returned
    top.finish(rests, Reached::Together).or_else(|_| turns.finish(false, Reached::Stuck))
}

/// Climbs from a starting noise until steps promise less than [`ABOUT`]; gives up if there is no
/// hope of getting below `bar` or the bar of the options.
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
    // outliers show as soon as the noise is roughly right; and far from the maximum, a climb with
    // innovations held back is slow
    search.climb(options.tolerance.max(ABOUT));
    search.bar = own;
    if search.given_up { Err(search.gives_up()) } else { Ok(search) }
}

impl Search<'_> {
    /// The fit at the point that the search has reached.
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
            // of a parameter per run, the largest standard deviation is shown
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
        // from where the alternating steps began, as if the first one had failed
        let gone_on = beyond(begun.clone(), false).expect("the runs determine it");
        assert!(gone_on.converged && gone_on.reached == Reached::Together);
        // both promise less than the tolerance; the gain that the rows hold fixed is worth a few
        // tolerances
        assert!((gone_on.cost - top.cost).abs() < 10.0 * options.tolerance, "{} {}", gone_on.cost, top.cost);
        // from the maximum nothing leads higher by one
        let (cost, values) = (top.cost, top.model.parameters.iter().map(|p| p.value).collect::<Vec<_>>());
        let stayed = beyond(top, true).expect("the runs determine it");
        assert!(stayed.converged && stayed.reached == Reached::Stuck && stayed.cost == cost);
        assert!(stayed.model.parameters.iter().zip(values).all(|(p, value)| p.value == value));
        // a refit nearby takes the same kind of steps
        assert_eq!(gone_on.nearby(&options).higher, 0.0);
        assert_eq!(stayed.nearby(&options).higher, f64::INFINITY);
    }
}
