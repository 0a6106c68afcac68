//! Values that do not change: constant columns, samples held by a slower sensor, saturation, zero commands.

use std::collections::BTreeMap;

use super::super::codes;
use super::super::columns::{Quantity, quantity};
use super::super::number::short;
use super::hold::{self, Hold};
use super::statistics::range;
use super::{Seen, is_measured, is_velocity};
use crate::frame::Dof;
use crate::run::Signal;

/// Least number of samples that show repetition.
const FEWEST: usize = 8;

/// Runs these checks; columns with the same fault are one finding.
pub fn check(signals: &BTreeMap<String, Signal>) -> Vec<Seen> {
    let long = || signals.iter().filter(|(_, s)| s.len() >= FEWEST).map(|(n, s)| (n.as_str(), s.values(), s.time()));
    let mut seen = Vec::new();
    let constant: Vec<&str> =
        long().filter(|(n, x, _)| is_velocity(n) && lengths(x).len() == 1).map(|(n, ..)| n).collect();
    if !constant.is_empty() {
        let text = format!("{} never change: nothing can be learned from them", constant.join(", "));
        seen.push(Seen::new(codes::CONSTANT, &constant, None, text));
    }
    seen.extend(long().filter_map(|(name, x, _)| dead(name, x)));
    let held: Vec<(&str, Hold)> =
        long().filter(|(n, ..)| is_measured(n)).filter_map(|(n, x, _)| Some((n, hold::of(x)?))).collect();
    if let Some((_, hold)) = held.first() {
        let names: Vec<&str> = held.iter().map(|(n, _)| *n).collect();
        let text = format!(
            "{} keep each value for {} rows: samples of a slower sensor, repeated, and each treated as a measurement",
            names.join(", "),
            short(hold.rows, 3)
        );
        seen.push(Seen::new(codes::HELD, &names, None, text));
    }
    seen.extend(idle(signals));
    for (name, x, time) in long().filter(|(n, ..)| is_measured(n) || Dof::ALL.iter().any(|d| d.force() == *n)) {
        if let Some((first, limit, samples)) = saturated(x) {
            let text =
                format!("{name} stays at its extreme {} for {samples} samples: a limit was reached", short(limit, 6));
            seen.push(Seen::new(codes::SATURATION, &[name], time.get(first).copied(), text));
        }
    }
    seen
}

/// Finds a rate that varies but is always smaller than what any gyro shows. The Earth alone turns
/// at 7e-5 rad/s.
fn dead(name: &str, values: &[f64]) -> Option<Seen> {
    const LEAST: f64 = 1e-5;
    let rotation = Dof::ALL.iter().any(|dof| dof.is_rotation() && dof.velocity() == name);
    let most = values.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    if !rotation || most > LEAST || lengths(values).len() == 1 {
        return None;
    }
    let text = format!(
        "{name} never exceeds {} rad/s, less than any gyro shows at rest: the channel is dead, and nothing can be learned from it; \
         leave the column out",
        short(most, 2)
    );
    Some(Seen::new(codes::CONSTANT, &[name], None, text))
}

/// Finds commands that are all zero throughout. With load cells the vehicle is pulled and needs no
/// command.
fn idle(signals: &BTreeMap<String, Signal>) -> Option<Seen> {
    let is_force = |name: &str| matches!(quantity(name), Some(Quantity::Force | Quantity::Moment | Quantity::Command));
    let load = |name: &str| name == "force" || Dof::ALL.iter().any(|d| d.load() == name);
    let commands: Vec<(&str, &Signal)> =
        signals.iter().filter(|(name, _)| is_force(name)).map(|(name, s)| (name.as_str(), s)).collect();
    let zero = |s: &Signal| s.values().iter().all(|x| *x == 0.0);
    if commands.is_empty() || !commands.iter().all(|(name, s)| !load(name) && s.len() >= FEWEST && zero(s)) {
        return None;
    }
    let names: Vec<&str> = commands.iter().map(|(name, _)| *name).collect();
    let text = format!(
        "all commands are zero ({}): no force is known, and only free-decay motion can be fitted; if the vehicle was \
         driven, name the columns that hold its commands (columns.tau_u, columns.V1, …)",
        names.join(", ")
    );
    Some(Seen::new(codes::NO_COMMAND, &names, None, text))
}

/// Returns the lengths of the stretches of equal values.
fn lengths(values: &[f64]) -> Vec<usize> {
    values.chunk_by(|a, b| a.to_bits() == b.to_bits()).map(<[f64]>::len).collect()
}

