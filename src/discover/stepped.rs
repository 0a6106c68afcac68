//! Properties of the vehicle that change at an instant, or in one run alone: its drag, its thrust, its mass.
//!
//! ```text
//! D → (1 + s) D      τ → (1 + s) τ      m_u, m_v, m_w → m_u + s, m_v + s, m_w + s          from t₀ on
//! ```
//!
//! Weed, a lost fairing, a weak battery or a payload changes many parameters at once, and all by one number s. A payload
//! also changes the moments of inertia and their couplings, each by a number of its own. The property that explains most
//! is reported if it explains more than any effect present throughout, by its score and by a fit, and more than a single
//! parameter that changes, and if nothing or little remains beside it ([`super::begun`]): a change of one parameter leaves
//! the others of its property behind.

use std::collections::{BTreeMap, BTreeSet};

use super::appeared::LEFT;
use super::begun::{Beginning, Begun, What};
use super::candidate::Candidate;
use super::columns::{InBlocks, in_blocks};
use super::constancy::{ChangedParameter, RunInstant, changed};
use super::parts::{BLOCK, Direction, LEVEL, Log, Part, divided};
use super::refit::{afresh, beside};
use super::screen::{Screen, log_survival};
use super::task::{ROUGH, TIE, Task, asked};
use crate::chain::{Nature, nature};
use crate::effects::{Event, Place, id};
use crate::estimate::filter_error::{FilterErrorFit, FilterErrorOptions, filter_error_from};
use crate::estimate::output_error::OutputErrorError;
use crate::frame::Dof;
use crate::model::{Model, Term};

/// Key of the parameter s.
const S: &str = "s since t₀";

/// A property of the vehicle: what changes by s, and what changes with it by numbers of its own.
struct Property {
    name: &'static str,
    /// Whether s is a share.
    relative: bool,
    tied: Vec<Changing>,
    own: Vec<Changing>,
}

/// What changes with a property.
#[derive(Clone, Copy)]
enum Changing {
    /// A term of the model.
    Term(usize, Event),
    /// The effect of a term of the model, which acts once more.
    Again(usize),
    /// A candidate.
    Candidate(usize),
}

/// Number of effects present throughout that are fitted beside an event, the best by score: the score of a strong one
/// promises less than it gains.
const RIVALS: usize = 4;

/// A property that was fitted.
struct Fitted<'a> {
    property: &'a Property,
    begun: Begun,
    between: Vec<RunInstant>,
    /// −2 ln L and one for each parameter.
    cost: f64,
    /// Fall of −2 ln L that the scores promise.
    score: f64,
}

