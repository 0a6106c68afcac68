//! The sign of a fin's angle, as the turns of all logs together tell it ([`crate::check::fins`]).

use super::reading::Understood;
use crate::check::fins;
use crate::log::options::ColumnSource;
use crate::run::Run;

/// Turns round the angle of a fin that turns the vehicle the other way in some log, and in none the right way. Gives the logs that
/// are to be read again.
pub fn settle(logs: &mut [Understood]) -> Vec<usize> {
    let run = |log: &Understood| Some(Run { signals: log.log.as_ref()?.signals.clone(), ..Run::default() });
    let gains: Vec<fins::Gain> = logs.iter().filter_map(run).flat_map(|run| fins::measure(&run)).collect();
    let mut turned = Vec::new();
    for gain in gains.iter().filter(|gain| gain.is_reversed()) {
        let right = |other: &fins::Gain| {
            other.channel == gain.channel && fins::Gain { value: -other.value, ..*other }.is_reversed()
        };
        if gains.iter().any(right) {
            continue;
        }
        for (k, log) in logs.iter_mut().enumerate() {
            let has = log.log.as_ref().is_some_and(|read| read.signals.contains_key(gain.channel));
            if !has || turned.contains(&k) || log.given.columns.contains_key(gain.channel) {
                continue;
            }
            let source =
                log.options.columns.entry(gain.channel.into()).or_insert_with(|| ColumnSource::from(gain.channel));
            source.sign = -source.sign;
            let key = format!("columns.{}", gain.channel);
            let before = log.reasons.get(&key).map_or(String::new(), |why| format!("{why}; "));
            log.guess(key, format!("{before}turned round: a positive angle turns the vehicle the other way than here"));
            turned.push(k);
        }
    }
    turned
}
