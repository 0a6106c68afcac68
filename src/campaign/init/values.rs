//! Properties that names leave open, found from the values: degrees or radians, unit and sign of a
//! rate.
//!
//! ```text
//! k = Σ Δψ ∫r / Σ (∫r)²        k = 1: same units;  1/57.3: r in deg/s;  57.3: ψ in deg;  k < 0: other sign
//! ```

use std::collections::BTreeSet;

use super::reading::Understood;
use super::turning;
use crate::effects::id;
use crate::frame::Dof;
use crate::log::columns;
use crate::log::options::{ColumnSource, LogOptions};
use crate::log::{LogFile, check};
use crate::navigation::unwrap;
use crate::run::Signal;

/// Step over which a change of an angle is compared with the integral of its rate, s.
pub(super) const STEP: f64 = 0.5;
/// Median of a depth column, m, below which it counts as a height: the error of a sensor at the
/// surface is smaller.
const SURFACED: f64 = -0.2;
/// A rate in rad/s that no vehicle reaches.
pub(super) const TOO_FAST: f64 = 6.0;

/// Sets units and signs by the values.
pub fn settle(this: &mut Understood) {
    let Some(log) = this.log.clone() else { return };
    let given = this.given.clone();
    let open = |channel: &str, this: &Understood| unit_is_open(channel, this);
    angles(this, &log, &open);
    deflections(this, &log, &open);
    rates(this, &log, &open, &given);
}

/// Numbers of rows over which the turn of a log with a row counter is compared: enough for a
/// heading to show it.
const ROWS: [f64; 3] = [10.0, 50.0, 200.0];
/// Relative deviation up to which a sample rate is rounded to a whole number of hertz.
const WHOLE: f64 = 0.02;

/// Finds the time of a row from heading and yaw rate if the time is a counter of rows. Returns
/// whether it was found.
///
/// ```text
/// dt = Σ Δψ ∫r / Σ (∫r)²        over rows in place of seconds
/// ```
pub fn counter(this: &mut Understood) -> bool {
    let Some(log) = this.log.clone().filter(|_| !this.given.columns.contains_key("t")) else { return false };
    let Some(source) = this.options.columns.get("t").cloned() else { return false };
    let said = this.options.time_unit.is_some() || this.options.time_format.is_some();
    if said || !check::time::is_counter(&source.name, &log.time) {
        return false;
    }
    let reason = this.reasons.get("columns.t").cloned().unwrap_or_default();
    let counts = format!("{reason}; it counts rows");
    let Some(step) = row(this, &log) else {
        let text = format!(
            "{counts}, but their rate is unknown: one row per second is assumed, which is unlikely. Write the time per \
             row, for 10 Hz columns.t = {{ name = {:?}, scale = 0.1 }}",
            source.name
        );
        this.guess("columns.t", text);
        return false;
    };
    let (rate, whole) = (1.0 / step, (1.0 / step).round());
    let is_whole = whole >= 1.0 && (rate / whole - 1.0).abs() < WHOLE;
    let rate = if is_whole { whole } else { format!("{rate:.2e}").parse().unwrap_or(rate) };
    this.options.columns.insert("t".into(), ColumnSource { scale: 1.0 / rate, ..source });
    this.guess("columns.t", format!("{counts}, {rate} a second: psi is {step:.4} times the sum of r over the rows"));
    true
}

/// Time of a row, s; `None` if heading and yaw rate do not tell it.
fn row(this: &Understood, log: &LogFile) -> Option<f64> {
    let (psi, r) = (log.signals.get("psi")?, log.signals.get("r")?);
    let turn = std::f64::consts::PI / 180.0;
    let of_psi = if unit_is_open("psi", this) && turning::goes_beyond_radians(psi) { turn } else { 1.0 };
    let of_r = if unit_is_open("r", this) && most(r) > TOO_FAST { turn } else { 1.0 };
    ROWS.into_iter().find_map(|rows| ratio(psi, r, of_psi, rows)).map(|k| k.abs() / of_r)
}

/// Whether the unit of a channel is open: neither the user nor the header states it, and none was
/// found.
pub(super) fn unit_is_open(channel: &str, this: &Understood) -> bool {
    let header = this.options.columns.get(channel).map_or(channel, |s| s.name.as_str());
    let said = this.options.columns.get(channel).is_some_and(|s| s.unit.is_some());
    !this.given.columns.contains_key(channel) && !said && columns::split_header(header).1.is_none()
}

