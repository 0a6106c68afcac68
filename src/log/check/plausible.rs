//! Implausible values for an underwater vehicle: whole columns in another unit, single absurd samples.

use std::collections::BTreeMap;

use super::super::codes;
use super::super::columns::{Quantity, quantity};
use super::super::number::short;
use super::statistics::{quantile, range};
use super::{Seen, turning};
use crate::frame::Dof;
use crate::run::Signal;

/// Largest plausible 90 % quantile of |x| of a column; above it another unit is more likely. 15 m/s
/// is faster than any vehicle of this kind, 3 rad/s is a turn in two seconds, 3π rad is more than
/// one turn in roll or pitch.
fn usual(quantity: Quantity) -> f64 {
    match quantity {
        Quantity::Velocity => 15.0,
        Quantity::Rate => 3.0,
        Quantity::Angle => 3.0 * std::f64::consts::PI,
        _ => f64::INFINITY,
    }
}

/// Largest plausible 90 % quantile of a rate that its angle confirms, rad/s: two turns per second.
const SPIN: f64 = 12.0;

/// Largest plausible magnitude of a single sample of this channel.
pub fn limit(name: &str) -> f64 {
    match quantity(name) {
        Some(Quantity::Velocity | Quantity::Rate) => 100.0,
        Some(Quantity::Angle | Quantity::Command) => 1e5,
        Some(_) => 1e8,
        // auxiliary: only values whose sums and squares overflow
        None => 1e100,
    }
}

/// Checks units and single samples.
pub fn check(signals: &BTreeMap<String, Signal>) -> Vec<Seen> {
    let mut seen: Vec<Seen> = signals.iter().filter_map(|(name, s)| unit(name, s, signals)).collect();
    seen.extend(pulse_widths(signals));
    if !seen.iter().any(|s| s.channels.iter().any(|c| c == "phi")) {
        seen.extend(signals.get("phi").and_then(upside_down));
    }
    for (name, signal) in signals {
        if !seen.iter().any(|s| s.channels.contains(name)) {
            seen.extend(magnitude(name, signal));
        }
    }
    seen
}

/// Finds a column that is too large as a whole.
fn unit(name: &str, signal: &Signal, signals: &BTreeMap<String, Signal>) -> Option<Seen> {
    let quantity = quantity(name)?;
    let usual = usual(quantity);
    let large = quantile(signal.values().iter().map(|x| x.abs()), 0.9)?;
    // a heading may be unwrapped over many turns
    if usual.is_infinite() || large <= usual || (name == "psi" && !wraps_at_360(signal.values())) {
        return None;
    }
    let own_angle = Dof::ALL.iter().find(|dof| dof.velocity() == name).and_then(|dof| signals.get(dof.position()));
    if quantity == Quantity::Rate
        && large <= SPIN
        && own_angle.is_some_and(|angle| turning::in_radians(angle) && turning::agree(signal, angle))
    {
        return None;
    }
    let si = quantity.units().first()?.name;
    let other = match quantity {
        Quantity::Velocity if large > 150.0 => "mm/s",
        Quantity::Velocity => "cm/s",
        Quantity::Rate => "deg/s",
        _ => "deg",
    };
    let text = format!(
        "{name} reaches {} {si}, which no vehicle does; if it is {other} write the header as {name} [{other}] or set columns.{name}.unit",
        short(large, 4)
    );
    Some(Seen::new(codes::UNIT, &[name], None, text))
}

/// Whether this is a heading in degrees: between −180 and 360, with at least one jump by a full turn.
fn wraps_at_360(values: &[f64]) -> bool {
    range(values.iter().copied()).is_some_and(|(a, b)| a >= -180.5 && b <= 360.5)
        && values.windows(2).any(|w| ((w[1] - w[0]).abs() - 360.0).abs() < 30.0)
}

/// Finds forces or commands that are pulse widths in microseconds: all columns of the group lie
/// between 800 and 2300 with a median of 1000 to 2000, and they are several, or whole numbers only.
fn pulse_widths(signals: &BTreeMap<String, Signal>) -> Vec<Seen> {
    let is_pulse = |s: &Signal| {
        s.len() > 1
            && s.values().iter().all(|x| (800.0..=2300.0).contains(x))
            && quantile(s.values().iter().copied(), 0.5).is_some_and(|m| (1000.0..=2000.0).contains(&m))
    };
    let whole = |s: &Signal| s.values().iter().all(|x| x.fract() == 0.0);
    let mut seen = Vec::new();
    let groups: [fn(&str) -> bool; 2] =
        [|name| name.starts_with("tau_"), |name| quantity(name) == Some(Quantity::Command)];
    for in_group in groups {
        let group: Vec<(&str, &Signal)> =
            signals.iter().filter(|(n, _)| in_group(n)).map(|(n, s)| (n.as_str(), s)).collect();
        // one column around 1000 N may be a strong thruster; several such columns, or whole
        // numbers, are not
        if !group.is_empty()
            && group.iter().all(|(_, s)| is_pulse(s))
            && (group.len() > 1 || group.iter().all(|(_, s)| whole(s)))
        {
            let names: Vec<&str> = group.iter().map(|(n, _)| *n).collect();
            let text = format!(
                "{} lie between 800 and 2300 around a common offset: these are pulse widths in us, not forces or \
                 volts; name them V1, V2, … with unit us and give each thruster its neutral and span",
                names.join(", ")
            );
            seen.push(Seen::new(codes::UNIT, &names, None, text));
        }
    }
    seen
}

