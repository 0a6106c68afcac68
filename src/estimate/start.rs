//! Starting values for output error: integral least squares on the effects that it can regress.
//!
//! Effects with memory or with an action on the log are left out and keep their values. Shape
//! parameters are held at their values, and so are parameters with a prior. Windows of several
//! samples keep the noise of the velocities from shrinking the inertias. A start that no vehicle
//! has (an inertia that is not positive) is replaced by a rough value from the greatest force and
//! speed of the log.

use super::integral::balances;
use super::pose_velocity::{self, with_velocities};
use super::window;
use super::{IntegralError, IntegralOptions, RegressorError, RegressorOptions, Span, Together};
use crate::chain::memory_count;
use crate::effects::{Effect, Family, Scope, id};
use crate::frame::Dof;
use crate::model::{Model, Parameter, Term};
use crate::run::{Run, Signal, greatest, is_commanded};
use crate::symbolic::Graph;

/// Returns `model` with its free linear parameters started from `runs`. Parameters that cannot be
/// regressed, and those whose starting value was given, keep their values.
///
/// If a run logs only poses, their slopes, rotated to the axes of the body, are its velocities.
pub fn started(model: &Model, runs: &[Run]) -> Model {
    let logged = runs;
    let (runs, spans) = with_velocities(model, logged);
    let runs: &[Run] = &with_forces(&model.dofs, runs);
    let mut plain = model.clone();
    for k in (0..plain.terms.len()).rev() {
        if !regressible(&plain, &plain.terms[k]) {
            plain.remove(k);
        }
    }
    for p in plain.parameters.iter_mut().filter(|p| !p.spec.is_linear() || p.prior.is_some()) {
        p.fixed = true;
    }
    let is_logged = |dof: &Dof| logged.iter().any(|run| run.signal(dof.velocity()).is_some_and(|s| !s.is_empty()));
    if spans.translation > pose_velocity::SPAN {
        for dof in model.dofs.iter().filter(|dof| !dof.is_rotation() && !is_logged(dof)) {
            unregressed(&mut plain, *dof, runs);
        }
    }
    let all: Vec<&Run> = runs.iter().collect();
    let window = window::length(&model.dofs, runs).max(spans.translation).max(spans.rotation);
    let span = Span::Samples(samples_in(window, model, runs));
    let regressor = RegressorOptions { span, ..RegressorOptions::default() };
    // a start needs only the right size, and one is needed in any case
    let options = IntegralOptions { regressor, together: Together::AsForces, ..Default::default() };
    let mut started = model.clone();
    let Some(plain) = regressed(&all, plain, is_logged, options) else { return rough(started, model, runs, is_logged) };
    for parameter in started.parameters.iter_mut().filter(|p| !p.fixed && !p.given) {
        if let Some(found) =
            plain.parameters.iter().find(|p| p.term == parameter.term && p.spec.name == parameter.spec.name)
        {
            // an inertia that is not positive is no start at all; at its bound it could not be
            // recognised as such
            let bounded = parameter.effect != id::INERTIA;
            parameter.value = if bounded { found.value.clamp(parameter.min, parameter.max) } else { found.value };
            parameter.per_run.clone_from(&found.per_run);
        }
    }
    rough(started, model, runs, is_logged)
}

/// The runs with a force of zero where they log none: fins or a user's formula drive the vehicle
/// there.
fn with_forces(dofs: &[Dof], mut runs: Vec<Run>) -> Vec<Run> {
    for run in &mut runs {
        let Some((first, last)) = run.span() else { continue };
        let none = Signal::new(vec![first, last].into(), vec![0.0; 2]);
        let absent = |dof: &&Dof| run.signal(dof.force()).is_none_or(Signal::is_empty);
        let absent: Vec<Dof> = dofs.iter().filter(absent).copied().collect();
        run.signals.extend(absent.into_iter().map(|dof| (dof.force().to_string(), none.clone())));
    }
    runs
}

/// Keeps the inertia of a translation whose velocity is the slope of noisy fixes at its starting
/// value, the dry mass if it is known. Such slopes hardly show accelerations, and a regression on
/// them finds five and ten times the mass. From there a filter climbs to a force of a hundred times
/// the thrust on a mass of as many tons.
fn unregressed(model: &mut Model, dof: Dof, runs: &[Run]) {
    /// Time in which the greatest force brings the greatest speed, if no mass is known, s.
    const SETTLES: f64 = 2.0;
    let Some(index) = model.inertia(dof) else { return };
    let ((force, speed), inertia) = (sizes(dof, runs), &mut model.parameters[index]);
    if inertia.value <= inertia.spec.least {
        inertia.value = if force > 0.0 && speed > 0.0 { SETTLES * force / speed } else { 1.0 };
    }
    inertia.fixed = true;
}

