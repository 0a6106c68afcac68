//! Degrees or radians of a heading and its rate, decided together.
//!
//! ```text
//! k = Σ Δψ ∫r / Σ (∫r)²        k = 1: ψ and r are of one kind, both in degrees or both in radians
//! ```
//!
//! Something else must tell the unit: a jump of a full turn, the path over x and y, the other
//! angles, or a rate that no vehicle reaches. An unwrapped heading exceeds any limit in either
//! unit.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use super::reading::Understood;
use super::values::{STEP, TOO_FAST, most, ratio, set, unit_is_open};
use crate::check::path;
use crate::frame::Dof;
use crate::log::LogFile;
use crate::log::options::ColumnSource;
use crate::navigation::unwrap;
use crate::run::{Run, Signal};

/// Upper limit of roll and pitch in radians.
pub const UPRIGHT: f64 = 3.2;
/// Six turns in radians: a heading beyond, of which nothing else tells the unit, is more likely in
/// degrees.
const MANY_TURNS: f64 = 40.0;
/// Range of k for a heading and a rate in the same kind of unit.
const ONE_KIND: std::ops::Range<f64> = 0.6..1.6;

/// The unit of a heading, with the reason.
enum Told {
    Degrees(String),
    Radians(String),
}

/// Sets the unit of the heading, and of a rate of the same kind, in all logs whose heading column
/// has one name.
pub fn settle(logs: &mut [Understood]) {
    let mut alike: BTreeMap<String, Vec<usize>> = BTreeMap::new();
    for (k, log) in logs.iter().enumerate() {
        let is_there = log.log.as_ref().is_some_and(|read| read.signals.contains_key("psi"));
        if is_there && unit_is_open("psi", log) {
            alike.entry(header(log)).or_default().push(k);
        }
    }
    for group in alike.into_values() {
        let told: Vec<(usize, Option<Told>)> =
            group.iter().map(|k| (*k, logs[*k].log.as_ref().and_then(|log| told(&logs[*k], log)))).collect();
        let degrees = told.iter().filter(|(_, t)| matches!(t, Some(Told::Degrees(_)))).count();
        let radians = told.iter().filter(|(_, t)| matches!(t, Some(Told::Radians(_)))).count();
        if degrees + radians == 0 {
            doubt(logs, &group);
            continue;
        }
        let is_degrees = degrees >= radians;
        let is_doubtful = |k: &usize| logs[*k].log.as_ref().is_some_and(|log| goes_beyond_radians(&log.signals["psi"]));
        // without a unit the reader takes radians: they are stated only if the numbers alone would
        // suggest degrees
        let is_said = is_degrees || group.iter().any(is_doubtful);
        let witness = told.iter().find(|(_, t)| matches!(t, Some(Told::Degrees(_))) == is_degrees && t.is_some());
        let shown = witness.map_or_else(String::new, |(k, _)| logs[*k].shown.clone());
        for (k, own) in told {
            let why = match own {
                Some(Told::Degrees(why) | Told::Radians(why)) if degrees * radians == 0 => why,
                Some(Told::Degrees(why)) if is_degrees => why,
                Some(Told::Radians(why)) if !is_degrees => why,
                Some(Told::Degrees(why) | Told::Radians(why)) => {
                    format!("as in most logs with this column, but with doubt: in this log {why}")
                }
                None => format!("as the column of this name in {shown}"),
            };
            if is_said {
                set(&mut logs[k], "psi", if is_degrees { "deg" } else { "rad" }, &why);
            }
        }
    }
}

/// Whether the heading by itself suggests degrees.
pub fn goes_beyond_radians(psi: &Signal) -> bool {
    wraps(psi, 360.0) || most(psi) > MANY_TURNS && !wraps(psi, TAU)
}

fn header(log: &Understood) -> String {
    log.options.columns.get("psi").map_or("psi", |source| source.name.as_str()).to_string()
}

/// Whether an angle jumps by a full turn.
fn wraps(angle: &Signal, turn: f64) -> bool {
    angle.values().windows(2).any(|w| ((w[1] - w[0]).abs() - turn).abs() < 0.15 * turn)
}

