//! Gaps of the log and of single sensors, and the unit of time.

use std::collections::BTreeMap;

use super::super::codes;
use super::super::columns;
use super::super::number::short;
use super::statistics::median;
use super::{Seen, is_measured};
use crate::frame::Dof;
use crate::run::{Run, Signal};

/// Factor by which a step must exceed the usual one to be a gap: single lost samples are no gap.
const GAP: f64 = 5.0;
/// Longest pause that is no gap for a sensor of any rate, s: a vehicle changes its motion too
/// little within it to make a straight line across misleading. A recorder that pauses for some
/// milliseconds cuts nothing.
const PAUSE: f64 = 0.2;
/// Range of plausible usual steps, s: a sample every 5 s shows no dynamics, and no sensor samples
/// at 10 kHz.
const STEPS: (f64, f64) = (1e-4, 5.0);

/// Median step, s; `None` with fewer than two stamps.
pub fn usual_step(time: &[f64]) -> Option<f64> {
    median(time.windows(2).map(|w| w[1] - w[0]))
}

/// Indices of the stamps at which a gap ends: steps of more than five times the median, and more than 0.2 s.
pub fn gaps(time: &[f64]) -> Vec<usize> {
    let Some(step) = usual_step(time) else { return Vec::new() };
    (1..time.len()).filter(|&k| time[k] - time[k - 1] > (GAP * step).max(PAUSE)).collect()
}

/// Whether the rows are a clock: a measured channel has a sample in every row, or no channel is
/// measured. Where sensors of different rates are written side by side, the rows are no clock, and
/// each sensor is judged by its own stamps.
fn rows_are_a_clock(time: &[f64], signals: &BTreeMap<String, Signal>) -> bool {
    let mut measured = signals.iter().filter(|(name, _)| is_measured(name)).peekable();
    measured.peek().is_none() || measured.any(|(_, s)| s.len() == time.len())
}

/// Returns the stamps at which a gap of the whole log ends, s: a gap of its rows or, if these are
/// no clock, of all sensors together.
pub fn log_gaps(time: &[f64], signals: &BTreeMap<String, Signal>) -> Vec<f64> {
    match rows_are_a_clock(time, signals) {
        true => gaps(time).into_iter().map(|k| time[k]).collect(),
        false => silences(signals),
    }
}

/// Whether the channel is a sensor that samples regularly; fixes of the horizontal position may
/// come at any time.
fn is_regular(name: &str) -> bool {
    is_measured(name) && ![Dof::Surge.position(), Dof::Sway.position()].contains(&name)
}

/// Returns the stamps at which a gap common to all regular sensors ends, s.
pub fn silences(signals: &BTreeMap<String, Signal>) -> Vec<f64> {
    let sensors: Vec<&[f64]> =
        signals.iter().filter(|(name, s)| is_regular(name) && !s.is_empty()).map(|(_, s)| s.time()).collect();
    let steps: Vec<f64> = sensors.iter().map(|time| usual_step(time).unwrap_or(0.0)).collect();
    let mut stamps: Vec<f64> = sensors.iter().flat_map(|time| time.iter().copied()).collect();
    stamps.sort_unstable_by(f64::total_cmp);
    // a sensor that has not begun yet, or has ended, is silent too
    let is_silent = |from: f64, (time, step): (&&[f64], &f64)| match time.partition_point(|t| *t <= from) {
        0 => true,
        k => k == time.len() || time[k] - time[k - 1] > (GAP * step).max(PAUSE),
    };
    let is_gap = |w: &&[f64]| w[1] - w[0] > PAUSE && sensors.iter().zip(&steps).all(|sensor| is_silent(w[0], sensor));
    stamps.windows(2).filter(is_gap).map(|w| w[1]).collect()
}

/// Returns the ends of the gaps that a row of these channels must not span, s: the gaps of the
/// whole log, and those of the sensors among the channels.
pub fn gaps_of<'a>(run: &Run, channels: impl IntoIterator<Item = &'a str>) -> Vec<f64> {
    let mut ends = run.gaps.clone();
    for signal in channels.into_iter().filter(|name| is_regular(name)).filter_map(|name| run.signal(name)) {
        ends.extend(gaps(signal.time()).into_iter().map(|k| signal.time()[k]));
    }
    ends.sort_unstable_by(f64::total_cmp);
    ends.dedup();
    ends
}

/// Returns the gaps of sensors with their own time stamps, by channel: indices into the channel's
/// stamps. Fixes of the horizontal position have no gaps: they may come at any time, and nothing is
/// integrated between them.
pub fn sensor_gaps<'a>(time: &[f64], signals: &'a BTreeMap<String, Signal>) -> Vec<(&'a str, Vec<usize>)> {
    let regular = signals.iter().filter(|(name, s)| s.len() < time.len() && is_regular(name));
    regular.map(|(name, s)| (name.as_str(), gaps(s.time()))).filter(|(_, gaps)| !gaps.is_empty()).collect()
}