/// Returns `model` with the results of its balances. A balance in which nothing known acts has no
/// scale of its own: it waits for the others, which give the masses whose Munk moment turns a
/// vehicle without a commanded moment. The balance of a rate with a sensor (`is_logged`) also waits
/// if other velocities are slopes of fixes. It fits so well that velocities noisier than its
/// residual would seem not to act at all, which means equal masses. `None` if the first balances
/// have no solution.
fn regressed(
    runs: &[&Run],
    mut model: Model,
    is_logged: impl Fn(&Dof) -> bool,
    options: IntegralOptions,
) -> Option<Model> {
    // a rotation that a fin drives gets its scale from its inertia alone; if that were free as
    // well, least squares would shrink everything that acts in it to zero, including the difference
    // of two masses
    let has_fin = model.terms.iter().any(is_fin);
    let turns = |dof: &Dof| has_fin && dof.is_rotation() && !is_commanded_in(runs, *dof);
    for dof in model.dofs.clone().iter().filter(|dof| turns(dof)) {
        let inertia = model.inertia(*dof).map(|index| &mut model.parameters[index]);
        if let Some(inertia) = inertia.filter(|p| p.value > p.spec.least) {
            inertia.fixed = true;
        }
    }
    let (mut scaled, mut waiting): (Vec<Dof>, Vec<Dof>) = model.dofs.iter().partition(|dof| !is_logged(dof));
    if scaled.is_empty() {
        scaled = std::mem::take(&mut waiting);
    }
    let fits = loop {
        match balances(runs, &model, &scaled, options) {
            Ok((found, fits)) => {
                model = found;
                break fits;
            }
            Err(IntegralError::Regressor(RegressorError::NoScale { dof })) if scaled.len() > 1 => {
                scaled.retain(|other| *other != dof);
                waiting.push(dof);
            }
            Err(_) => return None,
        }
    };
    for column in fits.iter().flat_map(|fit| &fit.parameters) {
        model.parameters[column.parameter].fixed = true;
    }
    // the effect of one fin in several balances is found in all of them together
    if let Ok((found, _)) = balances(runs, &model, &waiting, options) {
        return Some(found);
    }
    for dof in waiting {
        if let Ok((found, _)) = balances(runs, &model, &[dof], options) {
            model = found;
        }
    }
    Some(model)
}

fn is_commanded_in(runs: &[&Run], dof: Dof) -> bool {
    runs.iter().any(|run| is_commanded(std::slice::from_ref(*run), dof))
}

/// Whether a term is an actuator beside the thrust: a fin, or the propeller in its advance.
fn is_fin(term: &Term) -> bool {
    let about = term.effect.about();
    about.family == Family::Actuator && matches!(about.scope, Scope::Vehicle(_))
}

fn regressible(model: &Model, term: &Term) -> bool {
    let effect: &dyn Effect = term.effect.as_ref();
    let about = effect.about();
    let remembers = memory_count(&Graph::new(), model, effect, term.place) > 0;
    let is_fin = is_fin(term);
    // single thrusters act on the command itself, in which they are linear, and fins act beside it,
    // at a place that is held; the effects of other actuators depend on each other
    let known = about.family != Family::Actuator || about.scope == Scope::Thrusters || is_fin;
    let linear = is_fin || term.parameters.iter().all(|p| model.parameters[*p].spec.is_linear());
    about.family != Family::Sensor && known && linear && !remembers
}

/// Number of samples of the slowest velocity sensor in `window` seconds, at least 1.
pub(crate) fn samples_in(window: f64, model: &Model, runs: &[Run]) -> usize {
    let steps =
        runs.iter().flat_map(|run| model.dofs.iter().filter_map(|dof| run.signal(dof.velocity()))).filter_map(|s| {
            let (first, last) = (s.time().first()?, s.time().last()?);
            Some((last - first) / s.len().saturating_sub(1).max(1) as f64)
        });
    let slowest = steps.fold(0.0, f64::max);
    if slowest > 0.0 { (window / slowest).round().max(1.0) as usize } else { 1 }
}

/// A motion that drag stops, or a righting moment turns back, within this time does not show in a
/// log, s.
const AT_ONCE: f64 = 0.05;