/// The property of the vehicle that has changed, with a score beyond `least`; beside `fit`, the candidates have these scores.
///
/// # Errors
/// [`OutputErrorError`] when a run lacks what a candidate reads.
pub(super) fn stepped(
    fit: &FilterErrorFit,
    (candidates, screen): (&[Candidate], &Screen),
    task: &Task<'_>,
    least: f64,
) -> Result<Option<ChangedParameter>, OutputErrorError> {
    let Some(any) = changed(fit, task.train, task.options.seed, |_| true) else { return Ok(None) };
    let model = &fit.model;
    let mut list = asked(model, task);
    list.retain(|c| is_scale(c) || is_coupling(c, model));
    let properties = properties(model, &list, &driven(task));
    let InBlocks { probes, products } = in_blocks(fit.into(), task.train, &list, &task.fitting.base, BLOCK)?;
    let (blocks, parts) = divided(fit, task.train, &products, probes.len());
    let unknowns = &fit.filtered.problem.unknowns;
    let estimated = unknowns.len();
    let tried = (parts.len() * properties.len()) as f64;
    let Some(log) = Log::of(blocks, parts, ((0..estimated).collect(), Vec::new()), fit.priors().collect()) else {
        return Ok(None);
    };
    // the unknown of the scores, and how much it changes with s; none of what is fixed
    let along = |changing: &Changing| match changing {
        Changing::Candidate(k) => Some((estimated + probes.iter().position(|probe| probe.candidate == *k)?, 1.0)),
        Changing::Term(k, _) | Changing::Again(k) => {
            let p = model.terms[*k].parameters[0];
            let is_amount = matches!(changing, Changing::Term(_, Event::Amount));
            let weight = if is_amount { 1.0 } else { model.parameters[p].value };
            Some((unknowns.iter().position(|u| u.parameter == p)?, weight))
        }
    };
    let mut fitted: Vec<Fitted<'_>> = Vec::new();
    for property in &properties {
        // terms that share a parameter change it once
        let tied: BTreeMap<usize, f64> = property.tied.iter().filter_map(along).collect();
        let mut seen = BTreeSet::new();
        let own = property.own.iter().filter_map(|own| Some((*own, along(own)?)));
        let own: Vec<(Changing, (usize, f64))> = own.filter(|(_, (unknown, _))| seen.insert(*unknown)).collect();
        let directions: Vec<Direction> =
            [tied.into_iter().collect()].into_iter().chain(own.iter().map(|(_, along)| vec![*along])).collect();
        let Some(found) = log.together(&directions) else { continue };
        // scores are compared with scores: beside a model that lacks much they promise less than a fit gains
        let score = found.gain + found.changes.len() as f64;
        if score < least.max(by_chance(found.changes.len(), tried)) {
            continue;
        }
        let begins = |changing, start, tie| Beginning { what: what(changing, &list, model), start, tie };
        let mut beginnings = Vec::new();
        for (direction, start) in found.changes {
            match direction.checked_sub(1) {
                None => beginnings.extend(property.tied.iter().map(|tied| begins(*tied, start, Some(S)))),
                Some(k) => beginnings.push(begins(own[k].0, start, None)),
            }
        }
        let part = log.parts[found.part].clone();
        let Some(begun) = Begun::at(part, &beginnings, fit, task) else { continue };
        let cost = begun.fit.cost + begun.count() as f64;
        // what the model lacks may act all along
        let all = Part { run: 0, from: Some(f64::NEG_INFINITY), ..begun.part.clone() };
        beginnings.retain(|beginning| matches!(beginning.what, What::Effect(..)));
        if !beginnings.is_empty() {
            let gain = fit.cost - begun.fit.cost;
            let more = Begun::at(all, &beginnings, fit, task).map(|all| all.fit.cost - begun.fit.cost);
            if more.is_some_and(|more| more < LEFT * gain + by_chance(1, tried)) {
                continue;
            }
        }
        fitted.push(Fitted { property, begun, between: Vec::new(), cost, score });
    }
    fitted.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let Some(first) = fitted.first().map(|first| first.cost) else { return Ok(None) };
    // an instant that is some seconds off costs a share of the gain
    fitted.retain(|one| one.cost - first < (LEFT * (fit.cost - first)).max(TIE));
    let refined = fitted.into_iter().map(|one| {
        let (begun, between) = one.begun.likeliest(&log.parts, task);
        Fitted { cost: begun.fit.cost + begun.count() as f64, begun, between, ..one }
    });
    let mut fitted: Vec<Fitted<'_>> = refined.collect();
    fitted.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let mut fitted = fitted.into_iter();
    let Some(Fitted { property, begun, between, cost, score }) = fitted.next() else { return Ok(None) };
    // if two properties explain it equally well, neither is the answer
    if fitted.next().is_some_and(|second| second.cost < cost + TIE) {
        return Ok(None);
    }
    let (gain, count) = (fit.cost - begun.fit.cost, begun.count());
    // twice the limit of chance: near to it any change absorbs a little of another effect
    if gain < 2.0 * by_chance(count, tried) {
        return Ok(None);
    }
    // a parameter that changes alone is the simpler answer
    if any.alone && (any.change / any.std).powi(2) > score {
        return Ok(None);
    }
    let s = &begun.fit.model.parameters[begun.parameter];
    let (change, std) = (s.value - s.spec.neutral, s.std.unwrap_or(f64::INFINITY));
    if (change / std).powi(2) < by_chance(1, tried) {
        return Ok(None);
    }
    let left = begun.left(task)?;
    if left > LEFT * gain || throughout(fit, candidates, screen, task) < begun.fit.cost + LEFT * gain {
        return Ok(None);
    }
    Ok(Some(ChangedParameter {
        parameter: property.name.into(),
        run: task.train[begun.part.run].name.clone(),
        from: begun.part.from,
        between,
        change,
        std,
        unit: s.spec.dimension.to_string(),
        p_value: (tried * log_survival(gain, count).exp()).min(1.0),
        gain: gain - count as f64,
        alone: left <= 0.0,
        absent: false,
        neutral: 0.0,
        relative: property.relative,
    }))
}