/// The unit of a log's heading, by the first of several indications that decides.
fn told(this: &Understood, log: &LogFile) -> Option<Told> {
    let psi = &log.signals["psi"];
    if wraps(psi, 360.0) {
        return Some(Told::Degrees("it jumps by 360".into()));
    }
    if wraps(psi, TAU) && most(psi) < 10.0 {
        return Some(Told::Radians("it jumps by a full turn of 6.28".into()));
    }
    let rate = log.signals.get("r");
    // taken as degrees, a heading in radians has small values: unwrapping finds no jump in it
    let of_rate = rate.and_then(|r| ratio(psi, r, PI / 180.0, STEP)).map(|k| k.abs() * 180.0 / PI);
    if let Some(k) = of_rate.filter(|_| !unit_is_open("r", this)) {
        let said = |is: &str| format!("it is {k:.3} times the integral of r, whose unit is known: {is}");
        if ONE_KIND.contains(&k) {
            return Some(Told::Radians(said("radians")));
        }
        if ONE_KIND.contains(&(k * PI / 180.0)) {
            return Some(Told::Degrees(said("degrees")));
        }
    }
    let way = |is: &str| format!("the velocity over x, y turns as much as psi does in {is}");
    if turns_of_way(log, PI / 180.0).is_some_and(|turns| turns < 0.1) {
        return Some(Told::Radians(way("radians")));
    }
    if turns_of_way(log, 1.0).is_some_and(|turns| turns > 10.0) {
        return Some(Told::Degrees(way("degrees")));
    }
    let one_kind = of_rate.is_some_and(|k| ONE_KIND.contains(&k));
    if let Some(r) = rate.filter(|r| one_kind && most(r) > TOO_FAST) {
        return Some(Told::Degrees(format!("its rate reaches {:.0}, impossible for a vehicle in rad/s", most(r))));
    }
    // ψ and r are of different kinds: the ratio tells which one is in degrees
    if let Some(k) = of_rate.filter(|k| ONE_KIND.contains(&(k * PI / 180.0))) {
        return Some(Told::Degrees(format!("it is {k:.1} times the integral of r")));
    }
    if let Some(k) = of_rate.filter(|k| ONE_KIND.contains(&(k * 180.0 / PI))) {
        return Some(Told::Radians(format!("it is {k:.3} times the integral of r")));
    }
    let tilt = [Dof::Roll, Dof::Pitch].into_iter().filter_map(|dof| log.signals.get(dof.position())).map(most);
    let open = [Dof::Roll, Dof::Pitch].iter().any(|dof| unit_is_open(dof.position(), this));
    if tilt.fold(0.0, f64::max) > UPRIGHT && open {
        return Some(Told::Degrees("as the other angles of this log".into()));
    }
    (rate.is_none() && turns_too_fast(psi)).then(|| {
        Told::Degrees(format!("it reaches {:.0}, and in radians it would turn faster than any vehicle", most(psi)))
    })
}

/// Whether a heading in radians would turn faster than any vehicle.
fn turns_too_fast(psi: &Signal) -> bool {
    let (Some(from), Some(to)) = (psi.time().first(), psi.time().last()) else { return false };
    let steps = ((to - from) / STEP) as usize;
    let turn = |k: usize| psi.at(from + STEP * (k + 1) as f64) - psi.at(from + STEP * k as f64);
    (0..steps).any(|k| turn(k).abs() > TOO_FAST * STEP)
}

/// Ratio of the turn of the heading times `factor` to the turn of the path over x and y; `None` if
/// the path does not tell.
fn turns_of_way(log: &LogFile, factor: f64) -> Option<f64> {
    let psi = log.signals.get("psi")?;
    let mut run = Run { signals: log.signals.clone(), ..Run::default() };
    let turned: Arc<[f64]> = unwrap(&psi.values().iter().map(|x| x * factor).collect::<Vec<_>>()).into();
    run.signals.insert("psi".into(), Signal::new(psi.shared_time().clone(), turned));
    path::measure(&run, ["x", "y"]).filter(|path| !path.contradicted).map(|path| path.turns)
}

/// Sets degrees for a heading with large values of which nothing tells the unit, with radians as
/// the alternative.
fn doubt(logs: &mut [Understood], group: &[usize]) {
    let goes_far = |k: &usize| logs[*k].log.as_ref().map_or(0.0, |log| most(&log.signals["psi"]));
    let far = group.iter().map(goes_far).fold(0.0, f64::max);
    if far <= MANY_TURNS {
        return;
    }
    for k in group {
        let why = format!("with doubt: it reaches {far:.0}, and nothing else tells degrees from radians");
        set(&mut logs[*k], "psi", "deg", &why);
        let name = header(&logs[*k]);
        let other = ColumnSource { unit: Some("rad".into()), ..ColumnSource::from(name.as_str()) };
        logs[*k].choices.entry("psi".into()).or_default().push(other);
        let signals = logs[*k].log.as_ref().map(|log| (&log.signals["psi"], log.signals.get("r")));
        let turns = signals.and_then(|(psi, r)| ratio(psi, r?, PI / 180.0, STEP)).map(|k| k.abs() * 180.0 / PI);
        if turns.is_some_and(|k| ONE_KIND.contains(&k)) && unit_is_open("r", &logs[*k]) {
            set(&mut logs[*k], "r", "deg/s", "with doubt: psi is its integral, so both use the same angle unit");
            let name = logs[*k].options.columns["r"].name.clone();
            let other = ColumnSource { unit: Some("rad/s".into()), ..ColumnSource::from(name.as_str()) };
            logs[*k].choices.entry("r".into()).or_default().push(other);
        }
    }
}
