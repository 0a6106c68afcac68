//! Candidates: every effect of the catalogue that is not in the model yet, at every place where it may act.
//!
//! An effect with shape parameters is probed at each point of its grid; a candidate comprises all its probes. Terms
//! that share a parameter (the net weight in surge and sway) are one candidate. If the leading product of a row of
//! −C(ν)ν is not the whole row, the whole row, with the coefficients of the momentum, is a candidate beside that
//! product alone.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::screen::Score;
use crate::chain::{Nature, acts_in, alters, follows, nature_at};
use crate::effects::{
    Coriolis, CoriolisRow, Effect, Family, GridUnit, ParameterKind, Place, Scope, catalogue, id, leading_is_all,
};
use crate::frame::Dof;
use crate::model::{Model, name_of, places_of};
use crate::run::{Run, Signal, greatest};

/// Pairs of effects that no data can distinguish: the second is not tested, as the first stands for both. A late log
/// is a late command.
const SPOKEN_FOR: [(&str, &str); 1] = [(id::THRUST_DELAY, id::SENSOR_DELAY)];

/// Minimum number of samples in a period: with two, all samples are equal up to the sign, and imitate a constant.
const PERIOD: f64 = 3.0;

/// Number of parts into which two meshes of a grid are divided when it is refined.
const FINER: u8 = 8;

/// Names of the effects that a candidate stands for.
pub(super) fn spoken_for(name: &str) -> impl Iterator<Item = String> {
    SPOKEN_FOR.into_iter().filter(move |(speaker, _)| *speaker == name).map(|(_, other)| other.to_string())
}

/// An effect that may be missing.
#[derive(Debug, Clone)]
pub struct Candidate {
    /// The terms that are added together; the first one gives the name.
    pub terms: Vec<(Arc<dyn Effect>, Place)>,
    /// Values of the shape parameters at which it is probed, in the order of the first term's shape parameters; one
    /// empty probe for an effect without any.
    pub probes: Vec<Vec<f64>>,
    /// Whether it is probed by blending it in, because its linear parameters alone cannot make it vanish.
    pub blended: bool,
    /// The term that it replaces: the same effect with one value for all runs.
    pub in_stead_of: Option<(Arc<dyn Effect>, Place)>,
}

impl Candidate {
    /// `id`, `id@dof` or `id@dof:other` of its first term.
    pub fn name(&self) -> String {
        name_of(self.terms[0].0.about().id, self.terms[0].1)
    }

    /// Whether `term` is one of its terms.
    pub fn holds(&self, term: &str) -> bool {
        self.terms.iter().any(|(effect, place)| name_of(effect.about().id, *place) == term)
    }

    /// Removes its terms from a model that has them; the term that it replaced returns, with the mean of the runs.
    pub fn remove_from(&self, model: &mut Model) {
        for (effect, place) in self.terms.iter().rev() {
            let Some(term) = model.term(&name_of(effect.about().id, *place)) else { continue };
            let means: Vec<f64> = model.terms[term].parameters.iter().map(|p| model.parameters[*p].mean()).collect();
            model.remove(term);
            let Some((former, place)) = &self.in_stead_of else { continue };
            if let Ok(term) = model.add(former.clone(), *place) {
                for (p, mean) in model.terms[term].parameters.clone().into_iter().zip(means) {
                    model.parameters[p].value = mean;
                }
            }
        }
    }

    /// `model` without its terms.
    pub(super) fn taken_out_of(&self, model: &Model) -> Model {
        let mut without = model.clone();
        self.remove_from(&mut without);
        without
    }

    /// Family of its first term.
    pub fn family(&self) -> Family {
        self.terms[0].0.about().family
    }

    /// Whether its first term has parameters: the whole row of −C(ν)ν has none.
    pub fn has_parameters(&self) -> bool {
        let (effect, place) = &self.terms[0];
        !effect.parameters(*place).is_empty()
    }

    /// Whether one of its parameters has a value of its own in every run.
    pub(super) fn has_own_values(&self) -> bool {
        self.terms.iter().any(|(effect, place)| effect.parameters(*place).iter().any(|spec| spec.per_run))
    }

