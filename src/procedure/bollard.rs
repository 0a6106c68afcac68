//! Stage (i): loss of thrust by interaction, from bollard-pull runs with load cells.
//!
//! ```text
//! load = η_inter τ_nom          one η_inter for each degree of freedom and group of thrusters
//! ```
//!
//! A group is the set of thrusters that push in this degree of freedom during the run, if the run
//! logs each of them; otherwise η_inter holds for any group. Avila et al. (2013), Table 2.

use super::effective_thrust::group;
use super::result::{Estimate, Stage};
use super::{BollardStage, ProcedureError};
use crate::effects::id;
use crate::frame::Dof;
use crate::least_squares::{LeastSquaresOptions, Names, StdMethod, least_squares_with};
use crate::run::{Run, Signal};
use crate::thrust::interaction::{Interaction, fit_interaction};
use crate::thrust::thruster::Thruster;

/// η_inter of `dof`, one per group, from the runs that log its load cell.
pub(super) fn stages(
    dof: Dof,
    runs: &[&Run],
    thrusters: &[Thruster],
    options: &BollardStage,
) -> Result<Vec<(Stage, Interaction)>, ProcedureError> {
    let mut groups: Vec<(Vec<String>, Vec<&Run>)> = Vec::new();
    for run in runs.iter().filter(|run| run.signal(dof.load()).is_some() && run.signal(dof.force()).is_some()) {
        let own = group(run, dof, thrusters);
        match groups.iter_mut().find(|(names, _)| *names == own) {
            Some((_, members)) => members.push(run),
            None => groups.push((own, vec![run])),
        }
    }
    groups.into_iter().map(|(names, members)| of_group(dof, names, &members, options)).collect()
}

fn of_group(
    dof: Dof,
    thrusters: Vec<String>,
    runs: &[&Run],
    options: &BollardStage,
) -> Result<(Stage, Interaction), ProcedureError> {
    let (mut nominal, mut load, mut blocks) = (Vec::new(), Vec::new(), Vec::new());
    for run in runs {
        let begin = nominal.len();
        for (asked, force) in settled_loads(run, dof, options) {
            nominal.push(asked);
            load.push(force);
        }
        blocks.push(begin..nominal.len());
    }
    let name = match thrusters.as_slice() {
        [] => "bollard".to_string(),
        names => format!("bollard {}", names.join("+")),
    };
    let fit = fit_interaction(&nominal, &load)?;
    let of_stage = |source| ProcedureError::Linear { stage: "bollard", dof, source };
    let names = Names { columns: vec!["eta_inter".into()], response: Some(dof.load().into()) };
    let linear = least_squares_with(&[&nominal], &load, &LeastSquaresOptions { names, ..Default::default() })
        .map_err(of_stage)?;
    let covariance = linear.covariance_by(StdMethod::Hac, &[&nominal], &load, &blocks).map_err(of_stage)?;
    let std = covariance[0][0].max(0.0).sqrt();
    let estimate = Estimate {
        effect: id::THRUST_INTERACTION_LOSS.into(),
        dof: dof.to_string(),
        name: "eta_inter".into(),
        value: fit.value,
        std,
        std_paper: fit.std,
        unit: "1".into(),
    };
    let stage = Stage {
        name,
        dof,
        runs: runs.iter().map(|r| r.name.clone()).collect(),
        rows: fit.rows,
        residual_std: fit.residual_std,
        condition_number: linear.condition_number,
        condition_number_scaled: linear.condition_number_scaled,
        estimates: vec![estimate],
        covariance: vec![vec![std * std]],
        numbers: None,
        warnings: Vec::new(),
    };
    Ok((stage, Interaction { dof, thrusters, value: fit.value, std: Some(std) }))
}

/// Nominal force and load-cell reading of `dof`, N or N·m, at each sample where the command has
/// settled; empty if the run logs no load cell.
pub fn settled_loads(run: &Run, dof: Dof, options: &BollardStage) -> Vec<(f64, f64)> {
    let (Some(cell), Some(command)) = (run.signal(dof.load()), run.signal(dof.force())) else { return Vec::new() };
    let settled = settled_from(command, options.steady_part);
    let mut pairs = Vec::new();
    for (t, force) in cell.time().iter().zip(cell.values()) {
        let asked = command.at(*t);
        let k = command.time().partition_point(|s| s <= t).saturating_sub(1);
        if asked.abs() >= options.least_force && *t >= settled[k] {
            pairs.push((asked, *force));
        }
    }
    pairs
}

/// For each sample of a command the instant from which the load counts: the last `part` of a
/// stretch of constant command; the sample itself if the command changes all the time.
fn settled_from(command: &Signal, part: f64) -> Vec<f64> {
    let (time, x) = (command.time(), command.values());
    let mut from = Vec::with_capacity(x.len());
    while from.len() < x.len() {
        let first = from.len();
        let last = (first..x.len()).take_while(|k| x[*k].to_bits() == x[first].to_bits()).last().unwrap_or(first);
        let begin = if last == first { time[first] } else { time[last] - part * (time[last] - time[first]) };
        from.resize(last + 1, begin);
    }
    from
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::RunKind;

    fn run(forces: [f64; 2], load: f64) -> Run {
        let time: Vec<f64> = (0..40).map(f64::from).collect();
        let mut run = Run { kind: RunKind::Bollard, ..Run::default() };
        // the load comes up slowly after the step at 20 s
        let pull: Vec<f64> = time.iter().map(|t| if (20.0..26.0).contains(t) { 0.3 * load } else { load }).collect();
        let nominal: Vec<f64> =
            time.iter().map(|t| forces.iter().sum::<f64>() * if *t < 20.0 { 1.0 } else { 1.001 }).collect();
        run.signals.insert("load_u".into(), Signal::new(time.clone().into(), pull));
        run.signals.insert("tau_u".into(), Signal::new(time.clone().into(), nominal));
        for (name, force) in [("F1", forces[0]), ("F2", forces[1])] {
            run.signals.insert(name.into(), Signal::new(time.clone().into(), vec![force; 40]));
        }
        run
    }

    #[test]
    fn groups_have_their_own_efficiency_and_starts_do_not_count() {
        let thruster = |name: &str| -> Thruster {
            toml::from_str(&format!(
                "name = '{name}'\nposition = [0, 0, 0]\naxis = [1, 0, 0]\nforward = {{a = 1, b = 0}}\nreverse = {{a = 1, b = 0}}"
            ))
            .unwrap()
        };
        let thrusters = [thruster("T5"), thruster("T6")];
        let (alone, both) = (run([100.0, 0.0], 99.0), run([100.0, 100.0], 190.0));
        let runs = [&alone, &both];
        let found = stages(Dof::Surge, &runs, &thrusters, &BollardStage::default()).unwrap();
        let words: Vec<&str> = found.iter().map(|(stage, _)| stage.name.as_str()).collect();
        assert_eq!(words, ["bollard T5", "bollard T5+T6"]);
        // half of the rows have a force of 1.001 times that of the others: 0.05 % between them
        assert!((found[0].1.value - 0.99).abs() < 1e-3 && (found[1].1.value - 0.95).abs() < 1e-3);
        assert_eq!(found[1].1.thrusters, ["T5", "T6"]);
        let all = BollardStage { steady_part: 1.0, ..BollardStage::default() };
        assert!(stages(Dof::Surge, &runs, &thrusters, &all).unwrap()[0].1.value < 0.95);
        let together = stages(Dof::Surge, &runs, &[], &BollardStage::default()).unwrap();
        assert_eq!((together.len(), together[0].0.name.as_str()), (1, "bollard"));
    }
}