/// The same if the velocity is the slope of a second of poses ([`super::pose_velocity`]), which
/// flattens quicker motion: the regression then finds an inertia that is too small by a factor of
/// ten and more, and the fit finds a random moment in its place.
const AT_ONCE_BY_SLOPES: f64 = 0.5;

/// Corrects a start from which a simulation would diverge. Inertias that are not positive are
/// replaced by the greatest force over a tenth of the greatest speed per second. Inertias so small
/// that the motion would end at once are raised ([`AT_ONCE`], or [`AT_ONCE_BY_SLOPES`] if no sensor
/// logs the velocity). Drag that would feed the motion is left out of the start. If a vehicle
/// drifts without a command and its mass is `known` beforehand, the drag that would end its motion
/// at once is reduced instead: the slopes of fixes have speeds that no vehicle has, and with 26
/// times the mass across, its Munk moment would turn it away within a second.
fn rough(mut model: Model, known: &Model, runs: &[Run], is_logged: impl Fn(&Dof) -> bool) -> Model {
    for dof in model.dofs.clone() {
        for drag in [id::LINEAR_DRAG, id::QUADRATIC_DRAG] {
            let index = model.at(drag, dof);
            if let Some(p) = index.map(|i| &mut model.parameters[i]).filter(|p| !p.fixed && !p.given && p.value < 0.0) {
                p.value = 0.0_f64.clamp(p.min, p.max);
            }
        }
        let Some(index) = model.inertia(dof) else { continue };
        if model.parameters[index].fixed || model.parameters[index].given {
            continue;
        }
        let (force, speed) = sizes(dof, runs);
        let at_once = if is_logged(&dof) { AT_ONCE } else { AT_ONCE_BY_SLOPES };
        let inertia = &mut model.parameters[index];
        if !(inertia.value.is_finite() && inertia.value > 0.0) {
            inertia.value = quick(force, speed);
        }
        if !is_commanded(runs, dof) {
            let (most, all) = (inertia.value / at_once, [id::LINEAR_DRAG, id::QUADRATIC_DRAG, id::MIXED_DRAG]);
            let has_mass = !dof.is_rotation() && known.value_at(id::INERTIA, dof).is_some_and(|m| m > 0.0);
            slowed(&mut model, dof, runs, most, if has_mass { &all } else { &all[2..] });
        }
        let drag: f64 = drags(&model, dof, &[id::LINEAR_DRAG, id::QUADRATIC_DRAG]).map(|p| slope(p, runs)).sum();
        let restoring = id::restoring(dof).and_then(|id| model.value(&id)).unwrap_or(0.0);
        let least = (drag * at_once).max(restoring * at_once * at_once);
        let inertia = &mut model.parameters[index];
        inertia.value = inertia.value.max(least).clamp(inertia.min, inertia.max);
    }
    model
}

/// The parameters of the drags `ids` in a degree of freedom.
fn drags<'a>(model: &'a Model, dof: Dof, ids: &'a [&str]) -> impl Iterator<Item = &'a Parameter> {
    model.parameters.iter().filter(move |p| ids.contains(&p.effect.as_str()) && p.place.dof == Some(dof))
}

/// ∂X/∂ν of a drag at the greatest speeds of the runs, kg/s or kg·m²/s.
fn slope(drag: &Parameter, runs: &[Run]) -> f64 {
    let speed = |dof: Option<Dof>| dof.map_or(0.0, |dof| greatest(runs, dof.velocity()));
    match drag.effect.as_str() {
        id::QUADRATIC_DRAG => 2.0 * drag.value * speed(drag.place.dof),
        id::MIXED_DRAG => drag.value * speed(drag.place.other),
        _ => drag.value,
    }
}

/// Reduces those of the drags `ids` in a degree of freedom for which a start is to be found, so
/// that their slopes are no more than `most` together.
fn slowed(model: &mut Model, dof: Dof, runs: &[Run], most: f64, ids: &[&str]) {
    let all: f64 = drags(model, dof, ids).filter(|p| is_begun(p)).map(|p| slope(p, runs).max(0.0)).sum();
    if all > most {
        let of = |p: &&mut Parameter| ids.contains(&p.effect.as_str()) && p.place.dof == Some(dof) && is_begun(p);
        for p in model.parameters.iter_mut().filter(of) {
            p.value = (p.value * most / all).clamp(p.min, p.max);
        }
    }
}