    /// Degrees of freedom in which it acts, among those of the model.
    pub fn dofs(&self, model: &Model) -> Vec<Dof> {
        let mut dofs: Vec<Dof> =
            self.terms.iter().flat_map(|(effect, place)| acts_in(effect.as_ref(), *place, model)).collect();
        dofs.sort_unstable();
        dofs.dedup();
        dofs
    }

    /// Values of its only shape parameter; `None` for a candidate with none, or with several.
    pub(super) fn grid(&self) -> Option<Vec<f64>> {
        let single = |p: &Vec<f64>| if let [x] = p.as_slice() { Some(*x) } else { None };
        self.probes.iter().map(single).collect()
    }

    /// The candidate with a finer grid about one of its probes, up to the neighbours on its grid; `None` for a
    /// candidate without a grid or with several shape parameters.
    pub fn nearer(&self, probe: usize) -> Option<Candidate> {
        let mut grid = self.grid()?;
        let at = grid[probe];
        grid.sort_by(f64::total_cmp);
        let k = grid.iter().position(|x| x.total_cmp(&at).is_eq()).filter(|_| grid.len() > 1)?;
        let low = if k > 0 { grid[k - 1] } else { at };
        let high = if k + 1 < grid.len() { grid[k + 1] } else { at };
        let parts = f64::from(FINER);
        let finer = (0..=FINER).map(|i| vec![low + (high - low) * f64::from(i) / parts]).collect();
        Some(Candidate { probes: finer, ..self.clone() })
    }

    /// The model with the candidate added, its parameters started at the values of its score.
    pub fn started(&self, model: &Model, score: &Score) -> Option<Model> {
        let former =
            self.in_stead_of.as_ref().and_then(|(effect, place)| model.term(&name_of(effect.about().id, *place)));
        let former = former.iter().flat_map(|term| &model.terms[*term].parameters);
        let former: Vec<f64> = former.map(|p| model.parameters[*p].value).collect();
        let mut model = model.clone();
        let probe = self.probes.get(score.probe).map_or(&[][..], Vec::as_slice);
        let added = self.add_to(&mut model, probe).ok()?;
        let new: BTreeSet<usize> = added.iter().flat_map(|term| model.terms[*term].parameters.clone()).collect();
        for (p, value) in new.iter().zip(former) {
            model.parameters[*p].value = value;
        }
        let estimates = score.estimate.iter().filter(|_| !self.blended);
        let new = model.parameters.iter_mut().enumerate().filter(|(p, _)| new.contains(p)).map(|(_, p)| p);
        // the score's estimate also applies to a shape without a grid
        let single = self.probes.len() == 1;
        for (parameter, estimate) in new.filter(|p| !p.spec.per_run && (p.spec.is_linear() || single)).zip(estimates) {
            parameter.value = (parameter.spec.neutral + estimate).clamp(parameter.min, parameter.max);
        }
        Some(model)
    }

    /// The same with its only shape at the estimated share of the probe, within its bounds: a small blend α of a
    /// probe is the effect at α times the probe. `None` for a candidate that is not blended.
    pub fn started_in_part(&self, model: &Model, score: &Score) -> Option<Model> {
        let mut begun = self.started(model, score).filter(|_| self.blended)?;
        let ([new], [share]) = (&mut begun.parameters[model.parameters.len()..], &score.estimate[..]) else {
            return None;
        };
        new.value = (share * new.value).clamp(new.min, new.max);
        Some(begun)
    }

    /// Whether the shape that the score estimates is allowed. A blend α of a probe is, for small α, the effect at α
    /// times the probe: a delay of −3 ms, or of 3 ms where 50 ms is the least that counts, is noise and needs no
    /// refit.
    pub fn is_possible(&self, score: &Score) -> bool {
        /// Margin on the lower bound, as the score is only a linear approximation.
        const MARGIN: f64 = 0.5;
        let (effect, place) = &self.terms[0];
        let probe = self.probes.get(score.probe).and_then(|probe| probe.first());
        let shape = effect.parameters(*place).into_iter().next().map(|spec| spec.kind);
        match (shape, probe, score.estimate.first()) {
            (Some(ParameterKind::Shape { min, .. }), Some(at), Some(share)) if self.blended => {
                share * at >= MARGIN * min
            }
            _ => true,
        }
    }

