//! Step 5: a name needs physics.
//!
//! ```text
//! |θ̂ − neutral| > 3 s        of one parameter at least, or of all of them together:  χ²_k(θᵀ C⁻¹ θ) as improbable as 3 s is
//! min < θ̂ < max              dissipation dissipates, a delay is not negative
//! θ̂ > h/20                   of a time, h: the time between samples; |δ̂| t > h/20 of a rate of clocks, t: the longest run
//! s < ½ |θ̂|                  of a time constant, a limit or another shape that was searched over a grid
//! ```

use nalgebra::{DMatrix, DVector};

use super::candidate::Candidate;
use super::screen::log_survival;
use crate::effects::CommandDelay;
use crate::estimate::filter_error::FilterErrorFit;
use crate::model::{Interpolation, Model, Parameter};
use crate::units::Dimension;
use crate::wording::measured;

/// Standard deviations by which a parameter must differ from its value without the effect. At one per cent over all
/// candidates the likelihood ratio asks a lone parameter for more than three. If the parameter itself has fewer, its
/// size depends on something undetermined (the mass, the scale of all forces), and the effect gets no name.
pub(super) const BEYOND: f64 = 3.0;

/// Ratio of standard deviation to value from which a shape parameter counts as not determined.
const DETERMINED: f64 = 0.5;

/// Share of the sample time below which samples cannot show a delay or a lag: the errors of one integrator step and
/// of a clock are as large.
const RESOLVED: f64 = 0.05;

/// Share of the greatest wave amplitude below which a run counts as having no wave: a real wave is there in every run.
const FAINT: f64 = 0.2;

/// Rule that the parameters which `candidate` added to `before` break, in words; `None` if they break none.
pub(super) fn broken(before: &Model, fit: &FilterErrorFit, candidate: &Candidate) -> Option<String> {
    let tracks = fit.filtered.problem.tracks.iter();
    let longest = tracks.filter_map(|track| Some(track.time.last()? - track.time.first()?)).fold(0.0, f64::max);
    let clock = (fit.filtered.sample_time(), longest);
    rule(before, &fit.model, candidate, (clock, || are_together_something(before, fit)))
}

/// The same for a sample time and a longest run, s; `together`: whether the parameters are jointly significant.
fn rule(
    before: &Model,
    after: &Model,
    candidate: &Candidate,
    ((sample, longest), together): ((f64, f64), impl Fn() -> bool),
) -> Option<String> {
    let new = brought(before, after);
    if new.is_empty() {
        return None;
    }
    let grows =
        candidate.terms.iter().any(|(effect, _)| matches!(effect.delays_command(), Some(CommandDelay::Growing(_))));
    let told = |p: &Parameter| {
        format!("{} = {} {}", p.spec.name, measured(p.value, p.std.unwrap_or(f64::NAN)), p.spec.dimension)
    };
    for p in &new {
        let std = p.std.unwrap_or(f64::INFINITY);
        if p.value <= p.min || p.value >= p.max {
            return Some(format!("{} stands at its bound", told(p)));
        }
        if p.spec.dimension == Dimension::TIME && p.value < 0.0 {
            // with held input, a command that changes between two rows takes effect at the later one
            if after.input == Interpolation::Hold && -p.value < sample {
                return Some(format!(
                    "{} is negative, by less than a sample: commands that change between the logged rows look like \
                     this; log every change of the commands",
                    told(p)
                ));
            }
            return Some(format!("{} is negative: the effect would precede the commands that cause it", told(p)));
        }
        if p.spec.dimension == Dimension::TIME && p.value < RESOLVED * sample {
            return Some(format!("{} is less than a twentieth of a sample", told(p)));
        }
        if grows && p.value.abs() * longest < RESOLVED * sample {
            return Some(format!(
                "{} changes the time by less than a twentieth of a sample in the longest run",
                told(p)
            ));
        }
        let searched = candidate.probes.len() > 1 && !p.spec.is_linear();
        if searched && std > DETERMINED * p.value.abs() {
            return Some(format!("{} is not determined", told(p)));
        }
    }
    if is_nothing(before, after) && !together() {
        return Some(format!(
            "{} is within three standard errors of no effect",
            new.iter().map(|p| told(p)).collect::<Vec<_>>().join(", ")
        ));
    }
    // a wave has a period; a current with its own value in each run may be zero in some
    if candidate.grid().is_some() { faint(&new) } else { None }
}

/// Parameters that `after` has beyond those of `before`.
pub(super) fn brought<'a>(before: &Model, after: &'a Model) -> Vec<&'a Parameter> {
    after.parameters.iter().filter(|p| is_new(before, p)).collect()
}

pub(super) fn is_new(before: &Model, parameter: &Parameter) -> bool {
    before.parameters.iter().all(|p| p.term != parameter.term || p.spec.name != parameter.spec.name)
}

/// Whether a parameter is more than three standard deviations from its value without the effect, in some run if each
/// has its own.
pub(super) fn is_apart(p: &Parameter) -> bool {
    let values = if p.per_run.is_empty() { std::slice::from_ref(&p.value) } else { &p.per_run[..] };
    let std = p.std.unwrap_or(f64::INFINITY);
    values.iter().any(|v| (v - p.spec.neutral).abs() > BEYOND * std)
}