/// The least −2 ln L of `fit` with one of the effects that are most significant throughout.
fn throughout(fit: &FilterErrorFit, candidates: &[Candidate], screen: &Screen, task: &Task<'_>) -> f64 {
    let rough = FilterErrorOptions { tolerance: ROUGH, told: false, ..beside(fit, task) };
    let best = screen.best_probes().into_iter().filter(|score| {
        let candidate = &candidates[score.candidate];
        !candidate.has_own_values() && candidate.is_possible(score)
    });
    let costs = best.take(RIVALS).filter_map(|score| {
        let model = candidates[score.candidate].started(&fit.model, score)?;
        Some(filter_error_from(&model, task.train, afresh(&fit.noise), &rough).ok()?.cost)
    });
    costs.fold(f64::INFINITY, f64::min)
}

/// Fall of −2 ln L by chance with `count` parameters, in the best of `tried` parts and properties.
fn by_chance(count: usize, tried: f64) -> f64 {
    count as f64 + 2.0 * (tried / LEVEL).ln()
}

/// Degrees of freedom in which some run has a force.
fn driven(task: &Task<'_>) -> Vec<Dof> {
    let is_driven = |dof: &Dof| task.train.iter().any(|run| run.signal(dof.force()).is_some_and(|s| !s.is_empty()));
    Dof::ALL.into_iter().filter(is_driven).collect()
}

/// The drag, the thrust and the mass of `model`, each if all of it can change; `list`: scales of the thrust and couplings of
/// inertia that are not in the model; `driven`: degrees of freedom with a force.
fn properties(model: &Model, list: &[Candidate], driven: &[Dof]) -> Vec<Property> {
    let terms = |is: &dyn Fn(&Term) -> bool| -> Vec<usize> {
        (0..model.terms.len()).filter(|k| is(&model.terms[*k])).collect()
    };
    let absent =
        |is: &dyn Fn(&Candidate) -> bool| -> Vec<usize> { (0..list.len()).filter(|k| is(&list[*k])).collect() };
    let changing = |terms: Vec<usize>, event: Event| -> Vec<Changing> {
        terms.into_iter().map(|k| Changing::Term(k, event)).collect()
    };
    let drag = terms(&|term| matches!(nature(model, term), Nature::Drag | Nature::CrossDrag));
    let is_inertia = |term: &Term| term.effect.about().id == id::INERTIA;
    let mass = terms(&|term| is_inertia(term) && !term.place.here().is_rotation());
    let turning = terms(&|term| {
        let is_own =
            is_inertia(term) && term.place.here().is_rotation() || term.effect.about().id == id::ADDED_MASS_COUPLING;
        is_own && is_changeable(model, term)
    });
    let scaled = terms(&|term| term.effect.about().id == id::THRUST_INTERACTION_LOSS);
    let scales = absent(&is_scale);
    let thrust: Vec<Changing> =
        scaled.into_iter().map(Changing::Again).chain(scales.into_iter().map(Changing::Candidate)).collect();
    let is_whole = |terms: &[usize]| !terms.is_empty() && terms.iter().all(|k| is_changeable(model, &model.terms[*k]));
    let mut all = Vec::new();
    if is_whole(&drag) {
        all.push(Property { name: "drag", relative: true, tied: changing(drag, Event::Share), own: Vec::new() });
    }
    if !thrust.is_empty() && thrust.len() == driven.iter().filter(|dof| model.dofs.contains(dof)).count() {
        all.push(Property { name: "thrust", relative: true, tied: thrust, own: Vec::new() });
    }
    if is_whole(&mass) {
        let couplings = absent(&|c| is_coupling(c, model)).into_iter().map(Changing::Candidate);
        let own = changing(turning, Event::Amount).into_iter().chain(couplings).collect();
        all.push(Property { name: "mass", relative: false, tied: changing(mass, Event::Amount), own });
    }
    all
}

/// Whether a term has one parameter, linear and the same in all runs.
fn is_changeable(model: &Model, term: &Term) -> bool {
    let [p] = term.parameters[..] else { return false };
    let spec = &model.parameters[p].spec;
    spec.is_linear() && !spec.per_run
}

