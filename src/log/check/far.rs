//! Single values far from all others: codes for "no value", and spikes.

use super::super::codes;
use super::super::columns::quantity;
use super::super::number::short;
use super::plausible::limit;
use super::statistics::{median, quantile, range};
use super::{Seen, is_measured};
use crate::run::Signal;

/// Finds sentinels in a measured channel or a command, and outliers in a measured channel.
pub fn check(name: &str, signal: &Signal) -> Vec<Seen> {
    examine(name, signal).0
}

/// Returns the signal without the samples that [`check`] finds and without those above the
/// plausible limit; `None` if there are none, or if they are more than one in twenty: then the
/// column is probably in another unit.
pub fn without(name: &str, signal: &Signal) -> Option<Signal> {
    let (_, kept) = examine(name, signal);
    let limit = limit(name);
    let sound = |k: &usize| kept[*k] && signal.values()[*k].abs() <= limit;
    let left: Vec<usize> = (0..signal.len()).filter(sound).collect();
    if left.len() == signal.len() || 20 * left.len() < 19 * signal.len() {
        return None;
    }
    let stamps: Vec<f64> = left.iter().map(|k| signal.time()[*k]).collect();
    Some(Signal::new(stamps.into(), left.iter().map(|k| signal.values()[*k]).collect::<Vec<_>>()))
}

/// Returns the findings, and which samples are kept.
fn examine(name: &str, signal: &Signal) -> (Vec<Seen>, Vec<bool>) {
    let mut kept = vec![true; signal.len()];
    let mut seen = Vec::new();
    if quantity(name).is_none() || signal.len() < 8 {
        return (seen, kept);
    }
    while let Some(code) = sentinel(signal.values(), &kept, is_measured(name)) {
        let at: Vec<usize> =
            (0..kept.len()).filter(|&k| kept[k] && signal.values()[k].to_bits() == code.to_bits()).collect();
        at.iter().for_each(|&k| kept[k] = false);
        let text = format!(
            "{name} is exactly {code:?} in {} and far from it otherwise: a code for no value; set missing_values = \
             [\"{code:?}\"] (as the file writes it, before any change of unit) with missing = \"drop\" or \
             \"no_sample\"",
            if at.len() == 1 { "1 sample".to_string() } else { format!("{} samples", at.len()) }
        );
        seen.push(Seen::new(codes::SENTINEL, &[name], at.first().map(|&k| signal.time()[k]), text));
    }
    if !is_measured(name) {
        // a command may jump
        return (seen, kept);
    }
    let spikes = spikes(name, signal.values(), &kept);
    if let Some(&first) = spikes.first() {
        let count = if spikes.len() > 1 { format!(" ({} such samples)", spikes.len()) } else { String::new() };
        let text = format!("{name} = {} lies far from its neighbours{count}", short(signal.values()[first], 6));
        seen.push(Seen::new(codes::OUTLIER, &[name], Some(signal.time()[first]), text));
    }
    spikes.iter().for_each(|&k| kept[k] = false);
    (seen, kept)
}

/// Whether the digits are those of a well-known code: nines (−9999, 99.99), the ends of a 16-bit
/// range, or a value of 1e20 and more.
fn is_known_code(x: f64) -> bool {
    let digits: String = format!("{:?}", x.abs()).chars().filter(char::is_ascii_digit).collect();
    let digits = digits.trim_matches('0');
    (digits.len() >= 2 && digits.bytes().all(|b| b == b'9'))
        || ["32768", "32767", "65535", "65536"].contains(&digits)
        || x.abs() >= 1e20
}

/// Returns an extreme value that is far from the rest. Its distance from the rest exceeds five
/// times the range of the rest for a known code of 999 or more, or of 99 to 999 that occurs at most
/// twice. In a measured channel, where the code repeats to the bit, the distance exceeds the range
/// for a known code that occurs twice or more, and five times the range for any value that occurs
/// three times or more.
fn sentinel(values: &[f64], kept: &[bool], measured: bool) -> Option<f64> {
    let rest = |without: f64| {
        let kept = values.iter().zip(kept).filter(|(x, k)| **k && x.to_bits() != without.to_bits());
        range(kept.map(|(x, _)| *x))
    };
    let (low, high) = range(values.iter().zip(kept).filter(|(_, k)| **k).map(|(x, _)| *x))?;
    [low, high].into_iter().find(|&extreme| {
        let count = values.iter().zip(kept).filter(|(x, k)| **k && x.to_bits() == extreme.to_bits()).count();
        let Some((a, b)) = rest(extreme) else { return false };
        let distance = if extreme < a { a - extreme } else { extreme - b };
        let far = distance / (b - a);
        let known = is_known_code(extreme);
        // single samples above the plausible limit have a finding of their own
        let alone = |count: usize| {
            (999.0..1e20).contains(&extreme.abs()) || (count < 3 && (99.0..999.0).contains(&extreme.abs()))
        };
        let repeated = count >= 3 && far > 5.0 || count >= 2 && known && far > 1.0;
        b > a && (measured && repeated || alone(count) && known && far > 5.0)
    })
}

