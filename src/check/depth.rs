//! Vertical velocity compared with depth: units, sign, scale and lag.
//!
//! ```text
//! z(b) − z(a) = c ∫ w cos φ cos θ dt + d ∫ (v sin φ cos θ − u sin θ) dt + β (b − a)        f = 1/c = w over dz/dt
//! ```
//!
//! over windows [a, b]; z counts downwards, as w does; β is a constant bias, m/s. Missing angles and velocities count as
//! zero. Source: Fossen (2011), (2.17). If the signs disagree, the thrusters decide which of the two is wrong: w, if they
//! push it the wrong way.

use super::attitude::level_windows;
use super::change::Change;
use super::codes;
use super::factor::{Meaning, VELOCITY, meaning};
use super::lag;
use super::report::{Agreement, FaultKind, Found};
use super::samples::Samples;
use crate::log::number::short;
use crate::run::Run;

/// Shortest window, s: the noise of a depth is large compared with its change over a shorter one.
const WINDOW: f64 = 1.0;
/// Units in which a depth may be logged, and what one of them is in metres: the factor f of a depth in it.
const DEPTH: &[(f64, &str)] = &[(1e-3, "mm"), (1e-2, "cm"), (0.3048, "ft")];

/// Returns the agreement of `w` with the change of the depth.
pub fn measure(run: &Run) -> Option<Agreement> {
    let depth = Samples::of(run.signal("z")?)?;
    let w = Samples::of(run.signal("w")?)?;
    let angle = |name: &str| run.signal(name).and_then(Samples::of_angle);
    let velocity = |name: &str| run.signal(name).and_then(Samples::of);
    let (phi, theta) = (angle("phi"), angle("theta"));
    let (u, v) = (velocity("u"), velocity("v"));
    let at = |s: &Option<Samples>, t: f64| s.as_ref().map_or(0.0, |s| s.at(t));
    let own = w.map(|t, w| w * at(&phi, t).cos() * at(&theta, t).cos());
    let others = w.map(|t, _| {
        let ((sin_phi, _), (sin_theta, cos_theta)) = (at(&phi, t).sin_cos(), at(&theta, t).sin_cos());
        at(&v, t) * sin_phi * cos_theta - at(&u, t) * sin_theta
    });
    let (velocity, position) = (("w", &w), ("z", &depth));
    Change { velocity, position, own, others, window: WINDOW }.agreement(level_windows(run))
}

/// Returns the findings. `pushed_right`: whether the thrusters push `w` the right way, if that is known; `steps` gives the usual
/// step of a channel, s.
pub fn judge(agreement: &Agreement, pushed_right: Option<bool>, steps: impl Fn(&str) -> f64) -> Vec<Found> {
    let channels = ["w", "z"];
    let told = format!("w is {} ± {} times dz/dt", short(agreement.factor, 4), short(agreement.std, 2));
    let of_unit = |name: &str, channel: &str, factor: f64, reversed: bool| {
        let sign = if reversed { ", and one of the two has the opposite sign" } else { "" };
        let text = format!("{told}: most likely {channel} is in {name}{sign}; set columns.{channel}.unit = \"{name}\"");
        Found::new(&codes::UNIT, &channels, text).fault(FaultKind::Unit, channel, factor)
    };
    let mut found: Vec<Found> = match meaning(agreement.factor, agreement.std, 0.1, &[VELOCITY, DEPTH].concat()) {
        Meaning::Agrees | Meaning::Unknown => Vec::new(),
        Meaning::Reversed => vec![reversed(&told, pushed_right)],
        // no unit of a velocity makes the ratio this small
        Meaning::Unit(name, factor, reversed) if factor.abs() < 1.0 => vec![of_unit(name, "z", 1.0 / factor, reversed)],
        Meaning::Unit(name, factor, reversed) => vec![of_unit(name, "w", factor, reversed)],
        Meaning::Scale => {
            let text = format!("{told}: the scale of w or of z is wrong");
            vec![Found::new(&codes::SCALE, &channels, text).fault(FaultKind::Unit, "w", agreement.factor)]
        }
    };
    let slowest = steps("w").max(steps("z"));
    found.extend(lag::latency(agreement.lag, ["w", "z"], slowest.max(0.1), &channels));
    found
}

