//! Envelope of a model: the ranges of values that its runs covered.
//!
//! ```text
//! envelope = { channel: [smallest, greatest] }      u … r, phi, theta, tau_u … tau_r, KC_u … KC_r
//! KC = U_m T / L_c
//! ```
//!
//! Speeds and rates (m/s, rad/s), roll and pitch (rad), effective forces (N, N·m) and
//! Keulegan-Carpenter numbers of the runs of a fit. Outside these ranges the model extrapolates,
//! and [`beyond`] warns the user.

use std::collections::{BTreeMap, BTreeSet};

use crate::effects::channel;
use crate::finding::{Code, Finding, Severity};
use crate::frame::Dof;
use crate::run::Run;

/// Smallest and greatest value of each channel, SI.
pub type Envelope = BTreeMap<String, [f64; 2]>;

/// A run beyond the envelope of a model.
pub const OUT_OF_ENVELOPE: Code = Code {
    code: "E101",
    kind: "out-of-envelope",
    severity: Severity::Warning,
    meaning: "A run goes beyond the speeds, angles or forces at which the model was fitted: there it extrapolates.",
};

/// A run at an amplitude far from those of the fit.
pub const OTHER_AMPLITUDE: Code = Code {
    code: "E102",
    kind: "other-amplitude",
    severity: Severity::Warning,
    meaning: "A run oscillates at a Keulegan-Carpenter number far from those at which the model was fitted. Added mass and drag of bluff bodies change several-fold with it: fit runs of that amplitude, or a model with added_mass_amplitude.",
};

/// All codes of this module, for `hydrosysid explain`.
pub const ALL: &[Code] = &[OUT_OF_ENVELOPE, OTHER_AMPLITUDE];

/// Share of its width, or of its greatest absolute value, by which a run may leave the envelope
/// before a finding.
const MARGIN: f64 = 0.1;

/// Ratio by which a Keulegan-Carpenter number may lie outside before a finding. In table 5 of Avila
/// et al. (2013) C_m doubles over a ratio of about 5 in KC.
pub const KC_RATIO: f64 = 2.0;

/// Channels of an envelope, of all degrees of freedom.
fn channels() -> impl Iterator<Item = String> {
    let speeds = Dof::ALL.map(|dof| dof.velocity().to_string());
    let angles = [Dof::Roll, Dof::Pitch].map(|dof| dof.position().to_string());
    let forces = Dof::ALL.map(|dof| dof.force().to_string());
    speeds.into_iter().chain(angles).chain(forces).chain(Dof::ALL.map(channel::keulegan_carpenter))
}

/// Returns the envelope of these runs.
pub fn of<'a>(runs: impl IntoIterator<Item = &'a Run>) -> Envelope {
    of_channels(runs, &channels().collect())
}

/// Returns the envelope of these runs in the channels `names`.
pub(crate) fn of_channels<'a>(runs: impl IntoIterator<Item = &'a Run>, names: &BTreeSet<String>) -> Envelope {
    let mut seen = Envelope::new();
    for run in runs {
        for name in names {
            let Some((first, rest)) = run.signal(name).and_then(|s| s.values().split_first()) else { continue };
            let range = seen.entry(name.clone()).or_insert([*first; 2]);
            *range = std::iter::once(first).chain(rest).fold(*range, |[low, high], x| [low.min(*x), high.max(*x)]);
        }
    }
    seen
}

/// Findings where a run goes beyond an envelope.
pub fn beyond(run: &Run, envelope: &Envelope) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (name, [low, high]) in envelope {
        let values = run.signal(name).map_or(&[][..], |s| s.values());
        if let Some(dof) = Dof::ALL.into_iter().find(|dof| channel::keulegan_carpenter(*dof) == *name) {
            findings.extend(amplitude(run, dof, values, *low, *high));
            continue;
        }
        let margin = MARGIN * (high - low).max(low.abs().max(high.abs()));
        let out = values.iter().filter(|x| **x < low - margin || **x > high + margin).count();
        if out * 100 > values.len() {
            let text = format!(
                "run `{}`: {name} goes beyond the {low:.3} to {high:.3} of the fit in {:.0} % of its samples: the model extrapolates there",
                run.name,
                100.0 * out as f64 / values.len() as f64
            );
            findings.push(Finding::new(&OUT_OF_ENVELOPE, text).of_run(&run.name));
        }
    }
    findings
}

/// Finding for a run that oscillates at another amplitude than the runs of the fit; `None` if it
/// does not oscillate.
fn amplitude(run: &Run, dof: Dof, values: &[f64], low: f64, high: f64) -> Option<Finding> {
    let number = values.first().copied().filter(|kc| *kc > 0.0 && high > 0.0)?;
    // a run of the fit that does not oscillate has KC = 0
    let far = number > high * KC_RATIO || (low > 0.0 && number < low / KC_RATIO);
    far.then(|| {
        let text = format!(
            "run `{}`: KC in {dof} is {number:.2}, the runs of the fit have {low:.2} to {high:.2}: added mass and drag may be other there",
            run.name
        );
        Finding::new(&OTHER_AMPLITUDE, text).of_run(&run.name)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::Signal;

    fn run(name: &str, values: &[(&str, &[f64])]) -> Run {
        let mut run = Run { name: name.into(), ..Run::default() };
        for (channel, x) in values {
            let time: Vec<f64> = (0..x.len()).map(|k| k as f64).collect();
            run.signals.insert((*channel).into(), Signal::new(time.into(), x.to_vec()));
        }
        run
    }

    #[test]
    fn speeds_angles_forces_and_amplitudes_beyond_are_said() {
        let first =
            run("a", &[("u", &[-0.2, 0.5]), ("theta", &[0.0, 0.1]), ("tau_u", &[-50.0, 60.0]), ("KC_u", &[2.0])]);
        let second = run("b", &[("u", &[0.6]), ("KC_u", &[5.0]), ("depth", &[3.0])]);
        let envelope = of([&first, &second]);
        assert_eq!(envelope["u"], [-0.2, 0.6]);
        assert_eq!(envelope["KC_u"], [2.0, 5.0]);
        assert!(!envelope.contains_key("depth"));
        assert!(beyond(&first, &envelope).is_empty() && beyond(&second, &envelope).is_empty());
        let kinds = |run: &Run| beyond(run, &envelope).iter().map(|f| f.code).collect::<Vec<_>>();
        assert_eq!(kinds(&run("fast", &[("u", &[0.9])])), ["E101"]);
        assert_eq!(kinds(&run("steep", &[("theta", &[0.4])])), ["E101"]);
        assert_eq!(kinds(&run("strong", &[("tau_u", &[-90.0])])), ["E101"]);
        assert_eq!(kinds(&run("wide", &[("KC_u", &[11.0])])), ["E102"]);
        assert_eq!(kinds(&run("small", &[("KC_u", &[0.5])])), ["E102"]);
        assert!(kinds(&run("steady", &[("KC_u", &[0.0])])).is_empty());
    }
}