/// Sets degrees for a column in all logs if a column of the same name was found to be in degrees in
/// one: the values of a short or quiet log do not tell.
pub fn agree(logs: &mut [Understood]) {
    let channels = Dof::ALL[3..].iter().flat_map(|dof| [dof.position(), dof.velocity()]);
    for channel in channels.chain(id::fins().map(|fin| fin.channel)) {
        let found = logs.iter().find_map(|log| {
            let source = log.options.columns.get(channel)?;
            let turned = source.unit.as_deref().filter(|unit| unit.starts_with("deg"))?;
            Some((source.name.clone(), turned.to_string(), log.shown.clone()))
        });
        let Some((header, unit, shown)) = found else { continue };
        for log in logs.iter_mut() {
            let same = log.options.columns.get(channel).map_or(channel, |s| s.name.as_str()) == header;
            let there = log.log.as_ref().is_some_and(|read| read.signals.contains_key(channel));
            if same && there && unit_is_open(channel, log) {
                set(log, channel, &unit, &format!("as the column of this name in {shown}"));
            }
        }
    }
}

type Open<'a> = &'a dyn Fn(&str, &Understood) -> bool;

/// Sets the unit of a column, with the reason.
pub(super) fn set(this: &mut Understood, channel: &str, unit: &str, why: &str) {
    let source = this.options.columns.entry(channel.to_string()).or_insert_with(|| ColumnSource::from(channel));
    source.unit = Some(unit.to_string());
    let key = format!("columns.{channel}");
    let text = match this.reasons.get(&key) {
        Some(reason) => format!("{reason}; {unit}: {why}"),
        None => format!("{channel} is in {unit}: {why}"),
    };
    this.guess(key, text);
}

/// Largest absolute value.
pub(super) fn most(signal: &Signal) -> f64 {
    signal.values().iter().fold(0.0, |m: f64, x| m.max(x.abs()))
}

/// Sets degrees if roll or pitch exceeds what radians can mean. The heading is decided before, with
/// its rate ([`super::turning`]).
fn angles(this: &mut Understood, log: &LogFile, open: Open<'_>) {
    let mut found = this.options.columns.get("psi").is_some_and(|s| s.unit.as_deref() == Some("deg"));
    for name in [Dof::Roll, Dof::Pitch].map(Dof::position) {
        let Some(signal) = log.signals.get(name).filter(|_| open(name, this)) else { continue };
        if most(signal) > turning::UPRIGHT {
            set(this, name, "deg", &format!("it reaches {:.0}", most(signal)));
            found = true;
        }
    }
    // all angles of a log have the same unit
    for dof in [Dof::Roll, Dof::Pitch, Dof::Yaw].into_iter().filter(|_| found) {
        if log.signals.contains_key(dof.position()) && open(dof.position(), this) {
            set(this, dof.position(), "deg", "as the other angles of this log");
        }
    }
}

/// Sets degrees if a fin in radians would stand across the flow or beyond.
fn deflections(this: &mut Understood, log: &LogFile, open: Open<'_>) {
    for name in id::fins().map(|fin| fin.channel) {
        let Some(signal) = log.signals.get(name).filter(|_| open(name, this)) else { continue };
        if most(signal) > std::f64::consts::FRAC_PI_2 {
            set(this, name, "deg", &format!("it reaches {:.0}", most(signal)));
        }
    }
}

/// Sets unit and sign of a rate by its angle, else the unit by its size.
fn rates(this: &mut Understood, log: &LogFile, open: Open<'_>, given: &LogOptions) {
    for dof in [Dof::Roll, Dof::Pitch, Dof::Yaw] {
        let (rate, angle) = (dof.velocity(), dof.position());
        let Some(signal) = log.signals.get(rate).filter(|_| !given.columns.contains_key(rate)) else { continue };
        let degrees = this.options.columns.get(angle).is_some_and(|s| s.unit.as_deref() == Some("deg"));
        // the log was read before the unit of the angle was known
        let before = if degrees && !reads_degrees(log, angle) { std::f64::consts::PI / 180.0 } else { 1.0 };
        let related = log.signals.get(angle).and_then(|a| ratio(a, signal, before, STEP));
        match related {
            Some(k) if (1.0 / 75.0..1.0 / 45.0).contains(&k.abs()) && open(rate, this) => {
                set(this, rate, "deg/s", &format!("{angle} is {:.3} times its integral", k.abs()));
            }
            Some(k) if (45.0..75.0).contains(&k.abs()) && open(angle, this) => {
                set(this, angle, "deg", &format!("it is {:.1} times the integral of {rate}", k.abs()));
            }
            None if open(rate, this) && most(signal) > TOO_FAST => {
                set(this, rate, "deg/s", &format!("it reaches {:.0}, impossible for a vehicle in rad/s", most(signal)));
            }
            _ => {}
        }
        if dof == Dof::Yaw {
            this.turns = related;
        }
        if let Some(k) = related.filter(|k| *k < 0.0 && dof == Dof::Yaw) {
            let source = this.options.columns.entry(rate.to_string()).or_insert_with(|| ColumnSource::from(rate));
            source.sign = -source.sign;
            let key = format!("columns.{rate}");
            let why = format!("sign = {}: {angle} turns the other way, {k:.3} times its integral", source.sign);
            let text = this.reasons.get(&key).map_or_else(|| format!("{rate}: {why}"), |r| format!("{r}; {why}"));
            this.guess(key, text);
        }
    }
}

