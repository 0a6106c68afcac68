//! Properties of the vehicle that change at an instant, or in one run alone: its drag, its thrust, its mass.
//!
//! ```text
//! D → (1 + s) D      τ → (1 + s) τ      m_u, m_v, m_w → m_u + s, m_v + s, m_w + s          from t₀ on
//! ```
//!
//! Weed, a lost fairing, a weak battery or a payload changes many parameters at once, and all by one number s. A payload
//! also changes the moments of inertia and their couplings, each by a number of its own. The property that explains most
//! is reported if its score exceeds that of every effect present throughout and of a single parameter that changes, and
//! if it is borne out as an event ([`super::begun`]): a change of one parameter leaves the others of its property behind.

use std::collections::{BTreeMap, BTreeSet};

use super::begun::{Beginning, Begun, Scored, What};
use super::candidate::Candidate;
use super::columns::{InBlocks, Probe, in_blocks};
use super::constancy::{ChangedParameter, RunInstant, changed};
use super::parts::{BLOCK, Direction, Log, Together, by_chance, divided};
use super::screen::log_survival;
use super::task::{TIE, Task, asked};
use crate::chain::{Nature, nature};
use crate::effects::{Event, Place, id};
use crate::estimate::filter_error::FilterErrorFit;
use crate::estimate::output_error::OutputErrorError;
use crate::frame::Dof;
use crate::model::{Model, Term};

/// Key of the parameter s.
const S: &str = "s since t₀";

/// Share of the gain by which a property may fall behind the first one and still be the likelier one at its own instant:
/// an instant that is some seconds off costs as much.
const BEHIND: f64 = 0.1;

/// A property of the vehicle: what changes by s, and what changes with it by numbers of its own.
struct Property {
    name: &'static str,
    /// Whether s is a share.
    relative: bool,
    tied: Vec<Member>,
    own: Vec<Member>,
}

/// What changes with a property.
struct Member {
    what: What,
    score: Source,
}

/// Where the score of a member comes from.
#[derive(Clone, Copy)]
enum Source {
    /// A parameter of the model, and how much it changes with s.
    Parameter(usize, f64),
    /// A candidate.
    Candidate(usize),
}

/// A property that was fitted.
struct Fitted<'a> {
    property: &'a Property,
    beginnings: Vec<Beginning>,
    begun: Begun,
    between: Vec<RunInstant>,
    /// Fall of −2 ln L that the scores promise.
    score: f64,
}

