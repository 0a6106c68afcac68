//! Conversion of the commands to the force in each degree of freedom.
//!
//! ```text
//! V → F_nom = curve(V),   τ_nom = B F_nom,   τ = η_inter η_adv τ_nom
//! thruster forces > voltages > wrenches
//! ```
//!
//! `tau_u` … hold the acting force, `nominal_tau_u` … the nominal one if [`Efficiency`] makes a
//! difference. No losses are applied to a vehicle that is held or towed. Avila et al. (2013), eq.
//! (16) and (17).

use std::collections::BTreeMap;
use std::sync::Arc;

use super::codes;
use super::load::moves;
use super::logs::Logged;
use crate::finding::Finding;
use crate::frame::Dof;
use crate::procedure::acting_forces;
use crate::run::thruster_force;
use crate::run::{Run, RunKind, Signal, thruster_of};
use crate::thrust::allocation::Allocation;
use crate::thrust::efficiency::Efficiency;
use crate::thrust::thruster::Thruster;

/// Returns the name of the channel with the nominal force of `dof`.
pub fn nominal(dof: Dof) -> String {
    format!("nominal_{}", dof.force())
}

/// Adds a force of 0 in the degrees of freedom of `undriven`, at the time stamps of the other
/// forces, if the log of a moving vehicle has none.
pub(super) fn nothing(run: &mut Run, undriven: &[Dof]) {
    let known = Dof::ALL.into_iter().find_map(|dof| run.signal(dof.force()).map(|s| s.shared_time().clone()));
    let Some(time) = known.filter(|_| moves(run.kind)) else { return };
    for dof in undriven {
        let none = || Signal::new(time.clone(), vec![0.0; time.len()]);
        run.signals.entry(dof.force().to_string()).or_insert_with(none);
    }
}

/// Puts the acting forces into the run of `logged`; findings go to its findings. Degrees of freedom
/// of `uncommanded` need no force: fins or formulas of the user drive them, or nothing does.
///
/// # Errors
/// Findings, if the log does not give the forces.
pub(super) fn apply(
    logged: &mut Logged,
    dofs: &[Dof],
    uncommanded: &[Dof],
    thrusters: &[Thruster],
    efficiency: &Efficiency,
) -> Result<(), Vec<Finding>> {
    if logged.run.kind == RunKind::Bench {
        return super::bench_command::commanded(logged, thrusters);
    }
    let name = logged.run.name.clone();
    let refuse =
        |code, column: Option<&str>, text: String| vec![Finding::at(code, &name, None, column, &text).of_run(&name)];
    let has = |letter: &str| logged.run.signals.keys().any(|c| thruster_of(c, letter).is_some());
    let wrenches = dofs.iter().any(|dof| logged.run.signals.contains_key(dof.force()));
    let source = match (has("F"), has("V")) {
        (true, _) => Some("F"),
        (false, true) => Some("V"),
        _ => None,
    };
    match source {
        Some(letter) if !thrusters.is_empty() => {
            let forces = thruster_forces(logged, thrusters, letter)?;
            let others: Vec<&str> = [("V", has("V") && letter == "F"), ("tau_*", wrenches)]
                .into_iter()
                .filter_map(|(other, there)| there.then_some(other))
                .collect();
            if !others.is_empty() {
                let text = format!(
                    "the forces are those of {letter}1 to {letter}{}; {} not used",
                    thrusters.len(),
                    others.join(" and ")
                );
                logged.findings.push(Finding::at(&codes::FORCE_SOURCE, &name, None, None, &text).of_run(&name));
            }
            if letter == "F" {
                // commands that are logged beside measured thrust add no information
                logged.run.signals.retain(|column, _| thruster_of(column, "V").is_none());
            }
            wrench(logged, thrusters, &forces).map_err(|text| refuse(&codes::NO_THRUSTER, None, text))?;
        }
        Some(letter) if wrenches => {
            let text = format!("the forces are those of tau_*: {letter}1 … need [[thruster]] tables to be used");
            logged.findings.push(Finding::at(&codes::FORCE_SOURCE, &name, None, None, &text).of_run(&name));
        }
        // a bollard table of one thruster is fitted directly
        Some(letter) if logged.run.kind != RunKind::Bollard => {
            let logged: Vec<&str> =
                logged.run.signals.keys().map(String::as_str).filter(|c| thruster_of(c, letter).is_some()).collect();
            return Err(refuse(&codes::NO_THRUSTER, Some(&format!("{letter}1")), no_tables(&logged)));
        }
        _ => {}
    }
    let needs = !matches!(logged.run.kind, RunKind::Bollard | RunKind::Towing);
    let absent: Vec<Finding> = dofs
        .iter()
        .filter(|dof| needs && !uncommanded.contains(dof) && !logged.run.signals.contains_key(dof.force()))
        .map(|dof| {
            let text = "no such column, and no thruster forces F1 … or commands V1 … that would give it";
            Finding::at(&codes::NO_FORCE, &name, None, Some(dof.force()), text).of_run(&name)
        })
        .collect();
    if !absent.is_empty() {
        return Err(absent);
    }
    let lossless = *efficiency == Efficiency::default();
    if needs && !lossless {
        let (acting, findings) = acting_forces(&logged.run, efficiency, thrusters);
        let before = std::mem::replace(&mut logged.run, acting);
        for dof in Dof::ALL {
            if let Some(signal) = before.signal(dof.force()) {
                logged.run.signals.insert(nominal(dof), signal.clone());
            }
        }
        logged.findings.extend(findings);
    }
    Ok(())
}

