//! Effective forces from nominal forces.
//!
//! ```text
//! τᵢ = η_inter η_adv(|νᵢ|) τ_nom,i     (moments: |u|)        for a run that logs forces of the vehicle
//! τᵢ = η_inter,i Σ bᵢ η_adv(v_a) F                           for a run that logs those of its thrusters
//! ```
//!
//! (16) and (17) of Avila et al. (2013). For thrusters, η_inter is that of the group that pushes in
//! this degree of freedom, and v_a is the speed of the vehicle or the speed along each thruster's
//! axis, as the efficiency says. A model that contains the losses itself (`thrust_advance_loss`, …)
//! needs no efficiency here.

use nalgebra::Vector6;

use super::codes;
use crate::finding::Finding;
use crate::frame::Dof;
use crate::run::{Run, Signal, thruster_force};
use crate::thrust::advance::Coverage;
use crate::thrust::efficiency::Efficiency;
use crate::thrust::thruster::Thruster;

/// Name of the channel with the force of thruster `k` after the loss by advance, if there is one.
pub fn acting_thruster_force(k: usize) -> String {
    format!("acting_{}", thruster_force(k))
}

/// The nominal force of each thruster, if the run has them all.
fn forces_of<'a>(run: &'a Run, thrusters: &[Thruster]) -> Option<Vec<&'a Signal>> {
    let all: Option<Vec<&Signal>> = (0..thrusters.len()).map(|k| run.signal(&thruster_force(k))).collect();
    all.filter(|all| !all.is_empty())
}

/// Whether the losses of this run are computed thruster by thruster.
pub(super) fn by_thruster(run: &Run, thrusters: &[Thruster]) -> bool {
    forces_of(run, thrusters).is_some()
}

/// Names of the thrusters that push in `dof` at some instant of the run; empty if the run does not
/// log them.
pub(super) fn group(run: &Run, dof: Dof, thrusters: &[Thruster]) -> Vec<String> {
    let Some(forces) = forces_of(run, thrusters) else { return Vec::new() };
    let pushes =
        |thruster: &Thruster, force: &Signal| thruster.pushes(dof) && force.values().iter().any(|f| f.abs() > 0.0);
    let running = thrusters.iter().zip(forces).filter(|(thruster, force)| pushes(thruster, force));
    running.map(|(thruster, _)| thruster.name.clone()).collect()
}

/// The run with effective forces in place of the nominal ones, and findings about samples for which
/// the efficiencies were not measured.
///
/// If the run has the nominal force `F1`, `F2`, … of every one of `thrusters`, the wrench is
/// computed from them. Otherwise η_adv is taken at the speed of the vehicle along the force (ahead,
/// for a moment), and η_inter is that of any group.
pub fn acting_forces(run: &Run, efficiency: &Efficiency, thrusters: &[Thruster]) -> (Run, Vec<Finding>) {
    let mut acting = run.clone();
    let mut warnings = Vec::new();
    match forces_of(run, thrusters) {
        Some(forces) => {
            let (signals, counts) = of_thrusters(run, efficiency, thrusters, &forces);
            acting.signals.extend(signals);
            warnings.extend(coverage(run, efficiency, None, counts));
        }
        None => {
            for dof in Dof::ALL {
                let Some(nominal) = run.signal(dof.force()) else { continue };
                let (signal, counts) = of_vehicle(run, efficiency, dof, nominal);
                acting.signals.insert(dof.force().into(), signal);
                warnings.extend(coverage(run, efficiency, Some(dof), counts));
            }
        }
    }
    (acting, warnings)
}

/// Number of samples by coverage, in the order of [`Coverage`].
type Counts = [usize; 3];

fn of_vehicle(run: &Run, efficiency: &Efficiency, dof: Dof, nominal: &Signal) -> (Signal, Counts) {
    let mut counts = [0; 3];
    let force = |(t, tau): (&f64, &f64)| {
        let delivered = efficiency.force(dof, &[], *tau, advance_speed(run, dof, *tau, *t));
        if tau.abs() > 0.0 {
            counts[delivered.coverage as usize] += 1;
        }
        delivered.force
    };
    let forces: Vec<f64> = nominal.time().iter().zip(nominal.values()).map(force).collect();
    (Signal::new(nominal.shared_time().clone(), forces), counts)
}

fn of_thrusters(
    run: &Run,
    efficiency: &Efficiency,
    thrusters: &[Thruster],
    forces: &[&Signal],
) -> (Vec<(String, Signal)>, Counts) {
    let mut counts = [0; 3];
    let clock = forces[0].shared_time();
    let mut wrench: Vec<Vec<f64>> = vec![Vec::new(); 6];
    let mut own: Vec<Vec<f64>> = vec![Vec::new(); if efficiency.eta_adv.is_some() { thrusters.len() } else { 0 }];
    for t in clock.iter() {
        let now: Vec<f64> = forces.iter().map(|f| f.at(*t)).collect();
        let nu = Vector6::from_fn(|i, _| run.signal(Dof::ALL[i].velocity()).map_or(0.0, |s| s.at(*t)));
        let delivered = efficiency.wrench(thrusters, &now, &nu);
        if now.iter().any(|f| f.abs() > 0.0) {
            counts[delivered.coverage as usize] += 1;
        }
        for (row, force) in wrench.iter_mut().zip(delivered.force.iter()) {
            row.push(*force);
        }
        for ((row, thruster), force) in own.iter_mut().zip(thrusters).zip(&now) {
            row.push(force * efficiency.advance(efficiency.advance_of(thruster, *force, &nu)).efficiency);
        }
    }
    // a degree of freedom in which no thruster pushes keeps its logged command
    let given = |dof: &Dof| thrusters.iter().any(|t| t.pushes(*dof));
    let of_dofs =
        Dof::ALL.into_iter().zip(wrench).filter(|(dof, _)| given(dof)).map(|(dof, row)| (dof.force().into(), row));
    let of_each = own.into_iter().enumerate().map(|(k, row)| (acting_thruster_force(k), row));
    let signals = of_dofs.chain(of_each).map(|(name, row)| (name, Signal::new(clock.clone(), row)));
    (signals.collect(), counts)
}

