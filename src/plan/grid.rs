//! Candidate runs: each degree of freedom alone, pairs of them, zig-zags, everything at once.
//!
//! Forces are shares of the limit of thrust. Constant runs show drag, short periods inertia, long periods the
//! dependence of drag on speed. Offsets and reversals reveal one-sided effects; pairs and zig-zags show couplings.

use std::collections::BTreeMap;

use super::manoeuvre::{Manoeuvre, Push};
use crate::frame::Dof;
use crate::model::Model;
use crate::run::RunKind;

/// Options of the grid of candidates.
#[derive(Debug, Clone, PartialEq)]
pub struct GridOptions {
    /// Length of each run, s.
    pub length: f64,
    /// Periods of sines, s.
    pub periods: Vec<f64>,
    /// Amplitudes of sines without offset, as shares of the limit.
    pub amplitudes: Vec<f64>,
    /// Bound of zig-zags, rad.
    pub bound: f64,
}

impl Default for GridOptions {
    fn default() -> GridOptions {
        GridOptions {
            length: 90.0,
            periods: vec![4.0, 7.0, 12.0, 20.0, 33.0],
            amplitudes: vec![0.4, 0.9],
            bound: std::f64::consts::FRAC_PI_3,
        }
    }
}

/// Share of the limit of an offset and of the sine about it.
const HALF: f64 = 0.45;
/// Share of the limit for the sine in the other degree of freedom of a pair.
const BESIDE: f64 = 0.6;
/// Periods of the multi-sines, s, in units of the longest period of the grid: no two in a simple ratio.
const TOGETHER: [f64; 9] = [0.94, 0.58, 0.34, 0.82, 0.49, 0.28, 0.70, 0.43, 0.22];

/// All candidates for `model` within the `limits` of thrust (N, N·m), in a fixed order. A degree of freedom without a
/// limit is not pushed; if heave is modelled and can be pushed, runs in other directions hold their depth.
pub fn grid(model: &Model, limits: &BTreeMap<Dof, f64>, options: &GridOptions) -> Vec<Manoeuvre> {
    let pushed: Vec<(Dof, f64)> =
        model.dofs.iter().filter_map(|dof| Some((*dof, *limits.get(dof).filter(|l| **l > 0.0)?))).collect();
    let mut made: Vec<(RunKind, Vec<Push>)> = Vec::new();
    for (dof, limit) in &pushed {
        for share in [HALF, -HALF, 2.0 * HALF, -2.0 * HALF] {
            made.push((RunKind::ConstantVelocity, vec![Push::constant(*dof, share * limit)]));
        }
        for period in &options.periods {
            for share in &options.amplitudes {
                made.push((RunKind::Oscillatory, vec![Push::sine(*dof, 0.0, share * limit, *period)]));
            }
            made.push((RunKind::Oscillatory, vec![Push::sine(*dof, HALF * limit, HALF * limit, *period)]));
        }
    }
    let longer = options.periods.iter().rev().step_by(2).take(2);
    for (steady, force) in &pushed {
        for (other, limit) in pushed.iter().filter(|(other, _)| other != steady) {
            for period in longer.clone() {
                let pair =
                    vec![Push::constant(*steady, HALF * force), Push::sine(*other, 0.0, BESIDE * limit, *period)];
                made.push((RunKind::Free, pair));
            }
        }
    }
    let limit_of = |wanted: Dof| pushed.iter().find(|(dof, _)| *dof == wanted).map(|(_, limit)| *limit);
    if let (Some(force), Some(moment)) = (limit_of(Dof::Surge), limit_of(Dof::Yaw)) {
        for (ahead, turn) in [(0.3, HALF), (0.6, HALF), (0.3, 2.0 * HALF), (0.6, 2.0 * HALF)] {
            let push =
                vec![Push::constant(Dof::Surge, ahead * force), Push::zigzag(Dof::Yaw, turn * moment, options.bound)];
            made.push((RunKind::Zigzag, push));
        }
    }
    if pushed.len() > 1 {
        for share in [0.15, 0.25] {
            made.push((RunKind::Free, multi_sine(&pushed, share, options)));
        }
    }
    let heave = limit_of(Dof::Heave);
    made.into_iter()
        .map(|(kind, mut pushes)| {
            if let Some(limit) = heave {
                let stiffness = if pushes.iter().any(|p| p.dof == Dof::Heave) { 0.15 } else { 0.6 } * limit;
                pushes.push(Push::hold(Dof::Heave, stiffness));
            }
            Manoeuvre { name: name_of(kind, &pushes), kind, length: options.length, pushes }
        })
        .collect()
}

/// Sines of three periods in every degree of freedom, surge about an offset.
fn multi_sine(pushed: &[(Dof, f64)], share: f64, options: &GridOptions) -> Vec<Push> {
    let longest = options.periods.iter().fold(0.0, |m: f64, p| m.max(*p));
    let mut sines = Vec::new();
    for (n, (dof, limit)) in pushed.iter().enumerate() {
        for part in 0..3 {
            let offset = if *dof == Dof::Surge && part == 0 { 0.25 * limit } else { 0.0 };
            let period = TOGETHER[(n * 3 + part) % TOGETHER.len()] * longest;
            sines.push(Push::sine(*dof, offset, share * limit, period));
        }
    }
    sines
}

/// Name of a run from its degrees of freedom, law and period: `surge_sine_12s`, `surge_yaw_zigzag`.
fn name_of(kind: RunKind, pushes: &[Push]) -> String {
    let mut dofs: Vec<&str> = pushes.iter().filter(|p| p.hold.is_none()).map(|p| p.dof.name()).collect();
    dofs.dedup();
    let law = match kind {
        RunKind::ConstantVelocity => "constant",
        RunKind::Zigzag => "zigzag",
        RunKind::Oscillatory => "sine",
        _ if dofs.len() == 2 && pushes.iter().filter(|p| p.hold.is_none()).count() == 2 => "pair",
        _ => "multisine",
    };
    let period = pushes.iter().find_map(|p| p.period).filter(|_| law != "multisine");
    let place = if law == "multisine" { "all".to_string() } else { dofs.join("_") };
    format!("{place}_{law}{}", period.map(|p| format!("_{p:.0}s")).unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Coriolis;

    #[test]
    fn candidates_keep_the_limits_and_push_what_can_be_pushed() {
        let dofs = [Dof::Surge, Dof::Sway, Dof::Heave, Dof::Yaw];
        let model = Model::with_effects(&dofs, Coriolis::Tied, &["inertia"]).unwrap();
        let limits = BTreeMap::from([(Dof::Surge, 30.0), (Dof::Heave, 20.0), (Dof::Yaw, 2.0), (Dof::Roll, 9.0)]);
        let all = grid(&model, &limits, &GridOptions::default());
        assert!(all.len() > 50, "{}", all.len());
        for one in &all {
            one.validate(&model, &limits).unwrap();
            assert!(one.pushes.iter().all(|p| p.dof != Dof::Sway && p.dof != Dof::Roll), "{one:?}");
            assert!(one.pushes.iter().any(|p| p.hold.is_some()), "depth is held");
        }
        for name in ["surge_constant", "yaw_sine_12s", "surge_yaw_zigzag", "surge_yaw_pair_33s", "all_multisine"] {
            assert!(all.iter().any(|m| m.name == name), "{name}");
        }
        assert!(grid(&model, &BTreeMap::new(), &GridOptions::default()).is_empty());
    }
}