/// Returns the message about commands or forces of thrusters that have no table.
pub(super) fn no_tables(logged: &[&str]) -> String {
    let (have, they) = if logged.len() == 1 { ("has", "it pushes") } else { ("have", "they push") };
    format!(
        "{} {have} no [[thruster]] table that says where {they}: add one for each, or log tau_* instead",
        logged.join(", ")
    )
}

/// Returns `run` with the nominal forces that its commands give with these thrusters; `None` if a
/// command is not logged or cannot be read.
pub(super) fn commanded(run: Run, units: &BTreeMap<String, &'static str>, thrusters: &[Thruster]) -> Option<Run> {
    let mut logged = Logged { run, units: units.clone(), ..Logged::default() };
    let forces = thruster_forces(&logged, thrusters, "V").ok()?;
    wrench(&mut logged, thrusters, &forces).ok()?;
    Some(logged.run)
}

/// Returns the nominal force of each thruster, N, at the time stamps of the first one.
fn thruster_forces(logged: &Logged, thrusters: &[Thruster], letter: &str) -> Result<Vec<Signal>, Vec<Finding>> {
    let run = &logged.run;
    let volts = run.supply_voltage();
    let (mut forces, mut wrong): (Vec<Signal>, Vec<Finding>) = (Vec::new(), Vec::new());
    for (k, thruster) in thrusters.iter().enumerate() {
        let column = format!("{letter}{}", k + 1);
        let Some(signal) = run.signal(&column).filter(|s| !s.is_empty()) else {
            let text = format!("no such column; {letter} is logged, so thruster {:?} needs it", thruster.name);
            wrong.push(Finding::at(&codes::THRUSTER_COLUMN, &run.name, None, Some(&column), &text).of_run(&run.name));
            continue;
        };
        let clock = forces.first().map_or(signal.shared_time(), Signal::shared_time).clone();
        let curve = thruster.curve();
        let pulses = letter == "V" && logged.units.get(&column) == Some(&"us");
        let force = |t: f64| -> Result<f64, String> {
            let x = signal.at(t);
            let command = if pulses { thruster.command_of_pulse(x).map_err(|e| e.to_string())? } else { x };
            Ok(match (letter, volts, curve.supply) {
                ("F", ..) => x,
                (_, Some(volts), Some(_)) => curve.force_at(command, volts.at(t)),
                _ => curve.force(command),
            })
        };
        match clock.iter().map(|t| force(*t)).collect::<Result<Vec<f64>, String>>() {
            Ok(values) => forces.push(Signal::new(clock, values)),
            Err(text) => {
                wrong.push(Finding::at(&codes::NO_PULSE, &run.name, None, Some(&column), &text).of_run(&run.name));
            }
        }
    }
    if wrong.is_empty() { Ok(forces) } else { Err(wrong) }
}

/// Writes the nominal force of each thruster and the wrench of all thrusters into the run.
fn wrench(logged: &mut Logged, thrusters: &[Thruster], forces: &[Signal]) -> Result<(), String> {
    let run = &mut logged.run;
    let Some(clock) = forces.first().map(|f| f.shared_time().clone()) else { return Ok(()) };
    let allocation = Allocation::new(thrusters).map_err(|e| e.to_string())?;
    let mut rows: Vec<Vec<f64>> = vec![Vec::new(); 6];
    for k in 0..clock.len() {
        let now: Vec<f64> = forces.iter().map(|f| f.values()[k]).collect();
        for (row, force) in rows.iter_mut().zip(allocation.wrench(&now).iter()) {
            row.push(*force);
        }
    }
    for (dof, row) in Dof::ALL.into_iter().zip(rows) {
        // a force that these thrusters cannot give is no command of that degree of freedom
        if thrusters.iter().any(|t| t.pushes(dof)) {
            run.signals.insert(dof.force().into(), Signal::new(clock.clone(), row));
        }
    }
    for (k, force) in forces.iter().enumerate() {
        run.signals.insert(thruster_force(k), force.clone());
    }
    silent(run, &clock);
    Ok(())
}