    /// Adds its terms to a model; shape parameters take the values of `probe`.
    ///
    /// # Errors
    /// As [`Model::add`].
    pub fn add_to(&self, model: &mut Model, probe: &[f64]) -> Result<Vec<usize>, crate::model::ModelError> {
        let mut added = Vec::new();
        for (effect, place) in &self.terms {
            let term = model.add(effect.clone(), *place)?;
            let shapes: Vec<usize> = model.terms[term]
                .parameters
                .iter()
                .copied()
                .filter(|p| !model.parameters[*p].spec.is_linear())
                .collect();
            for (p, value) in shapes.into_iter().zip(probe) {
                model.parameters[p].value = *value;
            }
            added.push(term);
        }
        Ok(added)
    }
}

/// Rows of −C(ν)ν that one free coefficient does not describe completely; they have no parameters to find.
fn whole_rows(model: &Model) -> Vec<Arc<dyn Effect>> {
    let tied = (model.coriolis == Coriolis::Tied).then_some(&model.dofs);
    let rows = tied.into_iter().flatten().filter(|row| !leading_is_all(**row, &model.dofs));
    rows.map(|row| Arc::new(CoriolisRow { row: *row, coriolis: Coriolis::Tied }) as Arc<dyn Effect>).collect()
}

/// Whether the model has this row of −C(ν)ν.
fn has_row(model: &Model, row: Dof) -> bool {
    let own = CoriolisRow { row, coriolis: model.coriolis };
    model.terms.iter().any(|term| term.effect.about().id == own.about().id)
}

/// All candidates for `model` on `runs`, including the user's effects (`own`).
pub fn candidates(model: &Model, runs: &[Run], own: &[(Arc<dyn Effect>, Place)]) -> Vec<Candidate> {
    let present: BTreeSet<String> = model.terms.iter().map(crate::model::Term::name).collect();
    let loudest = loudest_command(model, runs);
    let slowest = slowest_sensor(model, runs);
    let mut list: Vec<Candidate> = Vec::new();
    let known = catalogue(Coriolis::Free);
    let whole = whole_rows(model);
    let places = known
        .iter()
        .chain(&whole)
        .flat_map(|effect| places_for(effect.as_ref(), model, runs).into_iter().map(|p| (effect.clone(), p)));
    for (effect, place) in places.chain(own.iter().cloned()) {
        let about = effect.about();
        if present.contains(&name_of(about.id, place)) || SPOKEN_FOR.iter().any(|(_, other)| *other == about.id) {
            continue;
        }
        let has_wider = |t: &crate::model::Term| t.place == place && t.effect.same_in_all_runs() == Some(about.id);
        if model.terms.iter().any(has_wider) {
            continue;
        }
        let alone = |row: Dof| model.coriolis == Coriolis::Free || !has_row(model, row);
        if effect.shares_row(place).is_some_and(alone) || !readable(effect.as_ref(), place, model, runs) {
            continue;
        }
        let shared = effect.parameters(place).first().and_then(|p| p.shared);
        if shared.is_some() && model.parameters.iter().any(|p| p.spec.shared == shared) {
            continue;
        }
        let same = |c: &&mut Candidate| {
            let (first, at) = &c.terms[0];
            shared.is_some() && first.parameters(*at).first().and_then(|p| p.shared) == shared
        };
        if let Some(group) = list.iter_mut().find(same) {
            group.terms.push((effect, place));
            continue;
        }
        // one run does not distinguish values of its own from one value for all runs
        if effect.same_in_all_runs().is_some() && runs.len() < 2 {
            continue;
        }
        let in_stead_of = effect.same_in_all_runs().and_then(|id| model.term(&name_of(id, place)));
        let in_stead_of = in_stead_of.map(|term| (model.terms[term].effect.clone(), place));
        let scale = place.dof.map_or(0.0, |dof| loudest[dof.index()]);
        let parameters = effect.parameters(place);
        let mut probes = probes(effect.as_ref(), place, (scale, model.length));
        // a wave has one period in all runs, which the slowest sensor must resolve
        if parameters.iter().any(|p| p.per_run) && parameters.iter().any(|p| !p.per_run) {
            probes.retain(|probe| probe.iter().all(|period| *period > PERIOD * slowest));
        }
        if probes.is_empty() {
            continue;
        }
        // a shape that has no grid is its own direction
        let changes = matches!(about.family, Family::Actuator | Family::Sensor);
        let shaped = changes && parameters.iter().all(|p| !p.is_linear());
        let blended = parameters.is_empty() || shaped && probes.len() > 1;
        list.push(Candidate { terms: vec![(effect, place)], probes, blended, in_stead_of });
    }
    list
}