/// Greatest force and speed of the runs, N and m/s (N·m and rad/s); a force that is only rounding
/// of the thrust allocation counts as zero.
fn sizes(dof: Dof, runs: &[Run]) -> (f64, f64) {
    let force = if is_commanded(runs, dof) { greatest(runs, dof.force()) } else { 0.0 };
    (force, greatest(runs, dof.velocity()))
}

/// An inertia with which the greatest force reaches a tenth of the greatest speed in a second.
fn quick(force: f64, speed: f64) -> f64 {
    if force > 0.0 && speed > 0.0 { force / (0.1 * speed) } else { 1.0 }
}

/// Returns `model` with values under which nothing diverges: inertias of the right size, drag that
/// balances the greatest force at the greatest speed, fins as they are, nothing else. For use if a
/// regression on a model that lacks much has led to values that no vehicle has.
pub fn tame(model: &Model, runs: &[Run]) -> Model {
    let runs: &[Run] = &with_velocities(model, runs).0;
    let mut tame = model.clone();
    // fins stay as they are: without them nothing would act where no command does, and the inertia
    // there would not show
    let fins: Vec<usize> = tame.terms.iter().filter(|t| is_fin(t)).flat_map(|t| t.parameters.clone()).collect();
    for (_, p) in tame.parameters.iter_mut().enumerate().filter(|(k, p)| !fins.contains(k) && is_begun(p)) {
        let sizes = p.place.dof.map(|dof| sizes(dof, runs));
        p.per_run.fill(p.spec.neutral);
        p.value = match (p.effect.as_str(), sizes) {
            (id::INERTIA, Some((force, speed))) => quick(force, speed),
            (id::LINEAR_DRAG, Some((force, speed))) if speed > 0.0 => 0.5 * force / speed,
            (id::QUADRATIC_DRAG, Some((force, speed))) if speed > 0.0 => 0.5 * force / (speed * speed),
            _ => p.spec.neutral,
        }
        .clamp(p.min, p.max);
    }
    as_heavy_as_driven(&mut tame, runs);
    tame
}

/// Whether a starting value is to be found for a parameter.
fn is_begun(parameter: &Parameter) -> bool {
    !parameter.fixed && !parameter.given && parameter.spec.is_linear()
}

/// Gives translations without a command the greatest inertia of those with one: a vehicle whose
/// masses ahead and across differ turns by its Munk moment, and without drag it would turn ever
/// faster.
fn as_heavy_as_driven(model: &mut Model, runs: &[Run]) {
    let translations = model.dofs.iter().copied().filter(|dof| !dof.is_rotation());
    let (driven, drifting): (Vec<Dof>, Vec<Dof>) = translations.partition(|dof| is_commanded(runs, *dof));
    let heaviest = driven.iter().filter_map(|dof| model.value_at(id::INERTIA, *dof)).max_by(f64::total_cmp);
    let Some(heaviest) = heaviest else { return };
    for index in drifting.into_iter().filter_map(|dof| model.inertia(dof)).collect::<Vec<_>>() {
        let inertia = &mut model.parameters[index];
        if !inertia.fixed && !inertia.given {
            inertia.value = heaviest.clamp(inertia.min, inertia.max);
        }
    }
}

/// Returns `model` with its free inertias bounded by ten times what the thrust of a run can have
/// moved, ∫ |τ| dt / max |ν|. The translations are taken together, because turning exchanges their
/// momenta. A model that lacks what moves the vehicle would otherwise explain the motion by a mass
/// without limit, under which nothing that acts on it can be determined.
pub fn moved_by_thrust(model: &Model, runs: &[Run]) -> Model {
    /// Factor for what may act beside the thrust: a current, weight, a moment of the water.
    const MARGIN: f64 = 10.0;
    let runs: &[Run] = &with_velocities(model, runs).0;
    let mut bounded = model.clone();
    for dof in &model.dofs {
        let alike = || Dof::ALL.into_iter().filter(|other| other.is_rotation() == dof.is_rotation());
        let most = |run: &Run| {
            let impulse: f64 = alike().filter_map(|other| run.signal(other.force())).map(impulse).sum();
            let fastest = greatest(std::slice::from_ref(run), dof.velocity());
            (impulse > 0.0 && fastest > 0.0).then(|| MARGIN * impulse / fastest)
        };
        let Some(most) = runs.iter().filter_map(most).max_by(f64::total_cmp) else { continue };
        let Some(index) = model.inertia(*dof) else { continue };
        let inertia = &mut bounded.parameters[index];
        if !inertia.fixed && !inertia.given && inertia.value < most {
            inertia.max = inertia.max.min(most);
        }
    }
    bounded
}

