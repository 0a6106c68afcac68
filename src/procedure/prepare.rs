//! Runs made ready for the stages: smoothed, with the rates that are not logged, with the force that acts.
//!
//! ```text
//! τ = η_inter η_adv(|V|) τ_nom,   V = (u, v, w)          p, q, r: slope of the filtered φ, θ, ψ where not logged
//! ```
//!
//! (16) and (17) of Avila et al. (2013). A model that holds the losses itself (`thrust_advance_loss`, …) needs no
//! efficiency here.

use super::codes;
use crate::filter::{FilterError, PolynomialFilter};
use crate::finding::Finding;
use crate::frame::Dof;
use crate::model::Model;
use crate::navigation::unwrap;
use crate::run::{Run, RunKind, Signal};
use crate::thrust::advance::Coverage;
use crate::thrust::efficiency::{AdvanceSpeed, Efficiency};

/// Smooths the velocities of a run; angles and forces stay as they are.
pub(super) fn smooth(run: &Run, filter: &PolynomialFilter) -> Result<Run, FilterError> {
    let mut smoothed = run.clone();
    for dof in Dof::ALL {
        if let Some(signal) = run.signal(dof.velocity()) {
            smoothed.signals.insert(dof.velocity().into(), filter.apply(signal, &run.gaps)?.value);
        }
    }
    Ok(smoothed)
}

/// Makes the body rates that a coupling of the model reads and the run does not log, for small roll and pitch; returns
/// which.
pub(super) fn make_rates(
    run: &mut Run,
    model: &Model,
    filter: &PolynomialFilter,
) -> Result<Vec<&'static str>, FilterError> {
    let mut made = Vec::new();
    let needed: Vec<Dof> = model.terms.iter().filter_map(|t| t.place.other).filter(|d| d.is_rotation()).collect();
    for dof in needed {
        let (rate, angle) = (dof.velocity(), dof.position());
        if run.signal(rate).is_some() {
            continue;
        }
        let Some(signal) = run.signal(angle) else { continue };
        let turned = Signal::new(signal.shared_time().clone(), unwrap(signal.values()));
        let slope = filter.apply(&turned, &run.gaps)?.derivative;
        run.signals.insert(rate.into(), slope);
        made.push(rate);
    }
    Ok(made)
}

/// The run with the forces that act in place of the nominal ones, and what the efficiencies do not cover.
///
/// η_adv is taken at the speed of the vehicle, |V|; a thrust along a translation that it opposes is against the motion.
/// `thrusters` that run are not named: the entry of η_inter for any group counts.
pub fn acting_forces(run: &Run, efficiency: &Efficiency) -> (Run, Vec<Finding>) {
    let mut acting = run.clone();
    let mut warnings = Vec::new();
    for dof in Dof::ALL {
        let Some(nominal) = run.signal(dof.force()) else { continue };
        let mut counts = [0_usize; 3];
        let forces: Vec<f64> = nominal
            .time()
            .iter()
            .zip(nominal.values())
            .map(|(t, tau)| {
                let delivered = efficiency.force(dof, &[], *tau, advance_speed(run, dof, *tau, *t));
                if tau.abs() > 0.0 {
                    counts[delivered.coverage as usize] += 1;
                }
                delivered.force
            })
            .collect();
        acting.signals.insert(dof.force().into(), Signal::new(nominal.shared_time().clone(), forces));
        let part = |coverage: Coverage| 100.0 * counts[coverage as usize] as f64 / nominal.len().max(1) as f64;
        let all = [(Coverage::OutOfRange, &codes::ADVANCE_RANGE), (Coverage::AgainstMotion, &codes::ADVANCE_AGAINST)];
        for (coverage, code) in all {
            // single samples about rest are no finding
            if efficiency.eta_adv.is_some() && part(coverage) > 1.0 {
                let meaning = code.meaning.trim_end_matches('.');
                let text = format!("{meaning}: {:.0} % of the samples of {}", part(coverage), dof.force());
                let column = Some(dof.force().to_string());
                warnings.push(Finding { column, ..Finding::new(code, text) }.of_run(&run.name));
            }
        }
    }
    (acting, warnings)
}

/// Advance speed, m/s: positive where the thrust is along the motion, negative where it is against it.
fn advance_speed(run: &Run, dof: Dof, tau: f64, t: f64) -> f64 {
    let velocity = |dof: Dof| run.signal(dof.velocity()).map_or(0.0, |signal| at(signal, t));
    let speed = [Dof::Surge, Dof::Sway, Dof::Heave].map(velocity).iter().map(|v| v * v).sum::<f64>().sqrt();
    let against = !dof.is_rotation() && velocity(dof) * tau < 0.0;
    if against { -speed } else { speed }
}

/// The straight line between samples.
pub(super) fn at(signal: &Signal, t: f64) -> f64 {
    let (time, x) = (signal.time(), signal.values());
    match time.partition_point(|s| *s <= t) {
        0 => x.first().copied().unwrap_or(0.0),
        k if k == x.len() => x[k - 1],
        k => x[k - 1] + (x[k] - x[k - 1]) * (t - time[k - 1]) / (time[k] - time[k - 1]),
    }
}

/// Whether the losses are taken at the speed of the vehicle, as here.
pub(super) fn is_paper_speed(efficiency: &Efficiency) -> bool {
    efficiency.advance_speed == AdvanceSpeed::Vehicle
}

/// The degree of freedom that a run shows: the one into which the command puts most power, |τ ν| in W, of means at
/// constant velocity, else of deviations from them. Power compares translations with rotations without any scale.
pub(super) fn shown(run: &Run, dofs: &[Dof]) -> Option<Dof> {
    let size = |name: &str| {
        let x = run.signal(name).map_or(&[][..], Signal::values);
        let n = x.len().max(1) as f64;
        let mean = x.iter().sum::<f64>() / n;
        match run.kind {
            RunKind::ConstantVelocity => mean.abs(),
            _ => (x.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n).sqrt(),
        }
    };
    let power = |dof: &Dof| match run.kind {
        RunKind::Bollard => size(dof.load()) * size(dof.force()),
        RunKind::Towing => size(dof.load()),
        _ => size(dof.force()) * size(dof.velocity()),
    };
    dofs.iter().copied().max_by(|a, b| power(a).total_cmp(&power(b)))
}
