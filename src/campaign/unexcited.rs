//! Degrees of freedom of a model that no run of a fit drives or moves.
//!
//! ```text
//! at rest:  no command of d   and   rms ν_d ≤ 1.5 σ(ν_d)   in every run, with a free parameter of d
//! ```
//!
//! σ is the larger of the noise that the third differences of the samples show ([`Samples::noise`])
//! and the noise stated in `[noise]`. Inertia and drag of such a degree of freedom would be
//! estimated from noise. Slow motion, coloured noise and a bias all lie above 1.5 σ: only what is
//! surely at rest is refused.

use std::collections::{BTreeMap, BTreeSet};

use super::codes;
use super::error::Error;
use super::load::Campaign;
use crate::check::codes::AT_REST;
use crate::check::motion;
use crate::check::samples::Samples;
use crate::finding::Finding;
use crate::frame::Dof;
use crate::model::Model;
use crate::run::{Role, Run, greatest, is_commanded, rounding_of};

/// Largest root mean square of a velocity at rest, in units of its noise.
const STILL: f64 = 1.5;

/// Refuses a fit of degrees of freedom that are at rest in all its runs, unless all are.
///
/// # Errors
/// [`Error::Refused`] with the `dofs` to write instead, and the held-out runs that would show them.
pub(super) fn refuse(campaign: &Campaign, runs: &[Run]) -> Result<(), Error> {
    let seen = Seen::of(campaign, runs);
    seen.refuse(&campaign.model).map_err(|error| match error {
        Error::Refused { mut findings } => {
            let shown = shown_by(campaign, &seen.resting(&campaign.model));
            findings.iter_mut().filter(|_| !shown.is_empty()).for_each(|finding| finding.message += &advice(&shown));
            Error::Refused { findings }
        }
        error => error,
    })
}

/// Returns the held-out runs that take part in a search because no run of the fit moves what they
/// move: the first half of such runs, so that the others are left to judge. Returns also the
/// degrees of freedom that no run of the fit moves.
pub(super) fn taking_part(campaign: &Campaign) -> (Vec<String>, Vec<Dof>) {
    let seen = Seen::of(campaign, &campaign.motion(Some(Role::Train)));
    let resting = if seen.moved.is_empty() { Vec::new() } else { seen.resting(&campaign.model) };
    let shown = shown_by(campaign, &resting);
    (shown[..shown.len() / 2].to_vec(), resting)
}

/// Returns the held-out runs that move all of `dofs`.
fn shown_by(campaign: &Campaign, dofs: &[Dof]) -> Vec<String> {
    let moves_all = |run: &Run| {
        let seen = Seen::of(campaign, std::slice::from_ref(run));
        !dofs.is_empty() && dofs.iter().all(|dof| seen.moved.contains(dof))
    };
    campaign.motion(Some(Role::Validate)).into_iter().filter(moves_all).map(|run| run.name).collect()
}

/// Returns the advice if held-out runs move what no run of the fit moves.
fn advice(shown: &[String]) -> String {
    let (are, them) = if shown.len() > 1 { ("are", "one of them") } else { ("is", "it") };
    format!("; {}, which {are} held out, would show it: give {them} role = \"train\"", shown.join(", "))
}

/// What moves in runs that are read one after the other.
#[derive(Debug, Default)]
pub(super) struct Seen {
    moved: BTreeSet<Dof>,
    /// Greatest force or moment that was commanded, N or N·m.
    commanded: BTreeMap<Dof, f64>,
}

impl Seen {
    /// Returns what moves in these runs.
    fn of(campaign: &Campaign, runs: &[Run]) -> Seen {
        let mut seen = Seen::default();
        runs.iter().for_each(|run| seen.look(campaign, run));
        seen
    }

    /// Returns the degrees of freedom that nothing moves and that have something to estimate.
    fn resting(&self, model: &Model) -> Vec<Dof> {
        let rests = |dof: &&Dof| !self.moved.contains(*dof) && is_free(model, **dof);
        model.dofs.iter().filter(rests).copied().collect()
    }

    /// Adds what moves in a run, or in a piece of one.
    pub fn look(&mut self, campaign: &Campaign, run: &Run) {
        let stated = |channel: &str| campaign.file.noise.sensors.get(channel).copied();
        for dof in &campaign.model.dofs {
            if !self.moved.contains(dof) && !rests(run, *dof, &stated) {
                self.moved.insert(*dof);
            }
        }
        for dof in Dof::ALL {
            let most = self.commanded.entry(dof).or_default();
            *most = most.max(greatest(std::slice::from_ref(run), dof.force()));
        }
    }

    /// Returns the modelled degrees of freedom in which nothing was commanded beyond rounding.
    pub fn uncommanded(&self, model: &Model) -> Vec<Dof> {
        let rounding = rounding_of(self.commanded.values().copied());
        let none = |dof: &Dof| self.commanded.get(dof).is_none_or(|most| *most <= rounding);
        model.dofs.iter().copied().filter(none).collect()
    }

