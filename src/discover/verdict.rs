//! Step 7: the verdict, and its sentence.
//!
//! The noise model itself is tested: the errors of predictions 2 and 8 s ahead must be as large as the filter
//! expects, and innovations must be white. If so, the residual is sensor noise and a random force. If not, something
//! is missing that has no name.

use serde::Serialize;

use super::held_out::NOT_SHOWN;
use super::searched::BehavesLike;
use super::{ChangedParameter, FoundEffect};
use crate::effects::named;
use crate::estimate::filter_error::{AHEAD, Channel, Forecast, RandomForce, Whiteness};
use crate::frame::{Dof, Measured};
use crate::wording::{digits, times};

/// The four possible answers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The baseline predicts the data down to the sensor noise and a random force.
    NothingMissing,
    /// With the added effects the model predicts the data as well as that.
    Explained,
    /// Effects were found, but something remains that no effect of the catalogue explains.
    PartlyExplained,
    /// Something is missing that no effect of the catalogue explains.
    Unexplained,
}

/// Channels in which the noise model fails the test, with the ratio of actual to expected prediction error; empty if it
/// passes. Predictions are those of the held-out runs, innovations those of the runs of the fit (`own`).
pub(super) fn failing(outputs: &[String], forecasts: &[Forecast], own: &[Forecast]) -> Vec<(String, f64)> {
    fn channels(of: &[Forecast], output: usize) -> impl Iterator<Item = &Channel> {
        of.iter().filter_map(move |f| f.channels.iter().find(|c| c.output == output))
    }
    let mut failing = Vec::new();
    for (output, name) in outputs.iter().enumerate() {
        let ahead = |seconds: f64| {
            let of =
                channels(forecasts, output).filter_map(|c| c.predictions.iter().find(|p| p.ahead == Some(seconds)));
            of.copied().reduce(|a, b| a.with(&b))
        };
        let asked = AHEAD.len() * outputs.len();
        let erring = AHEAD.into_iter().filter_map(ahead).filter(|p| p.errs(asked)).map(|p| p.ratio());
        let whiteness = channels(own, output).map(|c| c.whiteness.clone()).reduce(|a: Whiteness, b| a.with(&b));
        let coloured = whiteness.filter(|w| w.is_coloured(outputs.len()));
        if let Some(ratio) = erring.reduce(f64::max).or(coloured.map(|_| 1.0)) {
            failing.push((name.clone(), ratio));
        }
    }
    failing
}

/// Sentence for a search that can name nothing because of the random forces in `overwhelmed`.
pub(super) fn moved_otherwise(overwhelmed: &[(Dof, f64)]) -> String {
    let most = overwhelmed.iter().max_by(|a, b| a.1.total_cmp(&b.1));
    let most = most.map_or(String::new(), |(dof, ratio)| {
        format!(": in `{}` a random force is {} theirs", dof.velocity(), times(*ratio))
    });
    format!("Nothing can be named: the commands do not dominate the motion{most}.")
}

/// Returns the verdict.
pub(super) fn verdict(named: bool, passes: bool) -> Verdict {
    match (named, passes) {
        (false, true) => Verdict::NothingMissing,
        (true, true) => Verdict::Explained,
        (true, false) => Verdict::PartlyExplained,
        (false, false) => Verdict::Unexplained,
    }
}

/// Random forces in words: `0.8 N in surge (correlation 1.1 s)`.
fn force_in_words(forces: &[RandomForce]) -> String {
    let one = |f: &RandomForce| {
        let unit = if f.dof.is_rotation() { "N m" } else { "N" };
        format!("{} {unit} in {} (correlation {} s)", digits(f.rms), f.dof, digits(f.time))
    };
    forces.iter().map(one).collect::<Vec<_>>().join(", ")
}

/// ` This data does not tell the first name from …`; empty if no effect has an alternative.
pub(super) fn alike(effects: &[FoundEffect]) -> String {
    let of = |e: &FoundEffect| {
        let others: Vec<String> = e.also_possible.iter().map(|other| named(other)).collect();
        format!(" This data cannot separate {} from {}.", e.id, others.join(", "))
    };
    effects.iter().filter(|e| !e.also_possible.is_empty()).map(of).collect()
}