/// Returns the samples that differ from both neighbours to the same side by more than the usual
/// range of the channel (5 to 95 percent) and by more than 20 times its noise; and all samples that
/// are further than ten such ranges from the median. Noise: robust standard deviation (median /
/// 0.6745) of the deviation from the mean of both neighbours.
fn spikes(name: &str, values: &[f64], kept: &[bool]) -> Vec<usize> {
    let sound: Vec<usize> = (0..values.len()).filter(|&k| kept[k] && values[k].abs() <= limit(name)).collect();
    let x = |i: usize| values[sound[i]];
    let all = || sound.iter().map(|&k| values[k]);
    let (Some(middle), Some(low), Some(high)) = (median(all()), quantile(all(), 0.05), quantile(all(), 0.95)) else {
        return Vec::new();
    };
    let usual = high - low;
    let bend = |i: usize| (x(i) - 0.5 * (x(i - 1) + x(i + 1))).abs();
    let inner = 1..sound.len().saturating_sub(1);
    let noise = median(inner.clone().map(bend)).unwrap_or(0.0) / 0.6745;
    // a heading jumps by a full turn where it is wrapped; a channel that hardly moves has no usual range
    if usual <= 0.0 || matches!(name, "psi" | "phi") {
        return Vec::new();
    }
    let is_spike = |i: usize| {
        let (before, after) = (x(i) - x(i - 1), x(i) - x(i + 1));
        before * after > 0.0 && before.abs().min(after.abs()) > (20.0 * noise).max(usual)
    };
    let far = |i: usize| (x(i) - middle).abs() > 10.0 * usual;
    (0..sound.len()).filter(|&i| far(i) || (inner.contains(&i) && is_spike(i))).map(|i| sound[i]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn swing(change: impl Fn(usize, f64) -> f64) -> Signal {
        let time: Vec<f64> = (0..200).map(|k| 0.1 * f64::from(k)).collect();
        let values: Vec<f64> = time.iter().enumerate().map(|(k, t)| change(k, 0.6 * t.sin())).collect();
        Signal::new(time.into(), values)
    }

    #[test]
    fn codes_for_no_value_are_noticed() {
        for (code, count) in [(-32.768, 6), (-9999.0, 2), (99.99, 3), (12.5, 3)] {
            let seen = check("u", &swing(|k, x| if (50..50 + count).contains(&k) { code } else { x }));
            assert_eq!(seen.len(), 1, "{code}");
            assert!(seen[0].code == codes::SENTINEL && seen[0].text.contains(&format!("{code:?} in {count}")));
        }
    }

    #[test]
    fn one_known_code_is_enough_in_sensors_and_commands() {
        for name in ["u", "tau_u", "V1"] {
            let seen = check(name, &swing(|k, x| if k == 50 { -9999.0 } else { x }));
            assert_eq!((seen.len(), seen[0].code), (1, codes::SENTINEL), "{name}");
            assert!(seen[0].text.contains("in 1 sample") && seen[0].text.contains("missing_values = [\"-9999.0\"]"));
        }
        assert!(check("tau_u", &swing(|k, x| if k % 20 < 10 { 99.0 } else { x })).is_empty(), "a level of the command");
    }

    #[test]
    fn what_is_named_can_be_left_out() {
        let spoilt = swing(|k, x| match k {
            50 => -9999.0,
            88 => 5.0,
            120 => 1e300,
            _ => x,
        });
        let sound = without("u", &spoilt).expect("three samples are none");
        let range = range(sound.values().iter().copied());
        assert!(sound.len() == 197 && range.is_some_and(|(a, b)| a >= -0.6 && b <= 0.6), "{range:?}");
        assert!(without("u", &swing(|_, x| x)).is_none());
        // a command may jump
        assert!(without("tau_u", &swing(|k, x| if k == 88 { 50.0 } else { x })).is_none());
    }

    #[test]
    fn a_spike_is_noticed_and_a_step_is_not() {
        let seen = check("r", &swing(|k, x| if k == 88 { 5.0 } else { x }));
        assert_eq!((seen.len(), seen[0].code), (1, codes::OUTLIER));
        assert!((seen[0].time.unwrap() - 8.8).abs() < 1e-12);
        assert!(check("r", &swing(|k, _| if k > 88 { 5.0 } else { 0.0 })).is_empty());
        assert!(check("r", &swing(|_, x| x)).is_empty());
        assert!(check("tau_r", &swing(|k, x| if k == 88 { 50.0 } else { x })).is_empty());
    }
}