/// ∫ |τ| dt, N·s and N·m·s.
fn impulse(force: &Signal) -> f64 {
    force.time().windows(2).zip(force.values()).map(|(t, tau)| (t[1] - t[0]) * tau.abs()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Coriolis;
    use crate::noise::Noise;

    /// A run of a second in which each of these channels goes from 0 to its greatest value.
    fn run_to(most: &[(&str, f64)]) -> Run {
        let time: std::sync::Arc<[f64]> = vec![0.0, 1.0].into();
        let signal = |(name, most): &(&str, f64)| (name.to_string(), Signal::new(time.clone(), vec![0.0, *most]));
        Run { signals: most.iter().map(signal).collect(), ..Run::default() }
    }

    /// Two thrusters exchanged: 20 N in sway move the vehicle; the yaw moment is only rounding,
    /// from which no inertia is made.
    #[test]
    fn nothing_of_a_tame_vehicle_is_made_of_rounding() {
        let run = run_to(&[("tau_v", 20.0), ("tau_r", 3e-17), ("v", 0.8), ("r", 1.2)]);
        let effects = ["inertia", "linear_drag", "quadratic_drag"];
        let tame = tame(&Model::with_effects(&[Dof::Sway, Dof::Yaw], Coriolis::Tied, &effects).unwrap(), &[run]);
        let value = |id: &str, dof: Dof| tame.value_at(id, dof).unwrap();
        // force over a tenth of the speed, to rounding
        assert!((value(id::INERTIA, Dof::Sway) - 250.0).abs() < 1e-9);
        assert_eq!([id::INERTIA, id::LINEAR_DRAG, id::QUADRATIC_DRAG].map(|id| value(id, Dof::Yaw)), [1.0, 0.0, 0.0]);
        assert_eq!(value(id::LINEAR_DRAG, Dof::Sway), 12.5);
    }

    /// Slopes of fixes have a speed of 3 m/s across: the drag there is reduced to what half a
    /// second allows for the mass, which stays. The mixed drag is reduced in the same way, for a
    /// moment of inertia of 2 at 1.5 m/s: 2/(0.5·1.5).
    #[test]
    fn what_drifts_keeps_its_mass() {
        let run = run_to(&[("tau_u", 40.0), ("u", 1.5), ("v", 3.0), ("r", 0.2)]);
        let effects = ["inertia", "quadratic_drag@sway", "mixed_drag@yaw:surge"];
        let mut model =
            Model::with_effects(&[Dof::Surge, Dof::Sway, Dof::Yaw], Coriolis::Tied, &effects).expect("known effects");
        let regressed = [("inertia@surge", 30.0), ("inertia@sway", 30.0), ("inertia@yaw", 2.0)];
        for (name, value) in
            regressed.into_iter().chain([("quadratic_drag@sway", 268.0), ("mixed_drag@yaw:surge", 180.0)])
        {
            model.set(name, value);
        }
        let value = |model: &Model, name: &str| model.parameters[model.parameter_of(name).expect("it is there")].value;
        let start = rough(model.clone(), &model, std::slice::from_ref(&run), |_| false);
        assert_eq!(regressed.map(|(name, _)| value(&start, name)), [30.0, 30.0, 2.0]);
        assert!((value(&start, "quadratic_drag@sway") - 30.0 / (0.5 * 2.0 * 3.0)).abs() < 1e-12);
        assert!((value(&start, "mixed_drag@yaw:surge") - 2.0 / (0.5 * 1.5)).abs() < 1e-12);
        // without a known mass, the inertia is raised as in a commanded degree of freedom
        let mut unknown = model.clone();
        unknown.set("inertia@sway", 0.0);
        let start = rough(model, &unknown, &[run], |_| false);
        assert!((value(&start, "inertia@sway") - 0.5 * 2.0 * 3.0 * 268.0).abs() < 1e-9);
    }

    /// A propeller's 20 N and a fin: the sway, which no command drives, is as heavy as the surge,
    /// and no Munk moment remains.
    #[test]
    fn a_tame_vehicle_has_no_munk_moment_where_it_drifts() {
        let run = run_to(&[("tau_u", 20.0), ("u", 0.8), ("v", 0.3), ("r", 0.2)]);
        let effects = ["inertia", "quadratic_drag", "coriolis_yaw"];
        let mut model =
            Model::with_effects(&[Dof::Surge, Dof::Sway, Dof::Yaw], Coriolis::Tied, &effects).expect("known effects");
        model.set("inertia@sway", 800.0);
        let tame = tame(&model, std::slice::from_ref(&run));
        let inertia = |dof: Dof| tame.value_at(id::INERTIA, dof).expect("it has one");
        assert!((inertia(Dof::Surge) - 250.0).abs() < 1e-9);
        assert_eq!([Dof::Sway, Dof::Yaw].map(inertia), [inertia(Dof::Surge), 1.0]);
        // an inertia that was given stays
        let index = model.parameter_of("inertia@sway").expect("it has one");
        model.parameters[index].given = true;
        assert_eq!(super::tame(&model, &[run]).value_at(id::INERTIA, Dof::Sway), Some(800.0));
    }

    /// A boat of 46 kg driven by steps of 20 N and observed by fixes of 0.5 m at 2 Hz: a known mass
    /// stays; an unknown one gets the right size; the drag is regressed.
    #[test]
    fn noisy_fixes_leave_the_mass_as_it_is_known() {
        let mut noise = Noise::new(6, 1);
        let (mut u, mut x, h) = (0.0, 0.0, 0.1);
        let (mut run, mut fixes) = (Run::default(), Vec::new());
        let time: Vec<f64> = (0..800).map(|k| h * f64::from(k)).collect();
        let tau: Vec<f64> = time.iter().map(|t| if (t / 16.0).floor() % 2.0 < 1.0 { 20.0 } else { 4.0 }).collect();
        for (k, (t, tau)) in time.iter().zip(&tau).enumerate() {
            if k % 5 == 0 {
                fixes.push((*t, x + 0.5 * noise.normal()));
            }
            u += h * (tau - 20.0 * u) / 46.0;
            x += h * u;
        }
        let (t, x): (Vec<f64>, Vec<f64>) = fixes.into_iter().unzip();
        run.signals.insert("x".into(), Signal::new(t.into(), x));
        run.signals.insert("tau_u".into(), Signal::new(time.into(), tau));
        let mut model = Model::with_effects(&[Dof::Surge], Coriolis::Tied, &["inertia", "linear_drag"]).unwrap();
        let value = |model: &Model, id: &str| model.value_at(id, Dof::Surge).unwrap();
        let (unknown, index) = (started(&model, std::slice::from_ref(&run)), model.inertia(Dof::Surge).unwrap());
        assert!((20.0..200.0).contains(&value(&unknown, id::INERTIA)), "{}", value(&unknown, id::INERTIA));
        model.parameters[index].value = 38.0;
        let known = started(&model, &[run]);
        assert_eq!(value(&known, id::INERTIA), 38.0);
        assert!((10.0..40.0).contains(&value(&known, id::LINEAR_DRAG)), "{}", value(&known, id::LINEAR_DRAG));
    }

    /// Roll of 0.5 rad/s against a drag of 2 + 2·0.5·4 N·m·s: the inertia is raised to 6·0.05
    /// kg·m².
    #[test]
    fn an_inertia_at_which_motion_ends_at_once_is_raised() {
        let mut model =
            Model::with_effects(&[Dof::Roll], Coriolis::Tied, &["inertia", "linear_drag", "quadratic_drag"]).unwrap();
        let mut run = Run::default();
        run.signals.insert("p".into(), Signal::new(vec![0.0, 1.0].into(), vec![0.0, 0.5]));
        for (name, value) in [("inertia@roll", 1e-3), ("linear_drag@roll", 2.0), ("quadratic_drag@roll", 4.0)] {
            model.set(name, value);
        }
        let inertia = |model: &Model| model.parameters[model.parameter_of("inertia@roll").unwrap()].value;
        let raised = rough(model.clone(), &model, std::slice::from_ref(&run), |_| true);
        assert!((inertia(&raised) - 0.3).abs() < 1e-12, "{}", inertia(&raised));
        let by_slopes = rough(model.clone(), &model, std::slice::from_ref(&run), |_| false);
        assert!((inertia(&by_slopes) - 3.0).abs() < 1e-12, "{}", inertia(&by_slopes));
        let index = model.parameter_of("inertia@roll").unwrap();
        model.parameters[index].given = true;
        assert_eq!(inertia(&started(&model, std::slice::from_ref(&run))), 1e-3, "a start that is given is a start");
        model.parameters[index].given = false;
        model.set("inertia@roll", 5.0);
        assert_eq!(inertia(&rough(model.clone(), &model, &[run], |_| true)), 5.0);
    }
}
