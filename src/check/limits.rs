//! Commands of thrusters compared with what the thrusters take.
//!
//! ```text
//! another unit:    max |V| ≥ 5 V_max        or        0 < max |V| ≤ dead band
//! ```
//!
//! V_max and the dead band are those of the `[[thruster]]` table. A command a little beyond the limit saturates; one
//! several times beyond it, as per cent for a command of ±1 or a pulse width, is in another unit, and so is one that
//! never leaves the dead band: the thruster, as described, never turns.

use super::codes;
use super::report::{FaultKind, Found};
use crate::log::number::short;
use crate::run::{Run, thruster_command};
use crate::thrust::thruster::Thruster;

/// Ratio of the greatest command to the limit from which on it is in another unit: the limit of a bollard table may well
/// lie below that of the thruster.
const BEYOND: f64 = 5.0;
/// Pulse widths that controllers of thrusters receive, µs.
const PULSES: std::ops::RangeInclusive<f64> = 800.0..=2300.0;
/// Per cent of a full command.
const PER_CENT: f64 = 100.0;

/// Returns a finding for the commands beyond all limits, and one for those that never leave a dead band.
pub fn judge(run: &Run, thrusters: &[Thruster]) -> Vec<Found> {
    let commands = thrusters.iter().enumerate().filter_map(|(k, thruster)| {
        let channel = thruster_command(k);
        let most = run.signal(&channel)?.values().iter().fold(0.0, |most: f64, v| most.max(v.abs()));
        Some((channel, most, thruster))
    });
    let commands: Vec<(String, f64, &Thruster)> = commands.collect();
    let chosen = |is: &dyn Fn(f64, &Thruster) -> bool| -> Vec<&(String, f64, &Thruster)> {
        commands.iter().filter(|(_, most, thruster)| is(*most, thruster)).collect()
    };
    let beyond = chosen(&|most, thruster| thruster.max.is_some_and(|max| most >= BEYOND * max));
    let within = chosen(&|most, thruster| 0.0 < most && most <= thruster.deadband);
    // a thruster that hardly turns in this run is no fault: the others move the vehicle
    let turns = commands.iter().any(|(_, most, thruster)| *most > thruster.deadband);
    let within = if turns { Vec::new() } else { within };
    [beyond_limits(&beyond), within_deadbands(&within)].into_iter().flatten().collect()
}

/// Returns the greatest of the commands and the names of their channels; `None` without any.
fn named<'a>(commands: &[&'a (String, f64, &Thruster)]) -> Option<(f64, Vec<&'a str>)> {
    let most = commands.iter().map(|(_, most, _)| *most).max_by(f64::total_cmp)?;
    Some((most, commands.iter().map(|(channel, ..)| channel.as_str()).collect()))
}

fn beyond_limits(commands: &[&(String, f64, &Thruster)]) -> Option<Found> {
    let (most, channels) = named(commands)?;
    let limit = commands.iter().filter_map(|(.., thruster)| thruster.max).max_by(f64::total_cmp)?;
    let found = |unit: &str| {
        let text = format!(
            "{} go up to {}, and their thrusters take {} at most (`max`): {unit} of these columns",
            channels.join(", "),
            short(most, 3),
            short(limit, 3)
        );
        Found::new(&codes::COMMAND_UNIT, &channels, text)
    };
    Some(if PULSES.contains(&most) {
        found("most likely they are pulse widths: set neutral and span in [[thruster]], and unit = \"us\"")
    } else if most <= 1.1 * PER_CENT * limit {
        let per_cent = found("most likely they are in per cent: set scale = 0.01");
        channels.iter().fold(per_cent, |found, channel| found.fault(FaultKind::Unit, channel, PER_CENT))
    } else {
        found("they are in another unit: set unit or scale")
    })
}

fn within_deadbands(commands: &[&(String, f64, &Thruster)]) -> Option<Found> {
    let (most, channels) = named(commands)?;
    let text = format!(
        "{} stay within the dead band of their thrusters, {} at most: as described, these never turn; the commands are in \
         another unit (unit or scale of these columns), or `deadband` is wrong",
        channels.join(", "),
        short(most, 3)
    );
    Some(Found::new(&codes::COMMAND_UNIT, &channels, text))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::Signal;
    use crate::thrust::curve::Coefficients;

    fn told(commands: [f64; 2]) -> Vec<Found> {
        let side = Coefficients { a: 38.0, b: 13.0 };
        let thruster = |name: &str| Thruster {
            name: name.into(),
            position: [0.0; 3],
            axis: [1.0, 0.0, 0.0],
            forward: side,
            reverse: side,
            bollard: None,
            deadband: 0.06,
            max: Some(1.0),
            neutral: None,
            span: None,
            supply: None,
        };
        let mut run = Run::default();
        for (k, most) in commands.into_iter().enumerate() {
            let signal = Signal::new(vec![0.0, 1.0, 2.0].into(), vec![0.0, most, -most]);
            run.signals.insert(thruster_command(k), signal);
        }
        judge(&run, &[thruster("port"), thruster("starboard")])
    }

    #[test]
    fn commands_in_another_unit_are_told_with_it() {
        assert!(told([1.0, 1.0]).is_empty() && told([0.0, 0.5]).is_empty(), "a thruster at rest is no fault");
        assert!(told([2.0, 1.0]).is_empty(), "saturation");
        let per_cent = &told([90.0, 60.0])[0];
        assert!(
            per_cent.text.contains("V1, V2 go up to 90") && per_cent.text.contains("per cent"),
            "{}",
            per_cent.text
        );
        assert!(per_cent.faults.len() == 2 && per_cent.faults[0].factor > 99.0);
        let pulses = &told([1900.0, 1500.0])[0];
        assert!(pulses.text.contains("pulse widths") && pulses.faults.is_empty(), "{}", pulses.text);
        let small = &told([0.01, 0.009])[0];
        assert!(small.text.contains("stay within the dead band"), "{}", small.text);
    }
}
