//! Which effects which kind of run can show.
//!
//! ```text
//! margin = |θ − neutral| / (5 std)      std of the effect's first parameter beside everything else, on runs of a kind
//! ```
//!
//! θ is the sensible size of the effect. Five standard deviations is what the search all but surely sees. All other
//! figures of the vehicle are known to 30 %, as from a handbook, so that a run of one kind stands for itself.

use std::fmt::Write as _;

use hydrosysid::estimate::output_error::{OutputErrorOptions, output_error};
use hydrosysid::model::Model;
use hydrosysid::run::Run;
use hydrosysid::tank::{BlindOptions, CraftKind, Hidden, blind};

use crate::plan::{SINGLE, SPATIAL};

/// Kinds of runs, by the index of the trial.
const KINDS: [(&str, &[usize]); 6] = [
    ("surge", &[0, 1, 8]),
    ("sway", &[2]),
    ("yaw", &[3]),
    ("zig-zag", &[4, 6]),
    ("all at once", &[5, 7]),
    ("all nine", &[0, 1, 2, 3, 4, 5, 6, 7, 8]),
];
/// The same in six degrees of freedom.
const SPATIAL_KINDS: [(&str, &[usize]); 5] = [
    ("heave", &[9]),
    ("roll", &[10]),
    ("pitch", &[11]),
    ("all at once", &[5, 7, 12]),
    ("all thirteen", &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12]),
];

/// The document's part: one row an effect, one column a kind of run.
pub fn matrix(seed: u64) -> Result<String, String> {
    let mut text = String::from(
        "\n## What each kind of run can show\n\nSize of the hidden effect over the smallest that runs of this kind alone show (five standard \
         deviations), large vehicle, one seed: below 1 it cannot be seen. Other figures of the vehicle known to 30 %.\n",
    );
    for (names, kinds, six) in [(SINGLE, &KINDS[..], false), (SPATIAL, &SPATIAL_KINDS[..], true)] {
        let heads = kinds.iter().map(|(k, _)| format!(" {k} |")).collect::<String>();
        let _ = write!(text, "\n| effect |{heads}\n|---|{}\n", "---|".repeat(kinds.len()));
        for name in names {
            // a Coriolis row of another size than 1 has a coefficient of its own
            let size = if name.starts_with("coriolis") { 0.999 } else { 1.0 };
            let hidden = vec![Hidden::new(*name, size)];
            let options = BlindOptions { seed, craft: CraftKind::Large, six, hidden, ..BlindOptions::default() };
            let campaign = blind(&options).map_err(|e| e.to_string())?;
            let _ = write!(text, "| {name} |");
            for (_, indices) in kinds {
                let runs: Vec<Run> = indices.iter().map(|k| campaign.runs[*k].clone()).collect();
                let margin = margin(&campaign.truth, name, &runs, indices);
                let shown = margin.map_or("–".into(), |m| if m < 10.0 { format!("{m:.1}") } else { format!("{m:.0}") });
                let _ = write!(text, " {shown} |");
            }
            text += "\n";
        }
    }
    Ok(text)
}

/// The size of the effect over the smallest that these runs show; `None` where they cannot be fitted.
fn margin(truth: &Model, name: &str, runs: &[Run], indices: &[usize]) -> Option<f64> {
    let mut model = truth.clone();
    let own = model.terms[model.term(name)?].parameters.clone();
    for (k, parameter) in model.parameters.iter_mut().enumerate() {
        if !parameter.per_run.is_empty() {
            parameter.per_run = indices.iter().filter_map(|i| parameter.per_run.get(*i).copied()).collect();
        }
        if !own.contains(&k) {
            parameter.prior = Some((parameter.value, 0.3 * parameter.value.abs().max(1e-3)));
        }
    }
    let first = *own.first()?;
    let neutral = model.parameters[first].spec.neutral;
    // what has no size when absent (a limit) is seen by its share
    let size =
        if neutral.is_finite() { model.parameters[first].value - neutral } else { model.parameters[first].value };
    let scale = if size == 0.0 { 1.0 } else { size.abs() };
    for p in &own {
        let value = model.parameters[*p].value;
        model.parameters[*p].prior = Some((value, 100.0 * scale.max(value.abs())));
    }
    let fitting = OutputErrorOptions { position: true, ..OutputErrorOptions::default() };
    let fit = output_error(&model, runs, &fitting).ok()?;
    let std = fit.model.parameters[first].std?;
    Some(size.abs() / (5.0 * std))
}