/// Whether all that `after` has beyond `before` is within three standard deviations of its value without the effect.
pub(super) fn is_nothing(before: &Model, after: &Model) -> bool {
    let new = brought(before, after);
    let apart = |p: &&Parameter| is_apart(p);
    // if there is a strength, an instant or a time constant alone proves nothing
    let strengths: Vec<&Parameter> = new.iter().copied().filter(|p| p.spec.is_linear()).collect();
    let judged = if strengths.is_empty() { &new } else { &strengths };
    !judged.is_empty() && !judged.iter().any(apart)
}

/// Whether the strengths that `fit` has beyond `before` are jointly significant, though each alone may not be: for
/// example the deviation of a compass and its constant part, of which runs without a position show only the sum.
fn are_together_something(before: &Model, fit: &FilterErrorFit) -> bool {
    let unknowns = &fit.filtered.problem.unknowns;
    let of = |k: usize| &fit.model.parameters[unknowns[k].parameter];
    let is_strength = |k: &usize| unknowns[*k].run.is_none() && of(*k).spec.is_linear() && is_new(before, of(*k));
    let at: Vec<usize> = (0..unknowns.len()).filter(is_strength).collect();
    if at.len() < 2 {
        return false;
    }
    let covariance = DMatrix::from_fn(at.len(), at.len(), |i, j| fit.covariance[at[i] * unknowns.len() + at[j]]);
    let off = DVector::from_fn(at.len(), |i, _| of(at[i]).value - of(at[i]).spec.neutral);
    let Some(factor) = covariance.cholesky() else { return false };
    log_survival(off.dot(&factor.solve(&off)), at.len()) < log_survival(BEYOND * BEYOND, 1)
}

/// Refuses a wave that is present in some runs only: it follows something else that comes and goes.
fn faint(new: &[&Parameter]) -> Option<String> {
    let parts: Vec<&[f64]> = new.iter().map(|p| p.per_run.as_slice()).filter(|v| !v.is_empty()).collect();
    let runs = parts.first()?.len();
    let amplitude = |run: usize| parts.iter().filter_map(|v| v.get(run)).map(|x| x * x).sum::<f64>().sqrt();
    let (least, most) =
        (0..runs).map(amplitude).fold((f64::INFINITY, 0.0), |(l, m), a| (f64::min(l, a), f64::max(m, a)));
    (least < FAINT * most).then(|| "it occurs in some runs only: it comes and goes".to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discover::candidates;
    use crate::effects::Coriolis;
    use crate::frame::Dof;

    fn told(name: &str, values: &[(f64, f64)]) -> Option<String> {
        told_of(Interpolation::Linear, name, values)
    }

    fn told_of(input: Interpolation, name: &str, values: &[(f64, f64)]) -> Option<String> {
        let mut before = Model::with_effects(&[Dof::Surge], Coriolis::Tied, &["inertia", "linear_drag"]).unwrap();
        before.input = input;
        let mut run = crate::run::Run::default();
        for channel in ["u", "tau_u", "theta"] {
            run.signals.insert(channel.into(), crate::run::Signal::new(vec![0.0, 1.0].into(), vec![0.0, 1.0]));
        }
        let candidate = candidates(&before, &[run], &[]).into_iter().find(|c| c.name() == name).unwrap();
        let mut after = before.clone();
        candidate.add_to(&mut after, &candidate.probes[0].clone()).unwrap();
        let new = after.parameters[before.parameters.len()..].iter_mut();
        for (p, (value, std)) in new.zip(values) {
            (p.value, p.std) = (*value, Some(*std));
        }
        rule(&before, &after, &candidate, ((0.1, 60.0), || false))
    }

    #[test]
    fn names_that_nature_does_not_allow_are_none() {
        assert_eq!(told("bias@surge", &[(3.5, 1.0)]), None);
        assert!(told("bias@surge", &[(2.5, 1.0)]).unwrap().contains("within three standard errors"));
        assert_eq!(told("thrust_delay", &[(0.3, 0.05)]), None);
        assert!(told("thrust_delay", &[(-0.3, 0.05)]).unwrap().contains("negative"));
        // negative by less than a sample, with held commands: they may change between their rows
        let held = |late: f64| told_of(Interpolation::Hold, "thrust_delay", &[(late, 0.001)]).unwrap();
        assert!(held(-0.05).contains("negative") && held(-0.05).contains("between the logged rows"));
        assert!(held(-0.3).contains("negative") && !held(-0.3).contains("rows"));
        assert!(told("thrust_delay", &[(0.0024, 0.0007)]).unwrap().contains("twentieth of a sample"));
        assert_eq!(told("sensor_clock_drift", &[(0.002, 0.0001)]), None);
        assert!(told("sensor_clock_drift", &[(0.00008, 0.00001)]).unwrap().contains("twentieth of a sample"));
        assert!(told("fluid_memory@surge", &[(9.0, 1.0), (59.0, 1166.0)]).unwrap().contains("not determined"));
        assert!(told("fluid_memory@surge", &[(0.0, 1.0), (5.0, 1.0)]).unwrap().contains("bound"));
        assert!(told("thruster_fault@surge", &[(-0.002, 0.0014), (22.7, 1.2)]).unwrap().contains("within three"));
        assert_eq!(told("thruster_fault@surge", &[(0.4, 0.01), (22.7, 1.2)]), None);
    }
}