/// Findings if more than 1 % of the samples with thrust lie outside the measured range of speeds or
/// push against the motion; a smaller part is single samples about rest.
fn coverage(run: &Run, efficiency: &Efficiency, dof: Option<Dof>, counts: Counts) -> Vec<Finding> {
    let all: usize = counts.iter().sum();
    let part = |c: Coverage| 100.0 * counts[c as usize] as f64 / all.max(1) as f64;
    let told = [(Coverage::OutOfRange, &codes::ADVANCE_RANGE), (Coverage::AgainstMotion, &codes::ADVANCE_AGAINST)];
    let Some(line) = efficiency.eta_adv else { return Vec::new() };
    let told = told.into_iter().filter(|(c, _)| part(*c) > 1.0);
    told.map(|(c, code)| {
        let meaning = code.meaning.trim_end_matches('.');
        let what = dof.map_or("the thrusters", Dof::force);
        let [least, most] = line.valid;
        let text = format!("{meaning}: {:.0} % of the samples of {what}; measured {least} to {most} m/s", part(c));
        Finding { column: dof.map(|dof| dof.force().to_string()), ..Finding::new(code, text) }.of_run(&run.name)
    })
    .collect()
}

/// Advance speed, m/s: positive if the thrust is along the motion, negative if it is against it. A
/// force of the vehicle pushes along its own axis; a moment is assumed to come from thrusters that
/// point ahead.
fn advance_speed(run: &Run, dof: Dof, tau: f64, t: f64) -> f64 {
    let velocity = |dof: Dof| run.signal(dof.velocity()).map_or(0.0, |signal| signal.at(t));
    if dof.is_rotation() { velocity(Dof::Surge).abs() } else { velocity(dof) * tau.signum() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::thrust::advance::AdvanceLoss;
    use crate::thrust::efficiency::AdvanceSpeed;
    use crate::thrust::interaction::{Interaction, InteractionTable};

    /// Two thrusters, one ahead and one 60° off the axis, at 10 N each while the vehicle moves
    /// ahead at 1 m/s.
    fn run() -> (Run, Vec<Thruster>) {
        let text = |name: &str, x: f64, y: f64| {
            format!(
                "name = '{name}'\nposition = [0, 0, 0]\naxis = [{x}, {y}, 0]\nforward = {{a = 1, b = 0}}\nreverse = {{a = 1, b = 0}}"
            )
        };
        let thrusters = [text("ahead", 1.0, 0.0), text("aslant", 0.5, 0.75_f64.sqrt())];
        let mut run = Run::default();
        for (name, value) in [("F1", 10.0), ("F2", 10.0), ("u", 1.0), ("tau_u", 99.0)] {
            run.signals.insert(name.into(), Signal::new(vec![0.0, 1.0].into(), vec![value; 2]));
        }
        (run, thrusters.iter().map(|t| toml::from_str(t).unwrap()).collect())
    }

    #[test]
    fn exact_loss_along_each_thrusters_axis() {
        let (run, thrusters) = run();
        let entry = |thrusters: &[&str], value| Interaction {
            dof: Dof::Surge,
            thrusters: thrusters.iter().map(|s| (*s).to_string()).collect(),
            value,
            std: None,
        };
        let eta_inter = InteractionTable(vec![entry(&["ahead", "aslant"], 0.5), entry(&[], 0.9)]);
        let eta_adv = Some(AdvanceLoss { slope: -0.2, intercept: 1.0, valid: [0.0, 2.0] });
        let surge = |advance_speed| {
            let efficiency = Efficiency { eta_inter: eta_inter.clone(), eta_adv, advance_speed };
            acting_forces(&run, &efficiency, &thrusters).0.signal("tau_u").unwrap().values()[0]
        };
        // the advance speed along the oblique axis is half, and half of its force points ahead
        assert!((surge(AdvanceSpeed::Vehicle) - 0.5 * (0.8 * 10.0 + 0.8 * 5.0)).abs() < 1e-12);
        assert!((surge(AdvanceSpeed::ThrusterAxis) - 0.5 * (0.8 * 10.0 + 0.9 * 5.0)).abs() < 1e-12);
        assert_eq!(group(&run, Dof::Surge, &thrusters), ["ahead", "aslant"]);
        assert_eq!(group(&run, Dof::Sway, &thrusters), ["aslant"]);
        assert!(group(&run, Dof::Surge, &[]).is_empty());
    }

    #[test]
    fn speeds_outside_of_the_line_are_told() {
        let (run, _) = run();
        let narrow = AdvanceLoss { valid: [0.0, 0.5], ..AdvanceLoss::PAPER };
        let efficiency = Efficiency { eta_adv: Some(narrow), ..Efficiency::default() };
        let (_, warnings) = acting_forces(&run, &efficiency, &[]);
        assert_eq!(warnings[0].code, codes::ADVANCE_RANGE.code);
        assert!(warnings[0].message.contains("measured 0 to 0.5 m/s"), "{}", warnings[0].message);
    }
}