/// Places at which an effect is a candidate. A coupling with a motion that is not modelled counts only if that motion
/// is logged and exceeds its noise; a symmetric coupling counts once.
fn places_for(effect: &dyn Effect, model: &Model, runs: &[Run]) -> Vec<Place> {
    let mut places = places_of(effect, &model.dofs);
    let about = effect.about();
    let symmetric = |p: &Place| p.other.is_some() && nature_at(effect, *p, model) == Nature::Inertia;
    if places.first().is_some_and(symmetric) {
        places.retain(|p| p.dof < p.other);
    }
    if matches!(about.family, Family::Body) {
        let coupled = |dof: Dof, other: Dof| match about.scope {
            Scope::Pairs => true,
            Scope::Couples(list) => list.contains(&(dof, other)),
            _ => false,
        };
        let others = Dof::ALL.into_iter().filter(|d| !model.dofs.contains(d) && moves(runs, d.velocity()));
        let extra = others.flat_map(|other| model.dofs.iter().map(move |dof| (*dof, other)));
        places.extend(extra.filter(|(i, j)| coupled(*i, *j)).map(|(i, j)| Place::pair(i, j)));
    }
    places
}

/// Whether every run has the channels that the effect reads, and some run one that it alters.
fn readable(effect: &dyn Effect, place: Place, model: &Model, runs: &[Run]) -> bool {
    let logs = |run: &Run, name: &str| run.signal(name).is_some_and(|s| !s.is_empty());
    let has = |name: &str| runs.iter().all(|run| logs(run, name));
    let family = effect.about().family;
    let commanded = || Dof::ALL.iter().any(|dof| has(dof.force()));
    let heard = match (family, place.other.or(place.dof)) {
        // an actuator effect needs a logged force
        (Family::Actuator, Some(dof)) => has(dof.force()),
        (Family::Actuator, None) => commanded(),
        // a clock that drifts brings the command at another instant
        (Family::Sensor, _) if effect.delays_command().is_some() => commanded(),
        // a channel that a sensor effect alters must be logged
        (Family::Sensor, _) => alters(effect, place, model).iter().any(|name| runs.iter().any(|run| logs(run, name))),
        _ => true,
    };
    // a memory effect follows velocities, as logged or as slopes of positions
    let slopes = |dof: Dof| match dof {
        Dof::Surge | Dof::Sway => ["x", "y", "psi"].into_iter().all(has),
        _ => has(dof.position()),
    };
    let listens = || follows(effect, place, model).into_iter().all(|dof| has(dof.velocity()) || slopes(dof));
    heard
        && listens()
        && effect.channels(place).iter().all(|name| has(name))
        && effect.pose().iter().all(|name| has(name))
}

/// Whether a channel varies by more than its noise.
fn moves(runs: &[Run], channel: &str) -> bool {
    runs.iter().filter_map(|run| run.signal(channel)).any(|signal| {
        let (size, noise) = (deviation(signal.values()), sample_noise(signal));
        size > 3.0 * noise && size > 0.0
    })
}

fn deviation(x: &[f64]) -> f64 {
    let n = x.len().max(1) as f64;
    let mean = x.iter().sum::<f64>() / n;
    (x.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt()
}

/// Standard deviation of the noise between samples, from third differences.
fn sample_noise(signal: &Signal) -> f64 {
    let x = signal.values();
    let sum: f64 = x.windows(4).map(|w| (w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]).powi(2)).sum();
    (sum / (20.0 * x.len().saturating_sub(3).max(1) as f64)).sqrt()
}

