//! Findings where a target extrapolates beyond the range of the model.
//!
//! A target moves at any speed, attitude and amplitude; the model was fitted within its envelope.
//! The heading of every file states the envelope; what the target does not check is a finding.

use super::{ExportOptions, Target, codes};
use crate::campaign::ModelFile;
use crate::effects::channel;
use crate::envelope::KC_RATIO;
use crate::finding::Finding;
use crate::frame::Dof;
use crate::model::Model;

/// Findings about the range of the model in a target.
pub(super) fn findings(file: &ModelFile, model: &Model, target: Target, options: &ExportOptions) -> Vec<Finding> {
    if matches!(target, Target::Latex | Target::Csv) {
        return Vec::new();
    }
    if file.envelope.is_empty() {
        let text = "the model file does not say at which speeds, angles and amplitudes it was fitted: fit it again \
                    to record them";
        return vec![Finding::new(&codes::NO_ENVELOPE, text)];
    }
    let mut findings = Vec::new();
    if !target.is_linear() {
        let speeds = model.dofs.iter().filter_map(|dof| Some((dof.velocity(), *file.envelope.get(dof.velocity())?)));
        let angles = [Dof::Roll, Dof::Pitch].map(Dof::position);
        let angles = angles.into_iter().filter_map(|name| Some((name, *file.envelope.get(name)?)));
        let ranges: Vec<String> =
            speeds.chain(angles).map(|(name, [low, high])| format!("{name} {low:.3} to {high:.3}")).collect();
        if !ranges.is_empty() {
            let text = format!(
                "`{}` moves at any speed; the model was fitted within (SI units) {}: beyond, it extrapolates",
                target.name(),
                ranges.join(", ")
            );
            findings.push(Finding::new(&codes::NO_LIMITS, text));
        }
    }
    findings.extend(at_one_amplitude(file, model, target));
    findings.extend(beyond(file, options));
    findings
}

/// A finding if added mass and drag were identified at one amplitude and the target uses them at
/// any.
fn at_one_amplitude(file: &ModelFile, model: &Model, target: Target) -> Option<Finding> {
    let of = |dof: &Dof| {
        let [low, high] = *file.envelope.get(&channel::keulegan_carpenter(*dof))?;
        (low > 0.0 && high < low * KC_RATIO).then(|| format!("{dof} (KC {low:.2} to {high:.2})"))
    };
    let told: Vec<String> = model.dofs.iter().filter_map(of).collect();
    (!told.is_empty()).then(|| {
        let text = format!(
            "the runs of the fit oscillate at one amplitude in {}, and `{}` uses their added mass and drag at any",
            told.join(", "),
            target.name()
        );
        Finding::new(&codes::ONE_AMPLITUDE, text)
    })
}

/// Findings for angles and forces of a given operating point that lie outside the envelope; speeds
/// are checked with the point itself.
fn beyond(file: &ModelFile, options: &ExportOptions) -> Vec<Finding> {
    let speed = |name: &str| Dof::ALL.iter().any(|dof| dof.velocity() == name);
    let of = |(name, value): (&String, &f64)| {
        let [low, high] = *file.envelope.get(name)?;
        let text = format!("{name} = {value} lies beyond the {low:.3} to {high:.3} of the fit");
        (!speed(name) && !(low..=high).contains(value)).then(|| Finding::new(&codes::OUT_OF_ENVELOPE, text))
    };
    options.at.iter().filter_map(of).collect()
}
