//! Gaps and the unit of time.

use super::super::codes;
use super::super::number::short;
use super::Seen;
use super::statistics::median;

/// A step this many times the usual one is a gap: single lost samples are not.
const GAP: f64 = 5.0;
/// Usual steps beyond these are no vehicle's log, s: a sample every 5 s shows no dynamics, 10 kHz is no sensor.
const STEPS: (f64, f64) = (1e-4, 5.0);

/// The median step, s; `None` with fewer than two stamps.
pub fn usual_step(time: &[f64]) -> Option<f64> {
    median(time.windows(2).map(|w| w[1] - w[0]))
}

/// Indices of the stamps at which a gap ends: steps of more than five times the median.
pub fn gaps(time: &[f64]) -> Vec<usize> {
    let Some(step) = usual_step(time) else { return Vec::new() };
    (1..time.len()).filter(|&k| time[k] - time[k - 1] > GAP * step).collect()
}

/// Both checks.
pub fn check(time: &[f64]) -> Vec<Seen> {
    let mut seen = Vec::new();
    let Some(step) = usual_step(time) else { return seen };
    let gaps = gaps(time);
    if let Some(&first) = gaps.first() {
        let more = if gaps.len() > 1 { format!(" ({} gaps in all)", gaps.len()) } else { String::new() };
        let text = format!(
            "t jumps by {} s where the usual step is {} s; nothing is integrated across it{more}",
            short(time[first] - time[first - 1], 6),
            short(step, 6)
        );
        seen.push(Seen::new(codes::GAP, &["t"], Some(time[first]), text));
    }
    if step >= STEPS.1 || step < STEPS.0 {
        let hint = if step >= STEPS.1 {
            "if the stamps are not seconds set time_unit = \"ms\", \"us\" or \"ns\""
        } else {
            "if the stamps are in minutes or hours convert them to seconds"
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
        let seen = check(&[0.0, 0.1, 0.2, 3600.3, 3600.4]);
        assert!(seen.len() == 1 && seen[0].text.contains("3600.1") && seen[0].time == Some(3600.3));
    }

    #[test]
    fn milliseconds_are_noticed() {
        let seen = check(&[0.0, 50.0, 100.0]);
        assert!(seen[0].code == codes::TIME_UNIT && seen[0].text.contains("50 s"));
        assert!(check(&[0.0, 1.0, 2.0]).is_empty());
        assert!(check(&[3.0]).is_empty());
    }
}
