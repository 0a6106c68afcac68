//! Forces that stay within ±1: parts of the full command, which the model reads as newtons.

use super::reading::Understood;
use super::values::{most, unit_is_open};
use crate::frame::Dof;
use crate::log::columns;

/// Upper limit of a part of the full command.
const FULL: f64 = 1.05;

/// Adds a remark to forces without a unit that are parts of the full command in all logs: the
/// parameters then come out in units of the full command.
pub fn settle(logs: &mut [Understood]) {
    for channel in Dof::ALL.map(Dof::force) {
        let of = |log: &Understood| log.log.as_ref()?.signals.get(channel).map(most);
        let greatest = logs.iter().filter_map(of).fold(0.0, f64::max);
        if greatest <= 0.0 || greatest > FULL {
            continue;
        }
        let unit = columns::quantity(channel).and_then(|q| q.units().first()).map_or("N", |unit| unit.name);
        for log in logs.iter_mut() {
            if of(log).is_none() || !unit_is_open(channel, log) {
                continue;
            }
            let key = format!("columns.{channel}");
            let text = format!(
                "it stays within ±1, a fraction of the full command, and is read in {unit}: masses and drags come out \
                 in units of the full command (scale = … of {channel} says how many {unit} that is)"
            );
            match log.reasons.get(&key).cloned() {
                Some(reason) => log.guess(key, format!("{reason}; {text}")),
                None => log.remarks.push(format!("guessed: {channel}: {text}")),
            }
        }
    }
}