/// Whether the values of the log have already been converted to radians.
fn reads_degrees(log: &LogFile, angle: &str) -> bool {
    log.signals.get(angle).is_some_and(|s| most(s) < 10.0)
}

/// k = Σ Δψ ∫r / Σ (∫r)² over steps of time; `None` if there are few steps, or the two hardly move
/// or correlate.
pub(super) fn ratio(angle: &Signal, rate: &Signal, factor: f64, step: f64) -> Option<f64> {
    let radians: Vec<f64> = angle.values().iter().map(|x| x * factor).collect();
    let unwrapped = Signal::new(angle.shared_time().clone(), unwrap(&radians));
    let (from, to) = (rate.time().first()?.max(*angle.time().first()?), rate.time().last()?.min(*angle.time().last()?));
    let steps = ((to - from) / step) as usize;
    let mut integral = vec![0.0];
    for w in 1..rate.len() {
        let dt = rate.time()[w] - rate.time()[w - 1];
        integral.push(integral[w - 1] + 0.5 * dt * (rate.values()[w] + rate.values()[w - 1]));
    }
    let turned = Signal::new(rate.shared_time().clone(), integral);
    let change = |s: &Signal, k: usize| s.at(from + step * (k + 1) as f64) - s.at(from + step * k as f64);
    let pairs: Vec<(f64, f64)> = (0..steps).map(|k| (change(&unwrapped, k), change(&turned, k))).collect();
    let sum = |f: &dyn Fn(&(f64, f64)) -> f64| pairs.iter().map(f).sum::<f64>();
    let (xy, xx, yy) = (sum(&|p| p.0 * p.1), sum(&|p| p.1 * p.1), sum(&|p| p.0 * p.0));
    // below this correlation one does not determine the other
    (pairs.len() >= 10 && xx > 0.0 && yy > 1e-4 && (xy * xy) > 0.8 * xx * yy).then(|| xy / xx)
}

/// Reverses the sign of a negative depth, which is a height, in all logs whose depth column has one
/// name: the median of all their samples decides.
pub fn depth(logs: &mut [Understood]) {
    let is_named = |source: &ColumnSource| source.sign > 0 && source.name.to_lowercase().contains("depth");
    let named = |log: &Understood| {
        let source = log.options.columns.get("z").filter(|source| is_named(source))?;
        (!log.given.columns.contains_key("z")).then(|| source.name.clone())
    };
    let middle = |values: &[f64]| check::statistics::median(values.iter().copied()).unwrap_or(0.0);
    let own = |log: &Understood| Some(log.log.as_ref()?.signals.get("z")?.values().to_vec());
    let names: BTreeSet<String> = logs.iter().filter_map(named).collect();
    for name in names {
        let alike: Vec<usize> = (0..logs.len()).filter(|k| named(&logs[*k]).as_ref() == Some(&name)).collect();
        let all: Vec<f64> = alike.iter().filter_map(|k| own(&logs[*k])).flatten().collect();
        let (usual, upwards) = (middle(&all), middle(&all) < SURFACED);
        for k in alike {
            let Some(here) = own(&logs[k]).map(|values| middle(&values)) else { continue };
            let differs = (here < SURFACED) != upwards;
            if !upwards && !differs {
                continue;
            }
            if upwards && let Some(source) = logs[k].options.columns.get_mut("z") {
                source.sign = -1;
            }
            let reason = logs[k].reasons.get("columns.z").cloned().unwrap_or_default();
            let counts = if upwards { "upwards, so sign = -1" } else { "downwards" };
            let doubt = format!("with doubt: in {} it is about {here:.1}", logs[k].shown);
            let doubt = if differs { format!(", {doubt}") } else { String::new() };
            logs[k].guess("columns.z", format!("{reason}; it is about {usual:.1}: it counts {counts}{doubt}"));
        }
    }
}