/// `` `run04`, `run05`, which took no part ``: the runs on which alone a model fails. Those in `beyond` exceed the
/// range of the runs of the fit. Empty if there are none.
pub(super) fn apart(beyond: &[&str], elsewhere: &[String]) -> String {
    let (others, run) = (elsewhere.join("`, `"), beyond.join("`, `"));
    match (beyond.len(), elsewhere.len()) {
        (0, 0) => String::new(),
        (0, _) => format!("`{others}`, which took no part"),
        (1, _) => format!("`{run}`, which goes beyond their range"),
        (_, _) => format!("`{run}`, which go beyond their range"),
    }
}

/// The verdict in plain words. `better`: the factor by which the names improve held-out predictions 8 s ahead, and in
/// which degree of freedom; `apart`: the runs on which alone the model fails ([`apart`]).
pub(super) fn sentence(
    verdict: Verdict,
    effects: &[FoundEffect],
    behaves_like: &[BehavesLike],
    forces: &[RandomForce],
    better: Option<(Measured, f64)>,
    (failing, apart): (&[(String, f64)], &str),
    changed: Option<&ChangedParameter>,
) -> String {
    let names: Vec<String> = effects.iter().map(FoundEffect::named).collect();
    let names = match names.split_last() {
        Some((last, before)) if !before.is_empty() => format!("{} and {last}", before.join(", ")),
        _ => names.concat(),
    };
    let (were, it) = if effects.len() > 1 { ("were", "them") } else { ("was", "it") };
    let gain = better.map_or(String::new(), |(measured, times)| {
        format!("; with {it} held-out {measured} is predicted {} times better 8 s ahead", digits(times))
    });
    let left = match forces {
        [] => "the sensors".to_string(),
        forces => format!("the sensors and a random force of {}", force_in_words(forces)),
    };
    let behaves = behaves_like.first().map_or(String::new(), |b| format!(" It {}.", b.told()));
    let channels: Vec<&str> = failing.iter().map(|(name, _)| name.as_str()).collect();
    let at = |word: &str| match channels[..] {
        [] => String::new(),
        _ => format!("{word} `{}`", channels.join("`, `")),
    };
    let changes = changed.map_or(String::new(), |s| format!(" {}", s.told()));
    let begun = changed.filter(|changed| changed.is_event()).map(ChangedParameter::event_in_words);
    let alike = alike(effects);
    // an effect that the runs of the fit show and the held-out runs cannot judge
    let unjudged = behaves_like.iter().find(|b| b.why == NOT_SHOWN).map(BehavesLike::told);
    // an effect beyond chance in the runs of the fit is always mentioned, whatever speaks against it
    let besides = unjudged.clone().or(behaves_like.first().map(BehavesLike::told));
    let besides = besides.map_or(String::new(), |told| format!(" In the runs of the fit something {told}."));
    match verdict {
        Verdict::NothingMissing => match forces {
            [] => format!("Nothing is missing: the model leaves only sensor noise.{besides}"),
            forces => format!(
                "Nothing is missing beyond a random force of {}: turbulence, tether, or unmeasured input.{besides}",
                force_in_words(forces)
            ),
        },
        Verdict::Explained if gain.is_empty() => {
            format!("Explained: {names} {were} missing; with {it} the model predicts the log down to {left}.{alike}")
        }
        Verdict::Explained => format!("Explained: {names} {were} missing{gain}, down to {left}.{alike}"),
        Verdict::PartlyExplained if !apart.is_empty() => format!(
            "Partly explained: {names} {were} missing{gain}; something is left that the runs of the fit do not show: it is in \
             {apart}{}.",
            at(", in")
        ),
        Verdict::Unexplained if !apart.is_empty() => format!(
            "Something is missing that the runs of the fit do not show: it is in {apart}{}.{behaves}",
            at(", in")
        ),
        Verdict::PartlyExplained if let Some(begun) = begun => {
            format!("Partly explained: {names} {were} missing{gain}; besides, something has changed: {begun}.{alike}")
        }
        Verdict::PartlyExplained => format!(
            "Partly explained: {names} {were} missing{gain}; something is left{} that no effect of the catalogue \
             explains.{changes}{alike}",
            at(" in")
        ),
        Verdict::Unexplained => match (unjudged, begun) {
            (_, Some(begun)) => {
                let left = match changed.is_some_and(|changed| changed.alone) {
                    true => "nothing else is significant after that",
                    false => "less than a tenth of that remains unexplained",
                };
                format!("Something has changed: {begun}; {left}.")
            }
            (Some(told), None) => format!("Something is missing{}. It {told}.{changes}", at("; it shows in")),
            (None, None) => {
                format!("Something is missing that is not in the catalogue{}.{changes}{behaves}", at("; it shows in"))
            }
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discover::pushed::overwhelmed;
    use crate::run::Run;

    /// Commanded yaw moment 2 N·m: a random 21 N·m is too much for a disturbance, 19 N·m is not. Sway is not commanded.
    #[test]
    fn a_random_force_far_beyond_the_command_explains_nothing() {
        let mut run = Run::default();
        run.signals.insert("tau_r".into(), crate::run::Signal::new(vec![0.0, 1.0].into(), vec![2.0, -2.0]));
        run.signals.insert("tau_v".into(), crate::run::Signal::new(vec![0.0, 1.0].into(), vec![0.0, 0.0]));
        let force = |dof, rms| RandomForce { dof, rms, time: 1.0 };
        let of = |forces: &[RandomForce]| overwhelmed(forces, std::slice::from_ref(&run));
        assert_eq!(of(&[force(Dof::Yaw, 21.0)]), [(Dof::Yaw, 10.5)]);
        assert_eq!(of(&[force(Dof::Yaw, 19.0), force(Dof::Sway, 5.0)]), []);
        let told = moved_otherwise(&of(&[force(Dof::Yaw, 190.0)]));
        assert!(told.contains("in `r` a random force is 95 times theirs"), "{told}");
    }

    #[test]
    fn every_verdict_has_its_sentence() {
        let force = RandomForce { dof: Dof::Surge, rms: 0.8, time: 1.1 };
        let say = |verdict, forces: &[RandomForce]| {
            sentence(verdict, &[], &[], forces, None, (&[("v".to_string(), 2.0)], ""), None)
        };
        assert_eq!(
            say(Verdict::NothingMissing, &[force]),
            "Nothing is missing beyond a random force of 0.80 N in surge (correlation 1.1 s): turbulence, tether, or unmeasured input."
        );
        assert!(say(Verdict::NothingMissing, &[]).contains("sensor noise"));
        let unjudged = BehavesLike { id: "drag_asymmetry@surge".into(), why: NOT_SHOWN.into(), gain: 30.0 };
        assert_eq!(
            sentence(Verdict::Unexplained, &[], &[unjudged], &[], None, (&[], ""), None),
            "Something is missing. It behaves like drag that differs astern in surge (drag_asymmetry@surge), but no \
             held-out run shows it: hold out one that does."
        );
        assert!(say(Verdict::Unexplained, &[]).contains("`v`"));
        let (parameter, run) = ("linear_drag@yaw k_r".to_string(), "run04".to_string());
        let (unit, from) = ("kg*m2/s".to_string(), Some(31.2));
        let changed = ChangedParameter {
            parameter,
            run,
            from,
            between: Vec::new(),
            change: 0.831,
            std: 0.0313,
            unit,
            p_value: 1e-9,
            gain: 700.0,
            alone: true,
            absent: false,
            neutral: 0.0,
            relative: false,
        };
        assert_eq!(
            sentence(Verdict::Unexplained, &[], &[], &[], None, (&[], ""), Some(&changed)),
            "Something is missing that is not in the catalogue. Not constant: k_r of linear_drag@yaw is \
             0.83 ± 0.031 kg*m2/s more from 31 s of run04 on."
        );
        let fails = [("u".to_string(), 2.0)];
        assert_eq!(
            sentence(Verdict::Unexplained, &[], &[], &[], None, (&fails, &apart(&["run08"], &["run08".into()])), None),
            "Something is missing that the runs of the fit do not show: it is in `run08`, which goes beyond their range, in `u`."
        );
        assert_eq!(
            sentence(Verdict::Unexplained, &[], &[], &[], None, (&fails, &apart(&[], &["a".into(), "b".into()])), None),
            "Something is missing that the runs of the fit do not show: it is in `a`, `b`, which took no part, in `u`."
        );
        assert_eq!(verdict(true, false), Verdict::PartlyExplained);
    }
}
