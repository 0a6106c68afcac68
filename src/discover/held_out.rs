//! The gap on runs that took no part in the fit: those with the role `validate`, or each run in its turn.

use std::collections::BTreeMap;

use super::gap::{Gap, gap, motion};
use crate::estimate::output_error::{OutputErrorError, OutputErrorOptions};
use crate::frame::Measured;
use crate::model::Model;
use crate::run::Run;

/// The gap of `model` on `held`; where there are none, on each of `train` when the model is refitted without it. Runs
/// marked in `cut` are compared in segments. A model that runs away predicts nothing, and the motion is the gap.
///
/// # Errors
/// As [`gap`].
pub(super) fn held_out(
    model: &Model,
    train: &[Run],
    held: &[Run],
    fitting: &OutputErrorOptions,
    cut: &[bool],
) -> Result<Gap, OutputErrorError> {
    let (found, judges) = match held.is_empty() {
        true => (in_turn(model, train, fitting, cut), train),
        false => (gap(model, held, fitting, cut), held),
    };
    match found {
        Err(OutputErrorError::Diverges { .. }) => Ok(motion(model, judges)),
        found => found,
    }
}

/// The gap with each run held out in turn and the model refitted on the others; of a single run the last third.
fn in_turn(model: &Model, runs: &[Run], fitting: &OutputErrorOptions, cut: &[bool]) -> Result<Gap, OutputErrorError> {
    let mut all = Gap::default();
    let mut squares: BTreeMap<Measured, f64> = BTreeMap::new();
    let pairs: Vec<(Vec<Run>, Run)> = match runs {
        [single] => split(single).into_iter().collect(),
        several => (0..several.len())
            .map(|k| {
                let others = several.iter().enumerate().filter(|(i, _)| *i != k).map(|(_, r)| r.clone()).collect();
                (others, several[k].clone())
            })
            .collect(),
    };
    for (k, (others, held)) in pairs.iter().enumerate() {
        let mut start = model.clone();
        for parameter in &mut start.parameters {
            parameter.per_run.clear();
        }
        let refitted = crate::estimate::output_error::output_error(&start, others, fitting)?;
        let one = gap(&refitted.model, std::slice::from_ref(held), fitting, &cut[k..=k])?;
        for (dof, rms) in &one.rms {
            *squares.entry(dof.clone()).or_default() += rms * rms / pairs.len() as f64;
        }
        all.runs.extend(one.runs);
    }
    all.rms = squares.into_iter().map(|(dof, s)| (dof, s.sqrt())).collect();
    Ok(all)
}

/// A run cut into its first two thirds and its last third.
fn split(run: &Run) -> Option<(Vec<Run>, Run)> {
    let (begin, end) = run.span()?;
    let cut = begin + (end - begin) * 2.0 / 3.0;
    Some((vec![run.between(begin, cut)], run.between(cut, end)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Coriolis;
    use crate::frame::Dof;
    use crate::run::Signal;

    /// An inertia of 1 mg under 1 N with drag that feeds the motion: it runs away, and what is left is the motion, 3 and
    /// 4 m/s.
    #[test]
    fn exact_gap_of_a_model_that_runs_away() {
        let mut model =
            Model::with_effects(&[Dof::Surge], Coriolis::Tied, &["inertia", "linear_drag", "quadratic_drag"]).unwrap();
        for (name, value) in [("inertia@surge", 1e-6), ("linear_drag@surge", -1.0), ("quadratic_drag@surge", -1.0)] {
            model.set(name, value);
        }
        let mut run = Run { name: "away.csv".into(), ..Run::default() };
        let time: std::sync::Arc<[f64]> = (0..200).map(|k| 0.1 * f64::from(k)).collect();
        let speed: Vec<f64> = (0..200).map(|k| if k % 2 == 0 { 3.0 } else { 4.0 }).collect();
        run.signals.insert("u".into(), Signal::new(time.clone(), speed));
        run.signals.insert("tau_u".into(), Signal::new(time, vec![1.0; 200]));
        let options = OutputErrorOptions::default();
        let found = held_out(&model, &[], std::slice::from_ref(&run), &options, &[false]).unwrap();
        assert!((found.rms[&Measured::Velocity(Dof::Surge)] - 12.5f64.sqrt()).abs() < 1e-12, "{found:?}");
        assert_eq!(found.runs[0].0, "away.csv");
    }
}
