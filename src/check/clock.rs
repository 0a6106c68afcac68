//! Clocks that were set, and nominal counters that drift: t itself, and any second clock in the log.
//!
//! ```text
//! t       |Δt/T − round(Δt/T)| > 0.1 where 98 of 100 steps are T within 2 %
//! drift = (s_n − s_0)/(t_n − t_0) − 1        step: |Δs − Δt| > 0.2 s and more than five usual steps
//! ```
//!
//! A second clock is an auxiliary column that is named like one (`time`, `stamp`, `clock`, `utc`, `epoch`,
//! `t_…`), never falls and advances between half and twice as fast as t, or the same in ms, µs or ns.

use super::codes;
use super::report::Found;
use crate::log::check::is_measured;
use crate::log::check::statistics::median;
use crate::log::check::time::usual_step;
use crate::log::number::short;
use crate::run::{Run, Signal, is_command};

/// Largest drift between two sound clocks over one run.
const DRIFT: f64 = 0.002;
/// Smallest step of a clock that is reported, s.
const STEP: f64 = 0.2;

/// Checks the run's own clock and all second clocks.
pub fn check(run: &Run) -> Vec<Found> {
    let longest = run.signals.values().max_by_key(|signal| signal.len());
    let mut found: Vec<Found> = longest.and_then(|signal| own(signal.time())).into_iter().collect();
    let auxiliary = run.signals.iter().filter(|(name, _)| !is_measured(name) && !is_command(name) && is_named(name));
    found.extend(auxiliary.filter_map(|(name, signal)| second(name, signal)).flatten());
    found
}

/// Finds steps of an even clock that lost samples do not explain: a step across lost samples is a
/// whole number of usual steps.
fn own(time: &[f64]) -> Option<Found> {
    /// Least number of stamps that show that a clock is even.
    const FEWEST: usize = 50;
    let step = usual_step(time).filter(|s| *s > 0.0 && time.len() >= FEWEST)?;
    let turns = |k: usize| (time[k] - time[k - 1]) / step;
    let uneven: Vec<usize> = (1..time.len()).filter(|k| (turns(*k) - 1.0).abs() > 0.02).collect();
    // a gap has a finding of its own
    let set: Vec<usize> =
        uneven.iter().copied().filter(|k| turns(*k) < 5.0 && (turns(*k) - turns(*k).round()).abs() > 0.1).collect();
    let first = *set.first().filter(|_| 50 * uneven.len() <= time.len())?;
    let text = format!(
        "t steps by {} s at t = {} s where its usual step is {} s, and lost samples do not explain it ({} such steps): \
         the clock was set; all later times are off by that much",
        short(time[first] - time[first - 1], 4),
        short(time[first], 6),
        short(step, 4),
        set.len()
    );
    Some(Found::new(&codes::CLOCK_STEP, &["t"], text))
}

/// Whether the name is that of a clock: a distance covered at 1 m/s advances like a clock.
fn is_named(name: &str) -> bool {
    let name = name.to_lowercase();
    name.starts_with("t_") || ["time", "stamp", "clock", "utc", "epoch"].iter().any(|word| name.contains(word))
}

/// Returns the findings about a second clock; `None` if the column is no clock.
fn second(name: &str, signal: &Signal) -> Option<Vec<Found>> {
    let (time, x) = (signal.time(), signal.values());
    let step = usual_step(time).filter(|s| *s > 0.0)?;
    if x.len() < 20 || x.windows(2).any(|w| w[1] < w[0]) {
        return None;
    }
    let rates = || x.windows(2).zip(time.windows(2)).map(|(x, t)| (x[1] - x[0]) / (t[1] - t[0]));
    let usual = median(rates())?;
    let whole = (x[x.len() - 1] - x[0]) / (time[time.len() - 1] - time[0]);
    let unit = [1.0, 1e3, 1e6, 1e9].into_iter().find(|unit| (0.5..=2.0).contains(&(usual / unit)))?;
    // a clock ticks evenly; a distance run at about 1 m/s does not
    let odd = rates().filter(|r| (r / usual - 1.0).abs() > 0.5).count();
    if 10 * odd > x.len() {
        return None;
    }
    let jumps: Vec<usize> = (1..x.len())
        .filter(|&k| {
            let jump = (x[k] - x[k - 1]) / unit - (time[k] - time[k - 1]);
            jump.abs() > STEP.max(5.0 * step)
        })
        .collect();
    let mut found = Vec::new();
    if let Some(&k) = jumps.first() {
        let jump = (x[k] - x[k - 1]) / unit - (time[k] - time[k - 1]);
        let text = format!(
            "{name} jumps by {} s against t at t = {} s ({} such jumps): one of the two clocks was set",
            short(jump, 4),
            short(time[k], 6),
            jumps.len()
        );
        found.push(Found::new(&codes::CLOCK_STEP, &[name], text));
    } else if (whole / unit - 1.0).abs() > DRIFT {
        let drift = whole / unit - 1.0;
        let text = format!(
            "{name} advances {} s while t advances {} s, {} % {}: one of the two is a nominal counter; use the \
             measured one as t",
            short((x[x.len() - 1] - x[0]) / unit, 5),
            short(time[time.len() - 1] - time[0], 5),
            short(100.0 * drift.abs(), 3),
            if drift < 0.0 { "short" } else { "long" }
        );
        found.push(Found::new(&codes::CLOCK_DRIFT, &[name], text));
    }
    Some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(f: impl Fn(usize, f64) -> f64) -> Run {
        let time: std::sync::Arc<[f64]> = (0..600).map(|k| 0.1095 * f64::from(k)).collect();
        let values: Vec<f64> = time.iter().enumerate().map(|(k, t)| f(k, *t)).collect();
        let mut run = Run::default();
        run.signals.insert("stamp".into(), Signal::new(time, values));
        run
    }

    #[test]
    fn a_nominal_counter_is_short() {
        let found = check(&with(|k, _| 0.1 * k as f64));
        assert_eq!((found.len(), found[0].code.code), (1, codes::CLOCK_DRIFT.code));
        assert!(found[0].text.contains("8.68 % short"), "{}", found[0].text);
    }

    #[test]
    fn a_set_clock_steps() {
        let found = check(&with(|k, t| 1e9 * (t + if k > 300 { 3.0 } else { 0.0 })));
        assert_eq!((found.len(), found[0].code.code), (1, codes::CLOCK_STEP.code));
    }

    #[test]
    fn the_own_clock_is_set_or_has_lost_samples() {
        let run = |shift: f64, from: usize| {
            let stamp = |k: usize| 0.1 * k as f64 + if k >= from { shift } else { 0.0 };
            let time: std::sync::Arc<[f64]> = (0..600).map(stamp).collect();
            let mut run = Run::default();
            run.signals.insert("u".into(), Signal::new(time.clone(), time.to_vec()));
            run
        };
        for shift in [0.17, -0.04, 0.25] {
            let found = check(&run(shift, 300));
            assert_eq!((found.len(), found[0].code.code), (1, codes::CLOCK_STEP.code), "{shift}");
        }
        // no step, lost samples, a gap
        for shift in [0.0, 0.1, 0.2, 7.77] {
            assert!(check(&run(shift, 300)).is_empty(), "{shift}");
        }
    }

    #[test]
    fn honest_clocks_and_other_columns_are_silent() {
        assert!(check(&with(|_, t| 1e3 * t + 17.0)).is_empty());
        assert!(check(&with(|_, t| t.sin())).is_empty());
        assert!(check(&with(|k, t| if k % 2 == 0 { t } else { t + 0.09 })).is_empty());
    }
}