/// Greatest command in each degree of freedom, N and N·m.
fn loudest_command(model: &Model, runs: &[Run]) -> [f64; 6] {
    let mut loudest = [0.0; 6];
    for dof in &model.dofs {
        loudest[dof.index()] = greatest(runs, dof.force());
    }
    loudest
}

/// Longest mean interval between samples of the model's outputs, s.
fn slowest_sensor(model: &Model, runs: &[Run]) -> f64 {
    let of = |run: &Run| {
        let signals = model.measured().into_iter().filter_map(|m| run.signal(m.channel())).filter(|s| s.len() > 1);
        let interval = |s: &Signal| (s.time()[s.len() - 1] - s.time()[0]) / (s.len() - 1) as f64;
        signals.map(interval).fold(0.0, f64::max)
    };
    runs.iter().map(of).fold(0.0, f64::max)
}

/// All combinations of the grids of the shape parameters. Grids in units of the greatest command or of the vehicle's
/// length are scaled by these.
fn probes(effect: &dyn Effect, place: Place, (loudest, length): (f64, f64)) -> Vec<Vec<f64>> {
    let mut all = vec![Vec::new()];
    for spec in effect.parameters(place) {
        let ParameterKind::Shape { grid, .. } = &spec.kind else { continue };
        let scale = match spec.grid_in {
            GridUnit::Own => 1.0,
            GridUnit::GreatestCommand => loudest,
            GridUnit::Length => length,
        };
        all = all
            .into_iter()
            .flat_map(|head: Vec<f64>| {
                grid.iter().map(move |g| head.iter().copied().chain([g * scale]).collect::<Vec<f64>>())
            })
            .collect();
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(dofs: &[Dof], coriolis: Coriolis) -> Vec<(String, bool)> {
        let model = Model::with_effects(dofs, coriolis, &["inertia"]).unwrap();
        let rows = candidates(&model, &[], &[]).into_iter().filter(|c| c.name().starts_with("coriolis"));
        rows.map(|c| (c.name(), c.has_parameters())).collect()
    }

    /// −C(ν)ν has one product per row in the horizontal plane and two in space, where one coefficient is not the
    /// whole row.
    #[test]
    fn a_row_of_two_products_is_asked_for_as_a_whole() {
        let planar = rows(&[Dof::Surge, Dof::Sway, Dof::Yaw], Coriolis::Tied);
        assert_eq!(planar.len(), 3);
        assert!(planar.iter().all(|(_, parameters)| *parameters));
        let spatial = rows(&Dof::ALL, Coriolis::Tied);
        for row in Dof::ALL.map(|dof| format!("coriolis_{dof}")) {
            for parameters in [true, false] {
                assert!(spatial.contains(&(row.clone(), parameters)), "{row}: {spatial:?}");
            }
        }
        let vertical = rows(&[Dof::Surge, Dof::Heave, Dof::Pitch], Coriolis::Tied);
        let named = [("coriolis_heave", true), ("coriolis_pitch", true), ("coriolis_surge", false)];
        assert_eq!(vertical, named.map(|(id, parameters)| (id.to_string(), parameters)), "−m_w w q is asked for");
        assert!(rows(&Dof::ALL, Coriolis::Free).iter().all(|(_, parameters)| *parameters));
    }

    /// A finer grid spans both neighbours of a probe, or one at an end; a candidate without a grid has none.
    #[test]
    fn a_finer_grid_reaches_to_the_neighbours() {
        let list = candidates(&Model::with_effects(&[Dof::Surge], Coriolis::Tied, &["inertia"]).unwrap(), &[], &[]);
        let drag = list.iter().find(|c| c.name() == "cubic_drag@surge").unwrap();
        assert!(drag.nearer(0).is_none());
        let grid = |values: &[f64]| Candidate { probes: values.iter().map(|x| vec![*x]).collect(), ..drag.clone() };
        let ends = |probe: usize| {
            let finer = grid(&[1.0, 2.0, 4.0]).nearer(probe).unwrap().probes;
            assert_eq!(finer.len(), 9);
            (finer[0][0], finer[8][0])
        };
        assert_eq!([ends(0), ends(1), ends(2)], [(1.0, 2.0), (1.0, 4.0), (2.0, 4.0)]);
        assert!(grid(&[1.0]).nearer(0).is_none(), "nothing lies beside it");
    }
}
