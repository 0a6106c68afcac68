//! What commands do between two rows of a log: they are held, or change on a line.
//!
//! ```text
//! held: d̂ > Δt/4      d̂: delay of the motion behind commands on a line ([`behind_lines`])
//! ```
//!
//! Commands that are sent stay until the next one comes; commands that somebody has simulated may be lines. A zig-zag looks the
//! same in both, and so does a sine. Where the motion answers clearly, it decides; else commands that mostly stay are held.
//!
//! What the motion answers is the force: of commands whose thrusters are known that of their curves ([`Commanded::pushed_by`]).

use crate::campaign::behind_lines::behind_lines;
use crate::frame::Dof;
use crate::log::check::time::usual_step;
use crate::log::number::short;
use crate::run::{Run, Signal};
use crate::thrust::thruster::Thruster;

/// The commands of a log, its number of rows, and all of its channels.
pub struct Commanded<'a> {
    pub signals: Vec<&'a Signal>,
    pub rows: usize,
    pub run: Run,
}

/// Share of rows that leave a command as it was, from which on it is held.
const STAYS: f64 = 0.4;

/// Commands beyond this are pulse widths, µs.
const PULSES: f64 = 100.0;

impl Commanded<'_> {
    /// The same with the wrench that its thrusters make at the stamps of the first one, where each of them is commanded.
    pub fn pushed_by(mut self, thrusters: &[Thruster]) -> Self {
        let forces: Option<Vec<Signal>> =
            thrusters.iter().enumerate().map(|(k, of)| force(of, self.run.signal(&format!("V{}", k + 1))?)).collect();
        let Some(forces) = forces else { return self };
        let Some(time) = forces.first().map(|first| first.shared_time().clone()) else { return self };
        if forces.iter().any(|force| force.len() != time.len()) {
            return self;
        }
        for dof in Dof::ALL.into_iter().filter(|dof| thrusters.iter().any(|thruster| thruster.pushes(*dof))) {
            let at = |k: usize| {
                thrusters.iter().zip(&forces).map(|(of, f)| of.unit_wrench()[dof.index()] * f.values()[k]).sum()
            };
            let wrench: Vec<f64> = (0..time.len()).map(at).collect();
            self.run.signals.entry(dof.force().into()).or_insert_with(|| Signal::new(time.clone(), wrench));
        }
        self
    }
}

/// Force along the axis of a thruster, by its curve; `None` where its pulses cannot be read.
fn force(thruster: &Thruster, command: &Signal) -> Option<Signal> {
    let (curve, is_pulse) = (thruster.curve(), command.values().iter().any(|x| x.abs() > PULSES));
    let of = |x: &f64| Some(curve.force(if is_pulse { thruster.command_of_pulse(*x).ok()? } else { *x }));
    let forces: Option<Vec<f64>> = command.values().iter().map(of).collect();
    Some(Signal::new(command.shared_time().clone(), forces?))
}

/// Whether commands are held, with the reason; no reason where nothing speaks for either.
pub fn commands_are_held(logs: &[Commanded<'_>]) -> (bool, Option<String>) {
    if logs.iter().any(|log| log.signals.iter().any(|s| s.len() < log.rows)) {
        return (true, Some("the commands have time stamps of their own, as where each change is logged".into()));
    }
    let asked = logs.iter().find_map(|log| step(log));
    if let Some((delay, step)) =
        asked.and_then(|step| Some((behind_lines(logs.iter().map(|log| &log.run), step)?, step)))
    {
        let told = format!(
            "the motion comes {} s behind commands on lines between the rows; held ones would make it {}",
            short(delay, 2),
            short(0.5 * step, 3)
        );
        return (delay > 0.25 * step, Some(told));
    }
    let stays = logs.iter().map(stays).fold(0.0, f64::max);
    let told = || format!("in {:.0} % of the rows a command is what it was in the row before", 100.0 * stays);
    (stays > STAYS, (stays > STAYS).then(told))
}

/// Time between the rows of commands, s.
fn step(log: &Commanded<'_>) -> Option<f64> {
    log.signals.first().and_then(|signal| usual_step(signal.time())).filter(|step| *step > 0.0)
}

/// Share of the rows that leave the commands of a log as they were; one that never changes says nothing of how it changes.
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
            assert!(found == is_held && why.starts_with("the motion comes"), "{is_held}: {found}, {why}");
        }
        // a rate of turn alone is not asked: the motion along is not known
        assert!(sailed(false, "r").1.is_some_and(|why| why.starts_with("in 98 % of the rows")));
    }
}