/// Returns the first sample at the limit, the limit, and the number of samples there: at least one
/// in twenty, in stretches of four or more, while other values hardly ever repeat in consecutive
/// rows. A command with a few levels is not saturated.
pub fn saturated(values: &[f64]) -> Option<(usize, f64, usize)> {
    const STRETCH: usize = 4;
    let (low, high) = range(values.iter().copied())?;
    if low >= high {
        return None;
    }
    let stretches: Vec<&[f64]> = values.chunk_by(|a, b| a.to_bits() == b.to_bits()).collect();
    let inside = stretches.iter().filter(|s| s[0] > low && s[0] < high);
    let (moving, still) = inside.fold((0, 0), |(m, r), s| (m + 1, r + usize::from(s.len() > 1)));
    if 2 * moving < values.len() / 2 || 10 * still > moving {
        return None;
    }
    [low, high].into_iter().find_map(|limit| {
        let (mut at, mut first, mut samples) = (0, None, 0);
        for s in &stretches {
            if s[0].to_bits() == limit.to_bits() && s.len() >= STRETCH {
                first.get_or_insert(at);
                samples += s.len();
            }
            at += s.len();
        }
        // a command rests at zero
        first.filter(|_| 20 * samples >= values.len() && limit != 0.0).map(|first| (first, limit, samples))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(columns: &[(&str, &dyn Fn(usize) -> f64)]) -> Vec<Seen> {
        let time: std::sync::Arc<[f64]> = (0..200).map(|k| 0.1 * f64::from(k)).collect();
        let signal = |f: &dyn Fn(usize) -> f64| Signal::new(time.clone(), (0..200).map(f).collect::<Vec<_>>());
        check(&columns.iter().map(|(n, f)| ((*n).to_string(), signal(f))).collect())
    }

    #[allow(clippy::cast_precision_loss)]
    fn wave(k: usize) -> f64 {
        (0.1 * k as f64).sin()
    }

    #[test]
    fn held_samples_are_noticed() {
        let seen = run(&[
            ("u", &|k| wave(k / 5 * 5)),
            ("v", &|k| wave(k / 5 * 5)),
            ("r", &wave),
            ("tau_u", &|k| wave(k / 5 * 5)),
        ]);
        assert_eq!(seen.len(), 1);
        assert_eq!(seen[0].channels, ["u", "v"]);
        assert!(seen[0].text.contains("5 rows"));
    }

    #[test]
    fn constants_are_noticed() {
        let seen = run(&[("u", &|_| 0.4), ("v", &|_| 0.0), ("r", &wave)]);
        assert_eq!((seen.len(), seen[0].code), (1, codes::CONSTANT));
        assert_eq!(seen[0].channels, ["u", "v"]);
    }

    #[test]
    fn rates_that_no_gyro_shows_are_noticed() {
        let seen = run(&[("r", &|k| 1e-7 * wave(k)), ("u", &|k| 1e-7 * wave(k)), ("q", &|k| 1e-4 * wave(k))]);
        assert_eq!((seen.len(), seen[0].code, &seen[0].channels[..]), (1, codes::CONSTANT, &["r".to_string()][..]));
        assert!(seen[0].text.contains("1e-07 rad/s"), "{}", seen[0].text);
    }

    #[test]
    fn commands_that_are_all_zero_are_noticed() {
        let zero = |_: usize| 0.0;
        let seen = run(&[("u", &wave), ("tau_u", &zero), ("tau_r", &zero)]);
        assert_eq!((seen.len(), seen[0].code), (1, codes::NO_COMMAND));
        assert_eq!(seen[0].channels, ["tau_r", "tau_u"]);
        assert!(run(&[("u", &wave), ("tau_u", &wave), ("tau_r", &zero)]).is_empty());
        assert!(run(&[("u", &wave), ("load_u", &wave), ("tau_u", &zero)]).is_empty());
    }

    #[test]
    fn limits_are_noticed_and_levels_are_not() {
        let seen = run(&[("r", &|k| wave(k).min(0.8))]);
        assert_eq!((seen.len(), seen[0].code), (1, codes::SATURATION));
        assert!(run(&[("tau_r", &|k| if k / 30 % 2 == 0 { 50.0 } else { -50.0 })]).is_empty());
        assert!(run(&[("tau_u", &wave)]).is_empty());
    }
}