/// Finds sensors with a gap while the log goes on (one finding for the same gaps), and commands at
/// uneven steps.
pub fn check_sensors(time: &[f64], signals: &BTreeMap<String, Signal>) -> Vec<Seen> {
    let ends = |name: &str, gaps: &[usize]| -> Vec<f64> { gaps.iter().map(|k| signals[name].time()[*k]).collect() };
    let mut together: Vec<(Vec<&str>, Vec<usize>)> = Vec::new();
    for (name, gaps) in sensor_gaps(time, signals) {
        match together.iter_mut().find(|(names, other)| ends(names[0], other) == ends(name, &gaps)) {
            Some((names, _)) => names.push(name),
            None => together.push((vec![name], gaps)),
        }
    }
    let mut seen = Vec::new();
    for (names, gaps) in together {
        let stamps = signals[names[0]].time();
        let (first, step) = (gaps[0], usual_step(stamps).unwrap_or(f64::NAN));
        let more = if gaps.len() > 1 { format!(" ({} such gaps)", gaps.len()) } else { String::new() };
        let text = format!(
            "{} has no sample for {} s where its usual step is {} s{more}; no regression row spans the gap, and a \
             filter continues with the other sensors",
            names.join(", "),
            short(stamps[first] - stamps[first - 1], 6),
            short(step, 6)
        );
        seen.push(Seen::new(codes::GAP, &names, Some(stamps[first]), text));
    }
    for dof in Dof::ALL {
        let Some(command) = signals.get(dof.force()).filter(|s| s.len() < time.len()) else { continue };
        let stamps = command.time();
        let (Some(first), Some(step)) = (gaps(stamps).first().copied(), usual_step(stamps)) else { continue };
        let text = format!(
            "{} has no sample for {} s where its usual step is {} s; in between, the model's `input` applies: set \
             input = \"hold\" if a command is logged only when it changes",
            dof.force(),
            short(stamps[first] - stamps[first - 1], 6),
            short(step, 6)
        );
        seen.push(Seen::new(codes::UNEVEN_COMMAND, &[dof.force()], Some(stamps[first]), text));
    }
    seen
}

/// Words in the header of a counter of rows.
const COUNTERS: [&str; 8] = ["index", "idx", "sample", "row", "frame", "record", "count", "seq"];

/// Whether the header is that of a counter of rows.
pub fn is_called_counter(header: &str) -> bool {
    let name = columns::split_header(header).0.to_lowercase();
    COUNTERS.iter().any(|word| name.contains(word)) && !["time", "stamp"].iter().any(|word| name.contains(word))
}

/// Whether a time column is a counter of rows: by its header, and by its steps, which are whole
/// numbers with median 1.
pub fn is_counter(header: &str, time: &[f64]) -> bool {
    let steps = || time.windows(2).map(|w| w[1] - w[0]);
    is_called_counter(header)
        && time.len() > 2
        && steps().all(|step| step.fract() == 0.0)
        && usual_step(time).is_some_and(|step| (step - 1.0).abs() < f64::EPSILON)
}

/// Finds a counter of rows that is read as seconds.
pub fn check_counter(header: &str, time: &[f64]) -> Option<Seen> {
    let text = || {
        format!(
            "t is read from {header:?}, which counts rows: one row per second is an unlikely rate. Set columns.t = {{ \
             name = {header:?}, scale = … }} with the time per row in s (0.1 for 10 Hz), or unit = \"s\" if it is one \
             second"
        )
    };
    is_counter(header, time).then(|| Seen::new(codes::TIME_UNIT, &["t"], None, text()))
}