/// Finds a vehicle that is upside down most of the time: more likely its axes are wrong.
fn upside_down(phi: &Signal) -> Option<Seen> {
    let usual = quantile(phi.values().iter().map(|x| x.cos()), 0.5)?;
    let text = "phi is beyond 90° most of the time, so the vehicle would be upside down: check body_frame (frd or flu) \
                and earth_frame (ned or enu)";
    (usual < 0.0).then(|| Seen::new(codes::FRAME, &["phi"], None, text.to_string()))
}

/// Finds single samples above the limit.
fn magnitude(name: &str, signal: &Signal) -> Option<Seen> {
    let limit = limit(name);
    let mut beyond = signal.values().iter().enumerate().filter(|(_, x)| x.abs() > limit);
    let (first, x) = beyond.next()?;
    let more = beyond.count();
    let count = if more > 0 { format!(" ({} such samples)", more + 1) } else { String::new() };
    let text = format!("{} is beyond anything a vehicle does{count}", short(*x, 6));
    Some(Seen::new(codes::MAGNITUDE, &[name], signal.time().get(first).copied(), text))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn signals(columns: &[(&str, &dyn Fn(f64) -> f64)]) -> BTreeMap<String, Signal> {
        let time: std::sync::Arc<[f64]> = (0..200).map(|k| 0.1 * f64::from(k)).collect();
        let signal = |f: &dyn Fn(f64) -> f64| Signal::new(time.clone(), time.iter().map(|t| f(*t)).collect::<Vec<_>>());
        columns.iter().map(|(n, f)| ((*n).to_string(), signal(f))).collect()
    }

    #[test]
    fn other_units_are_noticed() {
        let seen = check(&signals(&[
            ("u", &|t| 700.0 * t.sin()),
            ("v", &|t| 0.7 * t.sin()),
            ("q", &|t| 20.0 * t.sin()),
            ("theta", &|t| 35.0 * t.sin()),
            ("psi", &|t| 3.0 * t),
        ]));
        let channels: Vec<&str> = seen.iter().map(|s| s.channels[0].as_str()).collect();
        assert_eq!(channels, ["q", "theta", "u"]);
        assert!(seen.iter().all(|s| s.code == codes::UNIT));
    }

    /// A vehicle that spins at 4.56 rad/s with wrapped heading: the rate is not in degrees per second.
    #[test]
    fn a_fast_turn_that_its_angle_confirms_is_no_other_unit() {
        let rate = |t: f64| 4.56 + 0.2 * t.sin();
        let turned = |t: f64| 4.56 * t - 0.2 * (t.cos() - 1.0);
        let wrapped = |t: f64| turned(t) - std::f64::consts::TAU * (turned(t) / std::f64::consts::TAU).round();
        assert!(check(&signals(&[("r", &rate), ("psi", &wrapped)])).is_empty());
        // a finding without the angle, with an angle that does not turn, with an unwrapped angle,
        // and with a rate 20 times too large
        assert_eq!(check(&signals(&[("r", &rate)])).len(), 1);
        assert_eq!(check(&signals(&[("r", &rate), ("psi", &|t| 0.1 * t.sin())])).len(), 1);
        assert_eq!(check(&signals(&[("r", &rate), ("psi", &turned)])).len(), 1);
        assert_eq!(check(&signals(&[("r", &|t| 20.0 * rate(t)), ("psi", &wrapped)])).len(), 1);
    }

    #[test]
    fn pulse_widths_are_noticed_and_large_forces_are_not() {
        let pwm = |t: f64| (1500.0 + 300.0 * t.sin()).round();
        let seen = check(&signals(&[("tau_u", &pwm), ("tau_r", &pwm)]));
        assert!(seen.len() == 1 && seen[0].text.contains("tau_u"));
        assert!(check(&signals(&[("tau_u", &|t| 1500.0 + 300.0 * t.sin()), ("tau_r", &f64::sin)])).is_empty());
        assert_eq!(check(&signals(&[("V1", &pwm)])).len(), 1);
    }

    #[test]
    fn a_vehicle_upside_down_is_noticed() {
        let seen = check(&signals(&[("phi", &|t| 3.1 + 0.1 * t.sin())]));
        assert_eq!((seen.len(), seen[0].code), (1, codes::FRAME));
        assert!(check(&signals(&[("phi", &|t| 0.4 * t.sin())])).is_empty());
    }

    #[test]
    fn one_absurd_sample_is_named() {
        let seen = check(&signals(&[("u", &|t| if (t - 1.0).abs() < 0.01 { -1e300 } else { 0.1 })]));
        assert_eq!((seen.len(), seen[0].code, seen[0].time), (1, codes::MAGNITUDE, Some(1.0)));
    }
}
