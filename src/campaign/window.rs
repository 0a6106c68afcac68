//! The part of a run that is used (`from`, `to`, `where`), its resampling, and commands that are
//! held.
//!
//! A condition removes samples of the sensors of motion only. Commands and auxiliary channels stay
//! whole, so that the remaining motion is driven by the true inputs. Each stretch that is left
//! begins as after a gap.

use std::sync::Arc;

use super::file::RunTable;
use super::steps_as_lines::goes_on;
use crate::formula::{Formula, FormulaError};
use crate::log::check::is_measured;
use crate::log::check::time::gaps_of;
use crate::run::{Run, Signal, is_command, rounding};

/// Cuts `run` to the time stamps from `from` to `to`, s.
pub(super) fn cut(run: &mut Run, table: &RunTable) {
    let (from, to) = (table.from.unwrap_or(f64::NEG_INFINITY), table.to.unwrap_or(f64::INFINITY));
    if table.from.is_some() || table.to.is_some() {
        for signal in run.signals.values_mut() {
            *signal = kept(signal, |t| (from..=to).contains(&t));
        }
        run.gaps.retain(|t| (from..=to).contains(t));
    }
}

/// Keeps the samples of the sensors of motion, and of the channels `observed`, at which `condition`
/// holds.
///
/// # Errors
/// [`FormulaError`] for a name that the run does not log.
pub(super) fn keep_where(run: &mut Run, condition: &Formula, observed: &[&str]) -> Result<(), FormulaError> {
    let of_motion = |name: &&String| is_measured(name) || observed.contains(&name.as_str());
    let motion: Vec<String> = run.signals.keys().filter(of_motion).cloned().collect();
    let mut stamps: Vec<f64> = motion.iter().flat_map(|name| run.signals[name].time().iter().copied()).collect();
    stamps.sort_by(f64::total_cmp);
    stamps.dedup();
    let holds: Vec<bool> = condition.over(run, &stamps)?.into_iter().map(|x| x != 0.0).collect();
    for name in motion {
        let at = |t: f64| holds[stamps.partition_point(|s| *s < t)];
        let signal = kept(&run.signals[&name], at);
        run.signals.insert(name, signal);
    }
    let begins = (1..stamps.len()).filter(|k| holds[*k] && !holds[k - 1]).map(|k| stamps[k]);
    run.gaps.extend(begins);
    run.gaps.sort_by(f64::total_cmp);
    run.gaps.dedup();
    Ok(())
}

fn kept(signal: &Signal, keep: impl Fn(f64) -> bool) -> Signal {
    let (time, values): (Vec<f64>, Vec<f64>) =
        signal.time().iter().zip(signal.values()).filter(|(t, _)| keep(**t)).unzip();
    Signal::new(time.into(), values)
}

/// Resamples every signal at `rate` samples per second: linearly between its samples, or for
/// commands with `held` at the last sample before. No sample is made inside a gap.
pub(super) fn resample(run: &mut Run, rate: f64, held: bool) {
    let gaps: Vec<Vec<f64>> = run.signals.keys().map(|name| gaps_of(run, [name.as_str()])).collect();
    for ((name, signal), gaps) in run.signals.iter_mut().zip(gaps) {
        let (time, x) = (signal.time(), signal.values());
        let (Some(first), Some(last)) = (time.first(), time.last()) else { continue };
        let held = held && is_command(name);
        let slack = rounding(*last) * rate;
        let (begin, end) = ((first * rate - slack).ceil() as i64, (last * rate + slack).floor() as i64);
        let (mut stamps, mut values) = (Vec::new(), Vec::new());
        for k in begin..=end {
            let t = k as f64 / rate;
            let after = time.partition_point(|s| *s <= t + rounding(t)).max(1);
            let before = after - 1;
            let exact = (time[before] - t).abs() <= rounding(t);
            let across = |gap: &f64| time[before] < *gap && after < time.len() && *gap <= time[after];
            if !exact && gaps.iter().any(across) {
                continue;
            }
            values.push(match after < time.len() && !exact && !held {
                true => x[before] + (x[after] - x[before]) * (t - time[before]) / (time[after] - time[before]),
                false => x[before],
            });
            stamps.push(t);
        }
        *signal = Signal::new(stamps.into(), values);
    }
}

/// Writes held commands as lines with steps, for a campaign in which other runs, or measured fin
/// angles, are lines.
pub(super) fn steps(run: &mut Run) {
    /// Width of a step, s: far below any time constant, far above the rounding of time stamps.
    const WIDTH: f64 = 1e-6;
    let is_held = |name: &str, signal: &Signal| is_command(name) && !goes_on(name, signal);
    for (_, signal) in run.signals.iter_mut().filter(|(name, signal)| is_held(name, signal)) {
        let (time, x) = (signal.time(), signal.values());
        let mut stamps = Vec::with_capacity(2 * time.len());
        let mut values = Vec::with_capacity(2 * time.len());
        for k in 0..time.len() {
            if k > 0 && x[k].to_bits() != x[k - 1].to_bits() && time[k] - time[k - 1] > 2.0 * WIDTH {
                stamps.push(time[k] - WIDTH);
                values.push(x[k - 1]);
            }
            stamps.push(time[k]);
            values.push(x[k]);
        }
        *signal = Signal::new(Arc::from(stamps), values);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run() -> Run {
        let time: Arc<[f64]> = (0..11).map(|k| 0.1 * f64::from(k)).collect();
        let mut run = Run::default();
        run.signals.insert("u".into(), Signal::new(time.clone(), time.to_vec()));
        run.signals.insert("tau_u".into(), Signal::new(time.clone(), vec![2.0; 11]));
        run
    }

    #[test]
    fn a_condition_cuts_motion_and_begins_a_stretch() {
        let mut run = run();
        keep_where(&mut run, &Formula::parse("u < 0.25 || u > 0.65").unwrap(), &[]).unwrap();
        assert_eq!((run.signals["u"].len(), run.signals["tau_u"].len()), (7, 11));
        assert_eq!(run.gaps.len(), 1);
        assert!((run.gaps[0] - 0.7).abs() < 1e-12);
        assert!(keep_where(&mut run, &Formula::parse("depth > 1").unwrap(), &[]).is_err());
    }

    #[test]
    fn a_window_keeps_its_ends() {
        let mut run = run();
        cut(&mut run, &RunTable { from: Some(0.2), to: Some(0.5), ..RunTable::default() });
        assert_eq!(run.signals["u"].len(), 4);
    }

    #[test]
    fn resampling_reads_the_line_and_leaves_gaps_empty() {
        let mut line = run();
        resample(&mut line, 20.0, false);
        assert_eq!(line.signals["u"].len(), 21);
        assert!(line.signals["u"].time().iter().zip(line.signals["u"].values()).all(|(t, u)| (t - u).abs() < 1e-12));
        let mut gap = run();
        gap.gaps = vec![gap.signals["u"].time()[5]];
        resample(&mut gap, 20.0, false);
        assert_eq!(gap.signals["u"].len(), 20);
    }

    #[test]
    fn held_commands_become_steps() {
        let mut run = run();
        run.signals.insert("tau_u".into(), Signal::new(vec![0.0, 1.0, 2.0].into(), vec![1.0, 1.0, 5.0]));
        steps(&mut run);
        assert_eq!(run.signals["tau_u"].values(), [1.0, 1.0, 1.0, 5.0]);
    }
}