/// Returns the finding that w and z count opposite ways.
fn reversed(told: &str, pushed_right: Option<bool>) -> Found {
    let text = |wrong: &str| format!("{told}: one of the two has the opposite sign; {wrong}");
    let found = |wrong: &str| Found::new(&codes::SIGN, &["w", "z"], text(wrong));
    match pushed_right {
        Some(true) => found(
            "the thrusters push w the right way, so that z counts upwards (a height or an altitude): set columns.z.sign = -1, or \
             earth_frame = \"enu\" if x and y are east and north",
        )
        .fault(FaultKind::Sign, "z", -1.0),
        Some(false) => found("the thrusters push w the wrong way: set columns.w.sign = -1, or body_frame = \"flu\"")
            .fault(FaultKind::Sign, "w", -1.0),
        None => found(
            "z and w both count downwards here: set columns.z.sign = -1 if z is a height, columns.w.sign = -1 if w is positive \
             upwards",
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::Noise;
    use crate::run::Signal;

    /// A vehicle that heaves, pitches and advances; `w` and `z` multiplied by these factors.
    fn dive(of_w: f64, of_z: f64) -> Run {
        let time: std::sync::Arc<[f64]> = (0..600).map(|k| 0.1 * f64::from(k)).collect();
        let mut noise = Noise::new(7, 1);
        let motion = |t: f64| (0.4, 0.2 * (0.7 * t).sin(), 0.3 * (0.5 * t).cos());
        let mut depth = 5.0;
        let mut z = Vec::new();
        for t in time.iter() {
            z.push(of_z * (depth + 5e-3 * noise.normal()));
            // the middle of the step
            let (u, w, theta) = motion(t + 0.05);
            depth += 0.1 * (w * theta.cos() - u * theta.sin());
        }
        let w: Vec<f64> = time.iter().map(|t| of_w * (motion(*t).1 + 2e-3 * noise.normal())).collect();
        let mut run = Run::default();
        let of = |f: &dyn Fn(f64) -> f64| time.iter().map(|t| f(*t)).collect::<Vec<f64>>();
        for (name, values) in [("z", z), ("w", w), ("u", of(&|t| motion(t).0)), ("theta", of(&|t| motion(t).2))] {
            run.signals.insert(name.into(), Signal::new(time.clone(), values));
        }
        run
    }

    #[test]
    fn a_height_for_a_depth_is_told_and_the_thrusters_say_which_of_the_two_is_wrong() {
        let told =
            |of_w: f64, of_z: f64, pushed: Option<bool>| judge(&measure(&dive(of_w, of_z)).unwrap(), pushed, |_| 0.1);
        assert!(told(1.0, 1.0, Some(true)).is_empty());
        let height = &told(1.0, -1.0, Some(true))[0];
        assert!(*height.code == codes::SIGN && height.text.contains("set columns.z.sign = -1"), "{}", height.text);
        assert_eq!(height.faults[0].channel, "z");
        let upwards = &told(-1.0, 1.0, Some(false))[0];
        assert_eq!(upwards.faults[0].channel, "w");
        let unknown = &told(-1.0, 1.0, None)[0];
        assert!(unknown.faults.is_empty() && unknown.text.contains("columns.w.sign"), "{}", unknown.text);
    }

    #[test]
    fn units_and_scales_are_told_of_the_channel_that_has_them() {
        for (of_w, of_z, channel, unit, factor) in
            [(1.0, 100.0, "z", "cm", 100.0), (1e3, 1.0, "w", "mm/s", 1e3), (1.0, 1.0 / 0.3048, "z", "ft", 1.0 / 0.3048)]
        {
            let found = judge(&measure(&dive(of_w, of_z)).unwrap(), Some(true), |_| 0.1);
            let fault = &found[0].faults[0];
            assert!(found[0].text.contains(&format!("columns.{channel}.unit = \"{unit}\"")), "{}", found[0].text);
            assert!(fault.channel == channel && (fault.factor / factor - 1.0).abs() < 1e-9, "{fault:?}");
        }
        let half = judge(&measure(&dive(0.5, 1.0)).unwrap(), Some(true), |_| 0.1);
        assert_eq!(*half[0].code, codes::SCALE);
    }
}