/// The property of the vehicle that has changed, with a score beyond `least`; `scored`: the candidates beside `fit`.
///
/// # Errors
/// [`OutputErrorError`] when a run lacks what a candidate reads.
pub(super) fn stepped(
    (fit, scored): (&FilterErrorFit, Scored<'_>),
    task: &Task<'_>,
    least: f64,
) -> Result<Option<ChangedParameter>, OutputErrorError> {
    let Some(any) = changed(fit, task.train, task.options.seed, |_| true) else { return Ok(None) };
    let mut list = asked(&fit.model, task);
    list.retain(|c| is_scale(c) || is_coupling(c, &fit.model));
    let properties = properties(&fit.model, &list, &driven(task));
    let InBlocks { probes, products } = in_blocks(fit.into(), task.train, &list, &task.fitting.base, BLOCK)?;
    let (blocks, parts) = divided(fit, task.train, &products, probes.len());
    let estimated = (0..fit.filtered.problem.unknowns.len()).collect();
    let tried = (parts.len() * properties.len()) as f64;
    let Some(log) = Log::of(blocks, parts, (estimated, Vec::new()), fit.priors().collect()) else { return Ok(None) };
    let at_its_block = properties.iter().filter_map(|property| {
        let (beginnings, found) = property.begun(fit, &probes, &log)?;
        // scores are compared with scores: beside a model that lacks much they promise less than a fit gains
        let score = found.gain + found.changes.len() as f64;
        if score < least.max(by_chance(found.changes.len(), tried)) {
            return None;
        }
        let begun = Begun::at(log.parts[found.part].clone(), &beginnings, fit, task)?;
        Some(Fitted { property, beginnings, begun, between: Vec::new(), score })
    });
    let Some(best) = likeliest(at_its_block.collect(), fit, &log, task) else { return Ok(None) };
    let Fitted { property, beginnings, begun, between, score } = best;
    let (gain, count) = (fit.cost - begun.fit.cost, begun.count());
    // twice the limit of chance: near to it any change absorbs a little of another effect
    if gain < 2.0 * by_chance(count, tried) {
        return Ok(None);
    }
    // a parameter that changes alone is the simpler answer
    if any.alone && (any.change / any.std).powi(2) > score {
        return Ok(None);
    }
    let s = &begun.fit.model.parameters[begun.first_new];
    let (change, std) = (s.value - s.spec.neutral, s.std.unwrap_or(f64::INFINITY));
    if (change / std).powi(2) < by_chance(1, tried) {
        return Ok(None);
    }
    let chance = by_chance(1, tried);
    let Some(left) = begun.borne_out((&beginnings, chance), (fit, scored), task)? else { return Ok(None) };
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

/// The property that is likelier than the others, each from its likeliest instant; `None` if two are as likely: then
/// neither is the answer.
fn likeliest<'a>(mut fitted: Vec<Fitted<'a>>, fit: &FilterErrorFit, log: &Log, task: &Task<'_>) -> Option<Fitted<'a>> {
    let cost = |of: &Fitted<'_>| of.begun.fit.cost + of.begun.count() as f64;
    let first = fitted.iter().map(cost).fold(f64::INFINITY, f64::min);
    fitted.retain(|one| cost(one) - first < (BEHIND * (fit.cost - first)).max(TIE));
    let refined = fitted.into_iter().map(|one| {
        let (begun, between) = one.begun.likeliest(&log.parts, task);
        Fitted { begun, between, ..one }
    });
    let mut refined: Vec<Fitted<'a>> = refined.collect();
    refined.sort_by(|a, b| cost(a).total_cmp(&cost(b)));
    let mut refined = refined.into_iter();
    let best = refined.next()?;
    let is_tied = refined.next().is_some_and(|second| cost(&second) < cost(&best) + TIE);
    (!is_tied).then_some(best)
}

impl Property {
    /// What begins or changes in the block that its scores point to, with the values that they promise.
    fn begun(&self, fit: &FilterErrorFit, probes: &[Probe], log: &Log) -> Option<(Vec<Beginning>, Together)> {
        let unknowns = &fit.filtered.problem.unknowns;
        // none of a parameter that is fixed
        let along = |member: &Member| match member.score {
            Source::Parameter(p, weight) => Some((unknowns.iter().position(|u| u.parameter == p)?, weight)),
            Source::Candidate(k) => Some((unknowns.len() + probes.iter().position(|probe| probe.candidate == k)?, 1.0)),
        };
        // terms that share a parameter change it once
        let tied: BTreeMap<usize, f64> = self.tied.iter().filter_map(along).collect();
        let mut seen = BTreeSet::new();
        let own = self.own.iter().filter_map(|own| Some((own, along(own)?)));
        let own: Vec<(&Member, (usize, f64))> = own.filter(|(_, (unknown, _))| seen.insert(*unknown)).collect();
        let mut directions: Vec<Direction> = vec![tied.into_iter().collect()];
        directions.extend(own.iter().map(|(_, along)| vec![*along]));
        let found = log.together(&directions)?;
        let mut beginnings = Vec::new();
        for (direction, start) in &found.changes {
            let begins = |of: &Member, tie| Beginning { what: of.what.clone(), start: *start, tie };
            match direction.checked_sub(1) {
                None => beginnings.extend(self.tied.iter().map(|tied| begins(tied, Some(S)))),
                Some(k) => beginnings.push(begins(own[k].0, None)),
            }
        }
        Some((beginnings, found))
    }
}

impl Member {
    /// A term of the model whose parameter changes.
    fn changing(model: &Model, k: usize, event: Event) -> Member {
        let p = model.terms[k].parameters[0];
        let weight = if event == Event::Share { model.parameters[p].value } else { 1.0 };
        Member { what: What::Term(k, event), score: Source::Parameter(p, weight) }
    }

    /// The effect of a term of the model, which acts once more.
    fn again(model: &Model, k: usize) -> Member {
        let Term { effect, place, parameters, .. } = &model.terms[k];
        let score = Source::Parameter(parameters[0], model.parameters[parameters[0]].value);
        Member { what: What::Effect(effect.clone(), *place), score }
    }

    /// A candidate, number `k` of `list`.
    fn candidate(list: &[Candidate], k: usize) -> Member {
        let (effect, place) = list[k].terms[0].clone();
        Member { what: What::Effect(effect, place), score: Source::Candidate(k) }
    }
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
    let absent = |is: &dyn Fn(&Candidate) -> bool| -> Vec<Member> {
        (0..list.len()).filter(|k| is(&list[*k])).map(|k| Member::candidate(list, k)).collect()
    };
    let changing = |terms: Vec<usize>, event: Event| -> Vec<Member> {
        terms.into_iter().map(|k| Member::changing(model, k, event)).collect()
    };
    let is_whole = |terms: &[usize]| !terms.is_empty() && terms.iter().all(|k| is_changeable(model, &model.terms[*k]));
    let mut all = Vec::new();
    let drag = terms(&|term| matches!(nature(model, term), Nature::Drag | Nature::CrossDrag));
    if is_whole(&drag) {
        all.push(Property { name: "drag", relative: true, tied: changing(drag, Event::Share), own: Vec::new() });
    }
    let scaled = terms(&|term| term.effect.about().id == id::THRUST_INTERACTION_LOSS);
    let mut thrust: Vec<Member> = scaled.into_iter().map(|k| Member::again(model, k)).collect();
    thrust.extend(absent(&is_scale));
    if !thrust.is_empty() && thrust.len() == driven.iter().filter(|dof| model.dofs.contains(dof)).count() {
        all.push(Property { name: "thrust", relative: true, tied: thrust, own: Vec::new() });
    }
    let is_mass = |term: &Term| term.effect.about().id == id::INERTIA && !term.place.here().is_rotation();
    let mass = terms(&is_mass);
    if is_whole(&mass) {
        let is_own = |term: &Term| [id::INERTIA, id::ADDED_MASS_COUPLING].contains(&term.effect.about().id);
        let own = terms(&|term| is_own(term) && !is_mass(term) && is_changeable(model, term));
        let mut own = changing(own, Event::Amount);
        own.extend(absent(&|c| is_coupling(c, model)));
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
    use crate::model::name_of;
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
        let of = |member: &Member| match &member.what {
            What::Term(k, _) => model.terms[*k].name(),
            What::Effect(effect, place) => name_of(effect.about().id, *place),
        };
        let held = |property: &Property| {
            let names = |members: &[Member]| members.iter().map(of).collect::<Vec<String>>();
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