/// What begins or changes.
fn what(changing: Changing, list: &[Candidate], model: &Model) -> What {
    let of = |(effect, place)| What::Effect(effect, place);
    match changing {
        Changing::Term(k, event) => What::Term(k, event),
        Changing::Again(k) => of((model.terms[k].effect.clone(), model.terms[k].place)),
        Changing::Candidate(k) => of(list[k].terms[0].clone()),
    }
}

/// Whether a candidate is a scale of the thrust in one degree of freedom.
fn is_scale(candidate: &Candidate) -> bool {
    matches!(&candidate.terms[..], [(effect, _)] if effect.about().id == id::THRUST_INTERACTION_LOSS)
}

/// Whether a candidate is what a payload off the origin adds to the inertia: a coupling of a translation and a rotation
/// that are both in the model.
fn is_coupling(candidate: &Candidate, model: &Model) -> bool {
    let [(effect, Place { dof: Some(i), other: Some(j), .. })] = &candidate.terms[..] else { return false };
    let both = model.dofs.contains(i) && model.dofs.contains(j);
    effect.about().id == id::ADDED_MASS_COUPLING && both && i.is_rotation() != j.is_rotation()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discover::candidates;
    use crate::effects::Coriolis;
    use crate::run::{Run, Signal};

    /// Surge, sway and yaw: all drag changes by one share, also what is fixed; the masses by one number, the moment of inertia and
    /// its couplings by their own; forces scale the thrust, also where the model has a scale, but not if one of them cannot.
    #[test]
    fn a_property_holds_what_changes_with_it() {
        let mut model = Model::with_effects(
            &[Dof::Surge, Dof::Sway, Dof::Yaw],
            Coriolis::Tied,
            &["inertia", "linear_drag", "quadratic_drag"],
        )
        .unwrap();
        let fixed = model.parameter("quadratic_drag@yaw", "k_r|r|").unwrap();
        model.parameters[fixed].fixed = true;
        let mut run = Run::default();
        for channel in ["u", "v", "r", "psi", "tau_u", "tau_v", "tau_r"] {
            run.signals.insert(channel.into(), Signal::new(vec![0.0, 5.0, 10.0].into(), vec![0.0, 1.0, 0.0]));
        }
        let list = candidates(&model, &[run], &[]);
        let mut list: Vec<Candidate> = list.into_iter().filter(|c| is_scale(c) || is_coupling(c, &model)).collect();
        list.sort_by_key(|c| !c.name().starts_with("thrust_interaction_loss@surge"));
        let of = |changing: &Changing| match changing {
            Changing::Term(k, _) | Changing::Again(k) => model.terms[*k].name(),
            Changing::Candidate(k) => list[*k].name(),
        };
        let held = |property: &Property| {
            let names = |of_all: &[Changing]| of_all.iter().map(of).collect::<Vec<String>>();
            (property.name, names(&property.tied), names(&property.own))
        };
        let all = properties(&model, &list, &[Dof::Surge, Dof::Sway, Dof::Yaw]);
        let [drag, thrust, mass] = &all[..] else { panic!("three properties") };
        let (name, tied, own) = held(drag);
        assert!(name == "drag" && tied.len() == 6 && own.is_empty());
        let (name, tied, own) = held(thrust);
        assert!(name == "thrust" && tied.len() == 3 && own.is_empty(), "{tied:?}");
        let (name, tied, own) = held(mass);
        assert_eq!((name, tied), ("mass", vec!["inertia@surge".to_string(), "inertia@sway".to_string()]));
        let own_of = ["inertia@yaw", "added_mass_coupling@surge:yaw", "added_mass_coupling@sway:yaw"];
        assert_eq!(own, own_of.map(String::from));
        let names: Vec<&str> = properties(&model, &list[1..], &model.dofs).iter().map(|p| p.name).collect();
        assert_eq!(names, ["drag", "mass"], "one force of three has no scale");
        model.add_named("thrust_interaction_loss@surge").unwrap();
        let names: Vec<&str> = properties(&model, &list[1..], &model.dofs).iter().map(|p| p.name).collect();
        assert_eq!(names, ["drag", "thrust", "mass"]);
    }
}
