//! The kind of a run by its channels: a bench, a bollard, a carriage that tows, or free motion.

use super::reading::Understood;
use crate::frame::Dof;
use crate::log::LogFile;
use crate::log::check::statistics::{quantile, range};
use crate::run::{Signal, is_command};

/// Upper limit of the motion of a vehicle that is held: m/s or rad/s of a velocity, m or rad of a
/// position.
const HELD: f64 = 0.05;

/// Kind of the run of these logs, with the reason if it is not free motion.
pub fn of(logs: &[&Understood]) -> (&'static str, Option<String>) {
    let signals = || logs.iter().filter_map(|log| log.log.as_ref()).flat_map(|log| &log.signals);
    let signal = |name: &str| signals().find(|(own, _)| *own == name).map(|(_, signal)| signal);
    let loaded: Vec<Dof> = Dof::ALL.into_iter().filter(|dof| signal(dof.load()).is_some()).collect();
    if loaded.is_empty() {
        let moves = Dof::ALL.iter().any(|dof| signal(dof.velocity()).or(signal(dof.position())).is_some());
        let why = "a command and a force, but no motion: one thruster on a bench";
        let is_bench = signal("force").is_some() && !moves;
        return if is_bench { ("bench", Some(why.into())) } else { ("free", None) };
    }
    let speed = |dof: &Dof| signal(dof.velocity()).and_then(|s| quantile(s.values().iter().map(|x| x.abs()), 0.95));
    let way = |dof: &Dof| range(signal(dof.position())?.values().iter().copied()).map(|(low, high)| high - low);
    let moving: Vec<&str> = loaded
        .iter()
        .filter_map(|dof| match speed(dof) {
            Some(speed) => (speed > HELD).then_some(dof.velocity()),
            None => way(dof).filter(|way| *way > HELD).map(|_| dof.position()),
        })
        .collect();
    let is_commanded = |name: &str, signal: &Signal| is_command(name) && signal.varies();
    let commands: Vec<&str> = signals().filter(|(n, s)| is_commanded(n, s)).map(|(name, _)| name.as_str()).collect();
    let loads: Vec<&str> = loaded.iter().map(|dof| dof.load()).collect();
    let loads = loads.join(", ");
    match (moving.is_empty(), commands.is_empty()) {
        (false, true) => {
            let moving = moving.join(", ");
            ("towing", Some(format!("{loads} and {moving}, but no command: it is towed")))
        }
        (false, false) => {
            let (moving, commands) = (moving.join(", "), commands.join(", "));
            let text = format!(
                "with doubt: {loads} and {moving}, and the command {commands}: towed with the thrusters on, or held and not quite at \
                 rest (kind = \"bollard\")"
            );
            ("towing", Some(text))
        }
        (true, false) => ("bollard", Some(format!("{loads} and a command, but no motion: it is held"))),
        (true, true) => ("bollard", Some(format!("with doubt: {loads}, but neither a command nor a speed"))),
    }
}

/// Whether a log is of one thruster on a bench.
pub fn is_bench(log: &Understood) -> bool {
    of(&[log]).0 == "bench"
}

/// Whether a log is of a vehicle that is towed in this degree of freedom.
pub fn is_towed(log: &Understood, dof: Dof) -> bool {
    let is_measured = |log: &LogFile| log.signals.contains_key(dof.load()) && log.signals.contains_key(dof.velocity());
    log.log.as_ref().is_some_and(is_measured) && of(&[log]).0 == "towing"
}
