//! The choice of the dives that validate, as long as the user has made none.
//!
//! Of three dives and more every third validates if others move the same degrees of freedom and
//! cover its range. A run that alone goes astern or at full speed belongs to the fit: held out, it
//! would test the model outside the range of the fit.

use std::collections::BTreeSet;

use crate::check::motion::{self, Moved};
use crate::envelope;
use crate::frame::Dof;
use crate::run::Run;

/// One dive in this many validates.
const SHARE: usize = 3;

/// Whether each of `dives` validates; `dofs`: degrees of freedom of the model.
pub(super) fn validating(dives: &[Run], dofs: &[Dof]) -> Vec<bool> {
    let moves = |dive: &Run| -> BTreeSet<Dof> {
        dofs.iter().copied().filter(|dof| motion::of(&dive.signals, *dof) == Moved::Moves).collect()
    };
    let moved: Vec<BTreeSet<Dof>> = dives.iter().map(moves).collect();
    let moved_elsewhere = |k: usize, others: &[usize]| {
        let covered: BTreeSet<Dof> = others.iter().flat_map(|o| moved[*o].iter().copied()).collect();
        !moved[k].is_empty() && moved[k].is_subset(&covered)
    };
    let names = channels(dives);
    let is_within = |k: usize, others: &[usize]| {
        let range = envelope::of_channels(others.iter().map(|o| &dives[*o]), &names);
        envelope::beyond(&dives[k], &range).is_empty()
    };
    let strict = chosen(dives.len(), |k, others| moved_elsewhere(k, others) && is_within(k, others));
    // each run may have its own speed: a run that goes a little further is then a better test than
    // none
    if strict.contains(&true) { strict } else { chosen(dives.len(), moved_elsewhere) }
}

/// Up to a third of `count` dives that the remaining ones can spare by `can`: every third first,
/// then any.
fn chosen(count: usize, can: impl Fn(usize, &[usize]) -> bool) -> Vec<bool> {
    let mut validates = vec![false; count];
    for k in (SHARE - 1..count).step_by(SHARE).chain(0..count) {
        let others: Vec<usize> = (0..count).filter(|o| *o != k && !validates[*o]).collect();
        let one_more = validates.iter().filter(|v| **v).count() + 1;
        validates[k] |= one_more * SHARE <= count && can(k, &others);
    }
    validates
}

/// Channels that define the range of a run: velocities, and commands by force or by thruster.
fn channels(dives: &[Run]) -> BTreeSet<String> {
    let of_thruster = |name: &&String| {
        let number = name.strip_prefix(['V', 'F']).unwrap_or_default();
        !number.is_empty() && number.bytes().all(|b| b.is_ascii_digit())
    };
    let thrusters = dives.iter().flat_map(|dive| dive.signals.keys()).filter(of_thruster).cloned();
    let of_dof = Dof::ALL.into_iter().flat_map(|dof| [dof.velocity().to_string(), dof.force().to_string()]);
    of_dof.chain(thrusters).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::Signal;

    /// A dive of 60 s at 10 Hz in which the command swings between the two values, and the speed with it.
    fn dive(low: f64, high: f64) -> Run {
        let time: Vec<f64> = (0..600).map(|k| 0.1 * f64::from(k)).collect();
        let command: Vec<f64> =
            time.iter().map(|t| 0.5 * (low + high) + 0.5 * (high - low) * (0.3 * t).sin()).collect();
        let speed: Vec<f64> =
            command.iter().enumerate().map(|(k, c)| 0.5 * c + 0.001 * f64::from(k as u32 % 7)).collect();
        let mut run = Run::default();
        run.signals.insert("V1".into(), Signal::new(time.clone().into(), command));
        run.signals.insert("u".into(), Signal::new(time.into(), speed));
        run
    }

    #[test]
    fn the_only_run_that_goes_astern_takes_part() {
        let ahead = || dive(0.1, 0.8);
        let of = |dives: &[Run]| validating(dives, &[Dof::Surge]);
        assert_eq!(of(&[ahead(), ahead(), ahead()]), [false, false, true]);
        assert_eq!(of(&[ahead(), ahead(), dive(-0.8, 0.5)]), [true, false, false]);
        assert_eq!(of(&[ahead(), ahead()]), [false, false]);
    }

    #[test]
    fn a_run_between_the_others_validates() {
        let dives = [dive(-0.2, 0.9), dive(-0.5, 0.5), dive(-0.9, 0.2)];
        assert_eq!(validating(&dives, &[Dof::Surge]), [false, true, false]);
    }

    #[test]
    fn where_every_run_goes_further_than_the_others_one_validates_all_the_same() {
        let beside = |mut run: Run, share: f64| {
            let second: Vec<f64> = run.signals["V1"].values().iter().map(|c| share * c).collect();
            let time: Vec<f64> = (0..600).map(|k| 0.1 * f64::from(k)).collect();
            run.signals.insert("V2".into(), Signal::new(time.into(), second));
            run
        };
        let dives = [beside(dive(0.1, 0.9), 0.1), beside(dive(-0.9, -0.1), 0.1), beside(dive(-0.2, 0.2), 3.0)];
        assert_eq!(validating(&dives, &[Dof::Surge]), [false, false, true]);
    }
}
