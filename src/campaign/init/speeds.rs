//! Units of velocities by their range, and a check for positions that change faster than any
//! vehicle moves.

use std::collections::BTreeMap;

use super::reading::Understood;
use super::values::{set, unit_is_open};
use super::words;
use crate::frame::Dof;
use crate::log::check::statistics::quantile;
use crate::log::options::ColumnSource;
use crate::run::Signal;

/// The degrees of freedom along the axes of the body.
const ALONG: [Dof; 3] = [Dof::Surge, Dof::Sway, Dof::Heave];
/// A speed that no vehicle under or on the water reaches, m/s.
const TOO_FAST: f64 = 40.0;
/// Limit between a vehicle's speed in cm/s, below, and in mm/s, mostly above.
const CENTIMETRES: f64 = 300.0;
/// Part of the samples that defines the range: the rest may be outliers.
const MOST: f64 = 0.98;
/// Time over which a position is compared with a speed, s: long against its noise.
const SPAN: f64 = 1.0;

/// Sets the units of velocities by their range in all logs, and reports positions that cannot be
/// right.
pub fn settle(logs: &mut [Understood]) {
    let mut greatest: BTreeMap<Vec<String>, f64> = BTreeMap::new();
    for log in logs.iter() {
        for (_, name, range) in open(log) {
            let most = greatest.entry(name).or_default();
            *most = most.max(range);
        }
    }
    for log in logs {
        for (channel, name, _) in open(log) {
            velocity(log, channel, greatest[&name]);
        }
        for dof in ALONG {
            position(log, dof.position());
        }
    }
}

/// Velocities whose unit is open: channel, words of the name without the axis, and range.
fn open(this: &Understood) -> Vec<(&'static str, Vec<String>, f64)> {
    let Some(log) = &this.log else { return Vec::new() };
    let of = |channel: &'static str| {
        let signal = log.signals.get(channel).filter(|_| unit_is_open(channel, this))?;
        let mut name = words::of(this.options.columns.get(channel).map_or(channel, |s| s.name.as_str())).words;
        name.pop();
        Some((channel, name, quantile(signal.values().iter().map(|x| x.abs()), MOST).unwrap_or(0.0)))
    };
    ALONG.map(Dof::velocity).into_iter().filter_map(of).collect()
}

/// Sets millimetres or centimetres a second if metres would be too fast.
fn velocity(this: &mut Understood, channel: &str, most: f64) {
    if most <= TOO_FAST {
        return;
    }
    let (unit, other) = if most > CENTIMETRES { ("mm/s", None) } else { ("cm/s", Some("mm/s")) };
    set(this, channel, unit, &format!("velocities of this name reach {most:.0}, impossible for a vehicle in m/s"));
    if let Some(other) = other {
        let source = ColumnSource { unit: Some(other.into()), ..this.options.columns[channel].clone() };
        this.choices.entry(channel.into()).or_default().push(source);
    }
}

/// Reports doubt about a position that changes faster than any vehicle moves.
fn position(this: &mut Understood, channel: &str) {
    let key = format!("columns.{channel}");
    let Some(signal) = this.log.as_ref().and_then(|log| log.signals.get(channel)) else { return };
    let Some(speed) = usual_speed(signal).filter(|speed| *speed > TOO_FAST) else { return };
    if this.given.columns.contains_key(channel) {
        return;
    }
    let doubt = format!(
        "with doubt: in metres it moves at {speed:.0} m/s, impossible for a vehicle: another unit (scale = 0.001 for \
         mm), or not a position"
    );
    match this.reasons.get(&key).cloned() {
        Some(reason) => this.guess(key, format!("{reason}, {doubt}")),
        None => this.remarks.push(format!("guessed: {channel} is the position by its name, {doubt}")),
    }
}

/// The median speed of a position.
fn usual_speed(position: &Signal) -> Option<f64> {
    let (from, to) = (*position.time().first()?, *position.time().last()?);
    let steps = ((to - from) / SPAN) as usize;
    let at = |k: usize| position.at(from + SPAN * k as f64);
    quantile((0..steps).map(|k| (at(k + 1) - at(k)).abs() / SPAN), 0.5)
}
