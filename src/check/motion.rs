//! Which degrees of freedom a log measures, and whether they move beyond the noise of their sensors.
//!
//! ```text
//! moves:  x₀.₉₅ − x₀.₀₅ > max(6 σ, least)        σ = median |second difference| / (0.6745 √6)
//! ```
//!
//! A rate may be smaller if the angle is logged, too, and shows that the vehicle turns: a ship
//! takes minutes for a zig-zag.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use super::codes;
use super::report::Found;
use crate::frame::Dof;
use crate::log::check::statistics::quantile;
use crate::run::{Run, RunKind, Signal};

/// State of a degree of freedom in a log.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Moved {
    /// Neither its velocity nor its position is measured.
    Unmeasured,
    /// Measured, but within the noise of its sensor or below the least spread.
    Rests,
    /// It moves.
    Moves,
}

/// Least spread that counts as motion: of a velocity, m/s, and of a position, m; of a rate, rad/s,
/// and of an angle, rad. Below it a vehicle drifts or is held.
const LEAST: [[f64; 2]; 2] = [[0.03, 0.1], [0.03, 0.1]];

/// Returns the state of `dof` in a log.
pub fn of(signals: &BTreeMap<String, Signal>, dof: Dof) -> Moved {
    let velocity = signals.get(dof.velocity());
    let [fast, slow] = LEAST[usize::from(dof.is_rotation())];
    match velocity.or_else(|| pose(signals, dof)) {
        None => Moved::Unmeasured,
        Some(signal) => {
            let least = if velocity.is_some() { fast } else { slow };
            // roll and pitch follow the thrust of every vehicle a little; a model of them needs
            // more than that
            let tilt = if matches!(dof, Dof::Roll | Dof::Pitch) { 3.0 } else { 1.0 };
            let spread = spread(signal);
            let turns =
                || dof.is_rotation() && signals.get(dof.position()).is_some_and(|angle| turned(angle) > slow * tilt);
            let is_motion = spread > least * tilt || (velocity.is_some() && turns());
            if spread > 6.0 * signal.white_noise() && is_motion { Moved::Moves } else { Moved::Rests }
        }
    }
}

/// Returns the position or angle that shows the motion if no velocity is logged.
fn pose(signals: &BTreeMap<String, Signal>, dof: Dof) -> Option<&Signal> {
    let own = signals.get(dof.position());
    match dof {
        // north and east give no surge and sway without the heading
        Dof::Surge | Dof::Sway => own.filter(|_| ["x", "y", "psi"].iter().all(|c| signals.contains_key(*c))),
        _ => own,
    }
}

/// Finds a free run in which nothing moves, so that there is nothing to learn from it.
pub fn judge(run: &Run) -> Vec<Found> {
    let measured: Vec<Dof> = Dof::ALL.into_iter().filter(|dof| of(&run.signals, *dof) > Moved::Unmeasured).collect();
    let held = matches!(run.kind, RunKind::Bollard | RunKind::Towing | RunKind::Bench);
    if held || measured.is_empty() || measured.iter().any(|dof| of(&run.signals, *dof) == Moved::Moves) {
        return Vec::new();
    }
    let channel = |dof: &Dof| if run.signals.contains_key(dof.velocity()) { dof.velocity() } else { dof.position() };
    let channels: Vec<&str> = measured.iter().map(channel).collect();
    let text = format!(
        "the vehicle is at rest: {} stay within the noise of their sensors or below what counts as motion; there is \
         nothing to learn from this run",
        channels.join(", ")
    );
    vec![Found::new(&codes::AT_REST, &channels, text)]
}

/// Range from the 5th to the 95th percentile.
fn spread(signal: &Signal) -> f64 {
    let at = |p| quantile(signal.values().iter().copied(), p).unwrap_or(0.0);
    at(0.95) - at(0.05)
}

/// Range from the 5th to the 95th percentile of the unwrapped angle, rad: a compass may step from π
/// to −π.
fn turned(angle: &Signal) -> f64 {
    let mut whole = vec![0.0];
    for w in angle.values().windows(2) {
        let step = w[1] - w[0];
        whole.push(whole[whole.len() - 1] + step - TAU * (step / TAU).round());
    }
    spread(&Signal::new(angle.time().into(), whole))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::tank::Noise;

    fn log(name: &str, value: impl Fn(f64) -> f64) -> BTreeMap<String, Signal> {
        let time: Vec<f64> = (0..600).map(|k| 0.1 * f64::from(k)).collect();
        let values: Vec<f64> = time.iter().map(|t| value(*t)).collect();
        BTreeMap::from([(name.to_string(), Signal::new(time.into(), values))])
    }

    #[test]
    fn a_run_at_rest_is_told_and_a_bollard_run_is_not() {
        let still = Run { signals: log("psi", |_| 1.0), ..Run::default() };
        assert_eq!(judge(&still).len(), 1);
        let turning = Run { signals: log("psi", |t| 0.1 * t), ..Run::default() };
        let bollard = Run { kind: RunKind::Bollard, ..still };
        assert!(judge(&turning).is_empty() && judge(&bollard).is_empty());
    }

    #[test]
    fn motion_is_told_from_noise() {
        let noise = std::cell::RefCell::new(Noise::new(1, 1));
        assert_eq!(of(&log("u", |t| (0.3 * t).sin()), Dof::Surge), Moved::Moves);
        assert_eq!(of(&log("u", |_| 0.5 * noise.borrow_mut().normal()), Dof::Surge), Moved::Rests);
        assert_eq!(of(&log("psi", |t| (0.3 * t).sin()), Dof::Yaw), Moved::Moves);
        assert_eq!(of(&log("theta", |t| 0.05 * (0.3 * t).sin()), Dof::Pitch), Moved::Rests);
        assert_eq!(of(&log("x", |t| (0.3 * t).sin()), Dof::Surge), Moved::Unmeasured);
    }

    #[test]
    fn a_ship_turns_slowly_and_a_held_vehicle_does_not() {
        let noise = std::cell::RefCell::new(Noise::new(1, 1));
        // 0.5 degrees a second over a zig-zag of four minutes, the compass across south
        let rate = |t: f64| 0.009 * (0.026 * t).sin() + 1e-4 * noise.borrow_mut().normal();
        let mut ship = log("r", rate);
        assert_eq!(of(&ship, Dof::Yaw), Moved::Rests, "a drift without an angle that says that it turns");
        ship.extend(log("psi", |t| (3.0 - 0.35 * (0.026 * t).cos() + PI).rem_euclid(TAU) - PI));
        assert_eq!(of(&ship, Dof::Yaw), Moved::Moves);
        let mut held = log("r", |_| 0.009 * noise.borrow_mut().normal());
        held.extend(log("psi", |t| 3.0 - 0.01 * (0.026 * t).cos()));
        assert_eq!(of(&held, Dof::Yaw), Moved::Rests);
    }
}