    /// As [`refuse`], for all runs that were added.
    ///
    /// # Errors
    /// [`Error::Refused`] with the `dofs` to write instead.
    pub fn refuse(&self, model: &Model) -> Result<(), Error> {
        let resting = self.resting(model);
        if resting.is_empty() || self.moved.is_empty() {
            return Ok(());
        }
        let kept: Vec<Dof> = model.dofs.iter().filter(|dof| !resting.contains(dof)).copied().collect();
        Err(Error::Refused { findings: vec![Finding::new(&codes::NOT_EXCITED, told(&resting, &kept))] })
    }
}

/// Returns the finding that nothing moves in any of the runs, if it is so.
pub(super) fn at_rest(runs: &[Run]) -> Option<Finding> {
    let rests = !runs.is_empty() && runs.iter().all(|run| !motion::judge(run).is_empty());
    let names: Vec<&str> = runs.iter().map(|run| run.name.as_str()).collect();
    let text = format!(
        "nothing moves beyond the noise of its sensor in {}: there is nothing to learn from such runs; add one in which the \
         vehicle moves",
        names.join(", ")
    );
    rests.then(|| Finding::new(&AT_REST, text))
}

/// Describes what is wrong, and the line to write.
fn told(resting: &[Dof], kept: &[Dof]) -> String {
    let names: Vec<&str> = resting.iter().map(|dof| dof.name()).collect();
    let line: Vec<String> = kept.iter().map(|dof| format!("{:?}", dof.name())).collect();
    format!(
        "{}: in no run of the fit is there a command or a motion beyond the noise, so inertia and drag cannot be \
         estimated; write dofs = [{}] in [model], or add a run that moves it",
        names.join(", "),
        line.join(", ")
    )
}

/// Whether a free parameter belongs to the balance of this degree of freedom alone.
fn is_free(model: &Model, dof: Dof) -> bool {
    model.parameters.iter().any(|p| !p.fixed && p.prior.is_none() && p.place.dof == Some(dof))
}

/// Whether a run has neither a command nor motion in a degree of freedom whose velocity it logs.
fn rests(run: &Run, dof: Dof, stated: &dyn Fn(&str) -> Option<f64>) -> bool {
    let Some(velocity) = run.signal(dof.velocity()).filter(|s| !s.is_empty()) else { return false };
    let rms = (velocity.values().iter().map(|x| x * x).sum::<f64>() / velocity.len() as f64).sqrt();
    let seen = Samples::of(velocity).map_or(0.0, |samples| samples.noise());
    let noise = stated(dof.velocity()).map_or(seen, |stated| stated.max(seen));
    !is_commanded(std::slice::from_ref(run), dof) && rms <= STILL * noise
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::Noise;
    use crate::run::Signal;

    #[test]
    fn runs_without_motion_have_nothing_to_learn() {
        let run = |rate: f64| {
            let time: std::sync::Arc<[f64]> = (0..600).map(|k| 0.1 * f64::from(k)).collect();
            let psi: Vec<f64> = time.iter().map(|t| rate * t).collect();
            Run { name: "dive.csv".into(), signals: [("psi".into(), Signal::new(time, psi))].into(), ..Run::default() }
        };
        let told = at_rest(&[run(0.0), run(0.0)]).map(|finding| finding.message);
        assert!(told.as_deref().is_some_and(|text| text.contains("in dive.csv, dive.csv: ")), "{told:?}");
        assert!(at_rest(&[run(0.0), run(0.1)]).is_none() && at_rest(&[]).is_none());
    }

    #[test]
    fn noise_is_rest_and_slow_motion_is_not() {
        let mut draw = Noise::new(1, 0);
        let time: std::sync::Arc<[f64]> = (0..400).map(|k| 0.1 * f64::from(k)).collect();
        let noise: Vec<f64> = time.iter().map(|_| 0.01 * draw.normal()).collect();
        let slow: Vec<f64> = time.iter().zip(&noise).map(|(t, n)| n + 0.03 * (0.2 * t).sin()).collect();
        let run = |v: Vec<f64>, tau: f64| {
            let mut run = Run::default();
            for (name, values) in [("v", v), ("tau_v", vec![tau; 400]), ("tau_u", vec![10.0; 400])] {
                run.signals.insert(name.into(), Signal::new(time.clone(), values));
            }
            run
        };
        let none = |_: &str| None;
        assert!(rests(&run(noise.clone(), 0.0), Dof::Sway, &none));
        assert!(rests(&run(vec![0.0; 400], 1e-12), Dof::Sway, &none));
        assert!(!rests(&run(noise, 1.0), Dof::Sway, &none));
        assert!(!rests(&run(slow.clone(), 0.0), Dof::Sway, &none));
        assert!(rests(&run(slow.clone(), 0.0), Dof::Sway, &|_| Some(0.05)));
        assert!(!rests(&run(slow, 0.0), Dof::Yaw, &none), "what is not logged is not judged");
    }
}