/// Checks the rows for gaps and the usual step for plausibility.
pub fn check(time: &[f64], signals: &BTreeMap<String, Signal>) -> Vec<Seen> {
    let mut seen = Vec::new();
    let Some(step) = usual_step(time) else { return seen };
    let gaps = if rows_are_a_clock(time, signals) { gaps(time) } else { Vec::new() };
    if let Some(&first) = gaps.first() {
        let more = if gaps.len() > 1 { format!(" ({} gaps in all)", gaps.len()) } else { String::new() };
        let text = format!(
            "t jumps by {} s where the usual step is {} s; nothing is integrated across the gap{more}",
            short(time[first] - time[first - 1], 6),
            short(step, 6)
        );
        seen.push(Seen::new(codes::GAP, &["t"], Some(time[first]), text));
    }
    if step >= STEPS.1 || step < STEPS.0 {
        let hint = if step >= STEPS.1 {
            "if the stamps are not seconds set time_unit = \"ms\", \"us\" or \"ns\""
        } else {
            "if the stamps are in minutes or hours set time_unit = \"min\" or \"h\""
        };
        let text = format!("the usual step of t is {} s, which is implausible; {hint}", short(step, 6));
        seen.push(Seen::new(codes::TIME_UNIT, &["t"], None, text));
    }
    seen
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lost_sample_is_no_gap_and_an_hour_is() {
        assert!(gaps(&[0.0, 0.1, 0.3, 0.4, 0.5]).is_empty());
        assert_eq!(gaps(&[0.0, 0.1, 0.2, 3600.3, 3600.4]), [3]);
        let seen = check(&[0.0, 0.1, 0.2, 3600.3, 3600.4], &BTreeMap::new());
        assert!(seen.len() == 1 && seen[0].text.contains("3600.1") && seen[0].time == Some(3600.3));
    }

    #[test]
    fn a_pause_of_milliseconds_cuts_nothing() {
        // 400 Hz with a pause of 13 ms each quarter second, and one of half a second
        let mut t = 0.0;
        let mut time = Vec::new();
        for k in 0..4000 {
            t += if k == 2000 {
                0.5
            } else if k % 100 == 0 {
                0.013
            } else {
                0.0025
            };
            time.push(t);
        }
        assert_eq!(gaps(&time), [2000]);
    }

    #[test]
    fn a_sensor_that_falls_silent_has_a_gap_of_its_own() {
        let time: Vec<f64> = (0..400).map(|k| 0.05 * f64::from(k)).collect();
        let channel = |keep: &dyn Fn(usize) -> bool| {
            let own: Vec<f64> = (0..400).filter(|k| keep(*k)).map(|k| time[k]).collect();
            Signal::new(own.clone().into(), own)
        };
        let mut signals = BTreeMap::new();
        signals.insert("r".to_string(), channel(&|_| true));
        for name in ["u", "v", "x"] {
            signals.insert(name.to_string(), channel(&|k| k % 4 == 0 && !(101..200).contains(&k)));
        }
        signals.insert("tau_u".to_string(), channel(&|k| k < 50 || k == 300));
        assert_eq!(sensor_gaps(&time, &signals), [("u", vec![26]), ("v", vec![26])]);
        let seen = check_sensors(&time, &signals);
        assert_eq!(seen.len(), 2);
        assert!(seen[0].channels == ["u", "v"] && seen[0].time == Some(10.0), "{seen:?}");
        assert!(seen[0].text.contains("5 s") && seen[0].text.contains("0.2 s"), "{seen:?}");
        assert_eq!((seen[1].code, seen[1].time), (codes::UNEVEN_COMMAND, Some(15.0)));
    }

    #[test]
    fn one_sensor_that_falls_silent_cuts_its_own_rows_and_all_of_them_cut_the_log() {
        let stamps = |step: f64, silent: (f64, f64)| -> Signal {
            let time: Vec<f64> = (0..400)
                .map(|k| step * f64::from(k))
                .filter(|t| *t < 20.0 && !(silent.0..silent.1).contains(t))
                .collect();
            Signal::new(time.clone().into(), time)
        };
        let signals = |u: (f64, f64), r: (f64, f64)| {
            BTreeMap::from([("u".to_string(), stamps(0.2, u)), ("r".to_string(), stamps(0.05, r))])
        };
        let never = (1.0, 0.0);
        let run = Run { signals: signals((5.0, 7.0), never), ..Run::default() };
        assert!(silences(&run.signals).is_empty());
        // rounding of k · 0.2
        assert!(matches!(gaps_of(&run, ["u", "r"])[..], [end] if (end - 7.0).abs() < 1e-9));
        assert!(gaps_of(&run, ["r", "tau_u"]).is_empty());
        let both = silences(&signals((5.0, 7.0), (5.5, 7.5)));
        assert!(matches!(both[..], [end] if (end - 7.0).abs() < 1e-9), "{both:?}");
        assert!(silences(&signals((5.0, 7.0), (8.0, 9.0))).is_empty());
    }

    #[test]
    fn a_counter_of_rows_is_told_from_seconds() {
        let counted: Vec<f64> = (7..40).map(f64::from).collect();
        for header in ["index", "Sample", "frame_id", "Row [-]", "sampleIdx"] {
            assert!(is_counter(header, &counted), "{header}");
        }
        assert!(!is_counter("time", &counted) && !is_counter("sample_time", &counted));
        let tenths: Vec<f64> = counted.iter().map(|t| 0.1 * t).collect();
        assert!(!is_counter("index", &tenths));
        let seen = check_counter("index", &counted).unwrap();
        assert!(seen.code == codes::TIME_UNIT && seen.text.contains("scale = "), "{seen:?}");
        assert_eq!(check_counter("index", &tenths), None);
    }

    #[test]
    fn milliseconds_are_noticed() {
        let seen = check(&[0.0, 50.0, 100.0], &BTreeMap::new());
        assert!(seen[0].code == codes::TIME_UNIT && seen[0].text.contains("50 s"));
        assert!(check(&[0.0, 1.0, 2.0], &BTreeMap::new()).is_empty());
        assert!(check(&[3.0], &BTreeMap::new()).is_empty());
    }
}