/// Sets the force to 0 in degrees of freedom that have none, because no thruster drives them.
fn silent(run: &mut Run, clock: &Arc<[f64]>) {
    for dof in Dof::ALL {
        run.signals.entry(dof.force().into()).or_insert_with(|| Signal::new(clock.clone(), vec![0.0; clock.len()]));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::thrust::advance::AdvanceLoss;
    use crate::thrust::interaction::{Interaction, InteractionTable};

    fn logged(columns: &[(&str, f64)]) -> Logged {
        let clock: Arc<[f64]> = vec![0.0, 1.0].into();
        let mut run = Run { name: "a.csv".into(), ..Run::default() };
        for (name, value) in columns {
            run.signals.insert((*name).into(), Signal::new(clock.clone(), vec![*value; 2]));
        }
        Logged { run, ..Logged::default() }
    }

    fn pair() -> Vec<Thruster> {
        let text = |name: &str, y: f64| {
            format!(
                "name = '{name}'\nposition = [0, {y}, 0]\naxis = [1, 0, 0]\nforward = {{a = 2.0, b = 0.0}}\nreverse = {{a = 1.0, b = 0.0}}\n"
            )
        };
        vec![toml::from_str(&text("port", -0.5)).unwrap(), toml::from_str(&text("starboard", 0.5)).unwrap()]
    }

    const PLANAR: [Dof; 2] = [Dof::Surge, Dof::Yaw];

    #[test]
    fn exact_voltages_become_a_wrench_and_win_over_tau() {
        let mut run = logged(&[("V1", 3.0), ("V2", -3.0), ("tau_u", 99.0), ("tau_r", 99.0)]);
        apply(&mut run, &PLANAR, &[], &pair(), &Efficiency::default()).unwrap();
        // 2·9 ahead at port and 1·9 astern at starboard by the paper's F = a V² + b V (b = 0)
        let force = |name: &str| run.run.signals[name].values()[0];
        let (surge, yaw) = (force("tau_u"), force("tau_r"));
        assert!(surge > 0.0 && yaw > 0.0 && surge < 99.0, "{surge} {yaw}");
        assert!(run.findings.iter().any(|f| f.code == codes::FORCE_SOURCE.code));
    }

    #[test]
    fn absent_columns_are_named() {
        let mut half = logged(&[("V1", 3.0)]);
        let wrong = apply(&mut half, &PLANAR, &[], &pair(), &Efficiency::default()).unwrap_err();
        assert_eq!(wrong[0].column.as_deref(), Some("V2"));
        let mut none = logged(&[("V1", 3.0)]);
        assert_eq!(apply(&mut none, &PLANAR, &[], &[], &Efficiency::default()).unwrap_err()[0].code, "M003");
        let mut bare = logged(&[("tau_u", 3.0)]);
        assert_eq!(
            apply(&mut bare, &PLANAR, &[], &[], &Efficiency::default()).unwrap_err()[0].column.as_deref(),
            Some("tau_r")
        );
    }

    #[test]
    fn efficiencies_scale_what_acts_and_keep_what_was_asked() {
        let entry = Interaction { dof: Dof::Surge, thrusters: Vec::new(), value: 0.9, std: None };
        let loss = Efficiency {
            eta_inter: InteractionTable(vec![entry]),
            eta_adv: Some(AdvanceLoss { slope: -0.2, intercept: 1.0, valid: [0.0, 1.0] }),
            ..Efficiency::default()
        };
        let mut run = logged(&[("tau_u", 100.0), ("tau_r", 0.0), ("u", 0.5)]);
        apply(&mut run, &PLANAR, &[], &[], &loss).unwrap();
        assert!((run.run.signals["tau_u"].values()[0] - 100.0 * 0.9 * 0.9).abs() < 1e-12);
        assert_eq!(run.run.signals["nominal_tau_u"].values()[0], 100.0);
        assert!(run.findings.is_empty());
        let mut fast = logged(&[("tau_u", 100.0), ("tau_r", 0.0), ("u", 1.5)]);
        apply(&mut fast, &PLANAR, &[], &[], &loss).unwrap();
        assert!(fast.findings.iter().any(|f| f.kind == "advance-out-of-range"));
        let mut held = logged(&[("tau_u", 100.0), ("tau_r", 0.0), ("u", 0.5)]);
        held.run.kind = RunKind::Bollard;
        apply(&mut held, &PLANAR, &[], &[], &loss).unwrap();
        assert_eq!(held.run.signals["tau_u"].values()[0], 100.0);
    }
}
