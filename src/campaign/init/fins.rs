//! The sign of a fin's angle, from the turns in all logs together ([`crate::check::fins`]).

use super::reading::Understood;
use crate::check::fins::{self, Gain};
use crate::effects::id;
use crate::log::options::ColumnSource;

/// Reverses the angle of a fin that turns the vehicle the wrong way in some log and the right way
/// in none. Returns the logs to read again.
pub fn settle(logs: &mut [Understood]) -> Vec<usize> {
    let gains: Vec<Gain> = logs.iter().filter_map(Understood::as_run).flat_map(|run| fins::measure(&run)).collect();
    let mut turned = Vec::new();
    for channel in id::fins().map(|fin| fin.channel) {
        let any = |is: fn(&Gain) -> bool| gains.iter().any(|gain| gain.channel == channel && is(gain));
        if !any(Gain::is_reversed) || any(Gain::is_right) {
            continue;
        }
        for (k, log) in logs.iter_mut().enumerate() {
            let has = log.log.as_ref().is_some_and(|read| read.signals.contains_key(channel));
            if has && !log.given.columns.contains_key(channel) {
                turn_round(log, channel);
                turned.push(k);
            }
        }
    }
    turned.sort_unstable();
    turned.dedup();
    turned
}

fn turn_round(log: &mut Understood, channel: &str) {
    let source = log.options.columns.entry(channel.into()).or_insert_with(|| ColumnSource::from(channel));
    source.sign = -source.sign;
    let key = format!("columns.{channel}");
    let before = log.reasons.get(&key).map_or(String::new(), |why| format!("{why}; "));
    log.guess(key, format!("{before}sign reversed: in the log a positive angle turns the vehicle the other way"));
}
