//! Conversion of values to pixels: ranges, linear scales and round ticks.

use super::canvas::{fitted, text_width};
use crate::report::chart::Axis;
use crate::report::label::{Label, unit};
use crate::report::number::power_of_ten;

/// Values beyond this are left out of a range: the width of the range would overflow.
const LARGEST: f64 = 1e300;

/// A linear map of [low, high] to [from, to] pixels.
#[derive(Debug, Clone, Copy)]
pub struct Scale {
    /// Value at `from`.
    pub low: f64,
    /// Value at `to`.
    pub high: f64,
    /// Pixel of `low`.
    pub from: f64,
    /// Pixel of `high`.
    pub to: f64,
}

impl Scale {
    /// Pixel of `value`.
    pub fn px(&self, value: f64) -> f64 {
        self.from + (value - self.low) / (self.high - self.low) * (self.to - self.from)
    }
}

/// Smallest and largest of the finite values, widened on both sides by the fraction `pad` of their
/// distance. Never empty: (0, 1) if there is no value.
pub fn range(values: impl Iterator<Item = f64>, pad: f64) -> (f64, f64) {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for v in values.filter(|v| v.abs() < LARGEST) {
        low = low.min(v);
        high = high.max(v);
    }
    if low > high {
        return (0.0, 1.0);
    }
    let size = low.abs().max(high.abs());
    if high - low <= 1e-9 * size || high - low < f64::MIN_POSITIVE {
        let half = if size > 0.0 { 0.1 * size } else { 1.0 };
        return (low - half, high + half);
    }
    let pad = pad * (high - low);
    (low - pad, high + pad)
}

/// Round values on an axis and their labels.
#[derive(Debug, Clone)]
pub struct Ticks {
    /// The values.
    pub at: Vec<f64>,
    /// Their text, in units of 10^power.
    pub labels: Vec<String>,
    /// Power of ten taken out of the text, a multiple of three; 0 for most axes.
    pub power: i32,
}

/// About `about` ticks at multiples of 1, 2 or 5 times a power of ten in [low, high].
pub fn ticks(low: f64, high: f64, about: usize) -> Ticks {
    let raw = (high - low) / about.max(1) as f64;
    let decade = 10f64.powf(raw.log10().floor());
    let step = match raw / decade {
        f if f < 1.5 => decade,
        f if f < 3.5 => 2.0 * decade,
        f if f < 7.5 => 5.0 * decade,
        _ => 10.0 * decade,
    };
    let first = (low / step - 1e-9).ceil();
    let at: Vec<f64> =
        (0..=2 * about + 2).map(|k| (first + k as f64) * step).take_while(|v| *v <= high + 1e-9 * step).collect();
    let exponent = low.abs().max(high.abs()).log10().floor() as i32;
    let power = if (-3..5).contains(&exponent) { 0 } else { exponent.div_euclid(3) * 3 };
    let decimals = (power - (step * 1.000_001).log10().floor() as i32).clamp(0, 12) as usize;
    let labels = at.iter().map(|v| tick_label(v / 10f64.powi(power), decimals)).collect();
    Ticks { at, labels, power }
}

fn tick_label(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let zero = !text.bytes().any(|b| (b'1'..=b'9').contains(&b));
    match text.strip_prefix('-') {
        Some(rest) if zero => rest.to_string(),
        Some(rest) => format!("−{rest}"),
        None => text,
    }
}

/// `label (10³ unit)`: the title of an axis, escaped for SVG, cut to `width` px.
pub fn axis_title(axis: &Axis, power: i32, width: f64) -> String {
    let mut brackets = String::new();
    if power != 0 {
        brackets.push_str(&power_of_ten(power));
    }
    if !axis.unit.is_empty() {
        if power != 0 {
            brackets.push(' ');
        }
        brackets.push_str(&unit(&axis.unit));
    }
    if brackets.is_empty() {
        return fitted(&axis.label, width).svg();
    }
    let brackets = Label::Plain(format!("({brackets})"));
    let room = width - text_width(&brackets) - 4.0;
    format!("{} {}", fitted(&axis.label, room).svg(), brackets.svg())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_inside() {
        let t = ticks(-0.52, 1.03, 5);
        assert_eq!(t.labels, ["−0.4", "−0.2", "0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert!(t.at.iter().all(|v| (-0.52..=1.03).contains(v)));
        assert_eq!(ticks(-0.6, 0.6, 8).at.len(), 13, "both ends, although -0.6 / 0.1 is not -6");
        assert_eq!(ticks(0.0, 100.0, 5).labels, ["0", "20", "40", "60", "80", "100"]);
    }

    #[test]
    fn large_and_small_values_leave_their_power_to_the_title() {
        let t = ticks(0.0, 2.4e6, 5);
        assert_eq!((t.power, t.labels[1].as_str()), (6, "0.5"));
        assert_eq!(ticks(0.0, 2.4e-5, 5).power, -6);
        assert_eq!(axis_title(&Axis::new("Force", "N*m"), 3, 300.0), "Force (10³ N·m)");
    }

    #[test]
    fn a_range_is_never_empty() {
        for values in [vec![], vec![f64::NAN], vec![3.0], vec![0.0, 0.0], vec![1e308, -1e308], vec![1e9, 1e9 + 1e-6]] {
            let (low, high) = range(values.iter().copied(), 0.05);
            assert!(low < high, "{values:?}");
            let t = ticks(low, high, 5);
            assert!((2..20).contains(&t.at.len()), "{values:?}: {t:?}");
        }
    }
}
