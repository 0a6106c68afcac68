//! Start of a fit whose model contains a period or an instant: a wave, a thruster that fails.
//!
//! ```text
//! T ← argmin p(T)        of the innovations of the model without it, step 2 of the search, on its grid and between
//! ```
//!
//! The likelihood has a local maximum at every period that is in step with the motion for a part of a run, and at
//! every instant from which the model errs. From a period that is off by a tenth a fit ends beside the highest one,
//! with a random force in place of the wave.

use std::collections::BTreeSet;

use super::candidate::{Candidate, candidates};
use super::focus::{higher, starts};
use super::screen::{Score, screen};
use super::task::{ROUGH, SearchOptions, Task};
use crate::chain::reads_time;
use crate::estimate::filter_error::{FilterErrorFit, FilterErrorOptions, filter_error};
use crate::estimate::output_error::OutputErrorError;
use crate::estimate::started;
use crate::model::{Model, Parameter, Term};
use crate::run::Run;

/// `model` started from `runs` ([`started`]). Periods and instants without a given start begin where the innovations
/// of the model without them indicate.
pub fn begun(model: &Model, runs: &[Run], fitting: &FilterErrorOptions, options: &SearchOptions) -> Model {
    started(&with_times(model, runs, fitting, options).unwrap_or_else(|| model.clone()), runs)
}

/// `model` fitted to `runs` from its start ([`begun`]), and again from the likeliest instant along its grid once the
/// rest is known: the innovations of a model that also errs elsewhere may indicate another local maximum.
///
/// # Errors
/// [`OutputErrorError`].
pub fn fitted(
    model: &Model,
    runs: &[Run],
    fitting: &FilterErrorOptions,
    options: &SearchOptions,
) -> Result<FilterErrorFit, OutputErrorError> {
    let mut fit = filter_error(&begun(model, runs, fitting, options), runs, fitting)?;
    for name in model.terms.iter().filter(|term| is_timed(model, term)).map(Term::name) {
        let Some(candidate) = known(&fit.model, &name, runs) else { continue };
        let before = candidate.taken_out_of(&fit.model);
        fit = higher(&before, &fit, &candidate, runs, fitting).unwrap_or(fit);
    }
    Ok(fit)
}

/// The candidate that a term of a model would be if it were not in it.
fn known(model: &Model, name: &str, runs: &[Run]) -> Option<Candidate> {
    let term = &model.terms[model.term(name)?];
    let own = [(term.effect.clone(), term.place)];
    let mut without = model.clone();
    without.remove(model.term(name)?);
    candidates(&without, runs, &own).into_iter().find(|candidate| candidate.name() == name)
}

/// Whether a parameter is a free shape without a given start.
fn is_sought(p: &Parameter) -> bool {
    !p.spec.is_linear() && !p.fixed && !p.given
}

/// Whether a term depends on time, by a shape parameter that must be searched.
fn is_timed(model: &Model, term: &Term) -> bool {
    term.parameters.iter().any(|p| is_sought(&model.parameters[*p]))
        && reads_time(term.effect.as_ref(), term.place, model)
}

fn with_times(model: &Model, runs: &[Run], fitting: &FilterErrorOptions, options: &SearchOptions) -> Option<Model> {
    let timed: Vec<usize> = (0..model.terms.len()).filter(|k| is_timed(model, &model.terms[*k])).collect();
    if timed.is_empty() {
        return None;
    }
    let mut without = model.clone();
    timed.iter().rev().for_each(|k| without.remove(*k));
    let rough = FilterErrorOptions { tolerance: ROUGH, told: false, ..fitting.clone() };
    let fit = filter_error(&started(&without, runs), runs, &rough).ok()?;
    let own: Vec<_> = timed.iter().map(|k| (model.terms[*k].effect.clone(), model.terms[*k].place)).collect();
    let mut list: Vec<Candidate> = candidates(&fit.model, runs, &own);
    // effects of the catalogue are in the list twice
    let mut terms: BTreeSet<String> = timed.iter().map(|k| model.terms[*k].name()).collect();
    list.retain(|c| terms.remove(&c.name()));
    let found = screen(&fit, runs, &list, &fitting.base, (options.level, options.seed)).ok()?;
    let best: Vec<Score> = found.best_probes().into_iter().cloned().collect();
    let task = Task { train: runs, held: &[], own: &[], fitting, options };
    let mut placed = model.clone();
    for start in starts(&fit, &best, &list, &task).iter().rev() {
        let Some(term) = placed.term(&start.candidate.name()) else { continue };
        let shapes = placed.terms[term].parameters.clone();
        let shapes = shapes.into_iter().filter(|p| !model.parameters[*p].spec.is_linear());
        for (p, value) in shapes.zip(&start.candidate.probes[start.score.probe]) {
            if is_sought(&placed.parameters[p]) {
                placed.parameters[p].value = *value;
            }
        }
    }
    Some(placed)
}
