//! Behaviour of commands between two rows of a log: held, or linear.
//!
//! ```text
//! held: the motion comes Δt/2 behind commands on a line ([`between_rows`]);  else: a command mostly stays
//! ```
//!
//! A command that is sent holds until the next one; commands of a simulation may be linear between
//! rows. A zig-zag looks the same in both cases, and so does a sine. If the motion answers clearly,
//! it decides; else commands that mostly stay are held.
//!
//! The motion answers to the force: for commands of known thrusters that is the force by their
//! curves ([`crate::campaign::forces`]).

use crate::campaign::between_rows::between_rows;
use crate::log::check::time::usual_step;
use crate::log::number::short;
use crate::run::{Run, Signal};

/// The commands of a log, its number of rows, and all of its channels.
pub struct Commanded<'a> {
    pub signals: Vec<&'a Signal>,
    pub rows: usize,
    pub run: Run,
}

/// Share of unchanged rows above which a command counts as held.
const STAYS: f64 = 0.4;

/// Whether commands are held, with the reason; no reason if nothing tells.
pub fn commands_are_held(logs: &[Commanded<'_>]) -> (bool, Option<String>) {
    if logs.iter().any(|log| log.signals.iter().any(|s| s.len() < log.rows)) {
        return (true, Some("the commands have their own time stamps, as if each change is logged".into()));
    }
    let step = logs.iter().find_map(step);
    let told = step.and_then(|step| Some((between_rows(logs.iter().map(|log| &log.run), step)?, step)));
    if let Some((told, step)) = told {
        let why = format!(
            "the motion lags linearly interpolated commands by {} s; held commands would make it {}",
            short(told.delay, 2),
            short(0.5 * step, 3)
        );
        return (told.held, Some(why));
    }
    let stays = logs.iter().map(stays).fold(0.0, f64::max);
    let told = || format!("in {:.0} % of the rows a command equals that of the previous row", 100.0 * stays);
    (stays > STAYS, (stays > STAYS).then(told))
}

/// Time between the rows of commands, s.
fn step(log: &Commanded<'_>) -> Option<f64> {
    log.signals.first().and_then(|signal| usual_step(signal.time())).filter(|step| *step > 0.0)
}

/// Share of the rows that leave the commands of a log unchanged. A command that never changes is
/// not counted: it does not show how it changes.
fn stays(log: &Commanded<'_>) -> f64 {
    let (mut same, mut all) = (0_usize, 0_usize);
    for signal in &log.signals {
        let changes = signal.values().windows(2).filter(|w| w[0].to_bits() != w[1].to_bits()).count();
        if changes > 0 {
            all += signal.len() - 1;
            same += signal.len() - 1 - changes;
        }
    }
    if all > 0 { same as f64 / all as f64 } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(values: &[f64], rows: usize) -> (bool, Option<String>) {
        let time: Vec<f64> = (0..values.len()).map(|k| k as f64).collect();
        let signal = Signal::new(time.into(), values.to_vec());
        commands_are_held(&[Commanded { signals: vec![&signal], rows, run: Run::default() }])
    }

    #[test]
    fn without_a_motion_commands_that_mostly_stay_are_held() {
        assert!(
            of(&[1500.0, 1500.0, 1600.0, 1600.0, 1600.0, 1400.0], 6)
                .1
                .is_some_and(|why| why.contains("60 % of the rows"))
        );
        assert_eq!(of(&[0.0, 1.0, 2.0, 3.0], 4), (false, None));
        assert!(of(&[0.0, 0.0, 0.0, 3.0], 4).0);
        assert!(!of(&[0.0, 0.0, 0.0, 0.0], 4).0, "what never changes says nothing of how");
        assert!(of(&[0.0, 1.0], 4).0, "stamps of its own");
    }

    /// u̇ = (τ − 20 u)/100 in steps of 10 ms; rows are 0.2 s apart, and τ is held between them or on lines.
    #[test]
    fn the_motion_tells_held_commands_from_lines() {
        const STEP: f64 = 0.2;
        let command = |row: usize| if (row / 40).is_multiple_of(2) { 60.0 } else { -60.0 };
        let sailed = |is_held: bool, channel: &str| {
            let (mut u, mut rows) = (0.0, Vec::new());
            for row in 0..600 {
                rows.push(u);
                for part in 0..20 {
                    let along = (f64::from(part) + 0.5) / 20.0;
                    let line = command(row) + (command(row + 1) - command(row)) * along;
                    let tau = if is_held { command(row) } else { line };
                    u += (tau - 20.0 * u) / 100.0 * STEP / 20.0;
                }
            }
            let time: std::sync::Arc<[f64]> = (0..600).map(|k| STEP * f64::from(k)).collect();
            let tau = Signal::new(time.clone(), (0..600).map(command).collect::<Vec<_>>());
            let mut noise = crate::noise::Noise::new(7, 1);
            let u: Vec<f64> = rows.iter().map(|u| u + 0.003 * noise.normal()).collect();
            let signals = [(channel.to_string(), Signal::new(time, u)), ("tau_u".to_string(), tau.clone())];
            let run = Run { signals: signals.into(), ..Run::default() };
            commands_are_held(&[Commanded { signals: vec![&tau], rows: 600, run }])
        };
        for is_held in [true, false] {
            let (found, why) = sailed(is_held, "u");
            let why = why.unwrap();
            assert!(found == is_held && why.starts_with("the motion lags"), "{is_held}: {found}, {why}");
        }
        // a turn rate alone is not used: the motion along the axes is not known
        assert!(sailed(false, "r").1.is_some_and(|why| why.starts_with("in 98 % of the rows")));
    }
}
