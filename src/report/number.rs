//! Format of numbers for people: a value and its standard deviation to the same decimal place.
//!
//! The standard deviation σ has two significant digits, and the value is rounded to the place of
//! the second one, as the *Guide to the Expression of Uncertainty in Measurement* (JCGM 100:2008,
//! 7.2.6) advises: 309.07 ± 18.8 is written 309 ± 19. If both are very large or very small, they
//! share one power of ten: (1.24 ± 0.31) × 10⁻⁵.

/// Output format of the digits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Style {
    /// Unicode: true minus, thin spaces between thousands, superscript exponents.
    Text,
    /// Inside LaTeX mathematics, without the dollar signs.
    Latex,
}

/// Largest ratio |value|/σ for which both are written to the same place; beyond it the value would
/// need too many digits.
const SAME_PLACE: f64 = 1e9;

/// `x` to `significant` digits (1 to 15). Magnitudes from 10⁻³ to 10⁶ are written out, others with
/// a power of ten.
///
/// NaN is `–`, infinities are `∞`, and zero of either sign is `0`.
pub fn number(x: f64, significant: u32, style: Style) -> String {
    if let Some(word) = without_digits(x, style) {
        return word;
    }
    let significant = significant.clamp(1, 15) as i32;
    let exponent = decade(x, significant);
    if (-3..6).contains(&exponent) {
        return digits(x, exponent - significant + 1, style);
    }
    with_power(&digits(scaled(x, exponent), 1 - significant, style), exponent, style)
}

/// `value ± std`; only the value, to four digits, if `std` is absent or zero (a held parameter).
pub fn estimate(value: f64, std: Option<f64>, style: Style) -> String {
    let Some(std) = std.map(f64::abs).filter(|s| *s > 0.0 || s.is_nan()) else {
        return number(value, 4, style);
    };
    let plus_minus = match style {
        Style::Text => " ± ",
        Style::Latex => r" \pm ",
    };
    if !value.is_finite() || !std.is_finite() || value.abs() > SAME_PLACE * std {
        let significant = if std.is_finite() && value.is_finite() { 12 } else { 4 };
        return format!("{}{plus_minus}{}", number(value, significant, style), number(std, 2, style));
    }
    let place = decade(std, 2) - 1;
    let top = if value == 0.0 { place + 1 } else { decade(value, 15).max(place + 1) };
    if (-3..6).contains(&top) {
        return format!("{}{plus_minus}{}", digits(value, place, style), digits(std, place, style));
    }
    let (value, std) = (scaled(value, top), scaled(std, top));
    let pair = format!("{}{plus_minus}{}", digits(value, place - top, style), digits(std, place - top, style));
    with_power(&format!("({pair})"), top, style)
}

/// `x` in the fewest digits that read back as the same number: for files, not for people.
pub fn exact(x: f64) -> String {
    if !x.is_finite() {
        return String::new();
    }
    let x = x + 0.0;
    let plain = format!("{x}");
    if plain.len() <= 17 { plain } else { format!("{x:e}") }
}

fn without_digits(x: f64, style: Style) -> Option<String> {
    let infinity = match style {
        Style::Text => "∞",
        Style::Latex => r"\infty",
    };
    match x {
        _ if x.is_nan() => Some(if style == Style::Text { "–".into() } else { "-".into() }),
        f64::INFINITY => Some(infinity.into()),
        f64::NEG_INFINITY => Some(format!("{}{infinity}", minus(style))),
        0.0 => Some("0".into()),
        _ => None,
    }
}

/// Power of ten of the first digit of `x` after rounding to `significant` digits: 0.996 to two
/// digits is 1.0, decade 0.
fn decade(x: f64, significant: i32) -> i32 {
    let text = format!("{:.*e}", (significant - 1).max(0) as usize, x.abs());
    text.split_once('e').and_then(|(_, exponent)| exponent.parse().ok()).unwrap_or(0)
}

/// x / 10^exponent, in two steps because 10⁻³²⁴ and 10³⁰⁹ are not numbers.
fn scaled(x: f64, exponent: i32) -> f64 {
    let half = exponent / 2;
    x / 10f64.powi(half) / 10f64.powi(exponent - half)
}

/// `x` rounded at 10^place, with thousands separated.
fn digits(x: f64, place: i32, style: Style) -> String {
    let text = if place > 0 {
        let unit = 10f64.powi(place);
        format!("{:.0}", (x.abs() / unit).round() * unit)
    } else {
        format!("{:.*}", (-place) as usize, x.abs())
    };
    let negative = x < 0.0 && text.bytes().any(|b| (b'1'..=b'9').contains(&b));
    let (whole, fraction) = text.split_once('.').map_or((text.as_str(), ""), |(w, f)| (w, f));
    let mut out = if negative { minus(style).to_string() } else { String::new() };
    out.push_str(&thousands(whole, style));
    if !fraction.is_empty() {
        out.push('.');
        out.push_str(fraction);
    }
    out
}

/// Digits in groups of three from five digits on, as in ISO 80000-1; four digits are not separated.
fn thousands(whole: &str, style: Style) -> String {
    if whole.len() < 5 {
        return whole.to_string();
    }
    let gap = match style {
        Style::Text => "\u{202f}",
        Style::Latex => r"\,",
    };
    let mut out = String::new();
    for (k, digit) in whole.chars().enumerate() {
        if k > 0 && (whole.len() - k).is_multiple_of(3) {
            out.push_str(gap);
        }
        out.push(digit);
    }
    out
}

fn minus(style: Style) -> &'static str {
    match style {
        Style::Text => "−",
        Style::Latex => "-",
    }
}

fn with_power(digits: &str, exponent: i32, style: Style) -> String {
    match style {
        Style::Text => format!("{digits}\u{2009}×\u{2009}{}", power_of_ten(exponent)),
        Style::Latex => format!(r"{digits}\times 10^{{{exponent}}}"),
    }
}

/// `10⁻⁵` in Unicode.
pub(super) fn power_of_ten(exponent: i32) -> String {
    let raised = |c: char| match c {
        '-' => '⁻',
        '0' => '⁰',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        c => char::from_u32('⁰' as u32 + c.to_digit(10).unwrap_or(0)).unwrap_or(c),
    };
    format!("10{}", exponent.to_string().chars().map(raised).collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(value: f64, std: f64) -> String {
        estimate(value, Some(std), Style::Text).replace(['\u{202f}', '\u{2009}'], " ")
    }

    #[test]
    fn the_deviation_has_two_digits_and_the_value_ends_at_the_same_place() {
        assert_eq!(text(309.07, 18.8), "309 ± 19");
        assert_eq!(text(-0.12345, 0.0123), "−0.123 ± 0.012");
        assert_eq!(text(2.0, 0.5), "2.00 ± 0.50");
        assert_eq!(text(1234.5, 123.0), "1230 ± 120");
        assert_eq!(text(123_456.0, 1234.0), "123 500 ± 1200");
        assert_eq!(text(3.0, 1200.0), "0 ± 1200");
    }

    #[test]
    fn rounding_that_carries_moves_the_place() {
        assert_eq!(text(1.0, 0.0996), "1.00 ± 0.10");
        assert_eq!(text(9.999, 0.996), "10.0 ± 1.0");
        assert_eq!(text(999_999.9, 12.0), "1 000 000 ± 12");
    }

    #[test]
    fn extremes_share_one_power_of_ten() {
        assert_eq!(text(1.24e-5, 3.1e-6), "(1.24 ± 0.31) × 10⁻⁵");
        assert_eq!(text(0.0, 3.1e-6), "(0.0 ± 3.1) × 10⁻⁶");
        assert_eq!(text(-4.2e9, 1.5e8), "(−4.20 ± 0.15) × 10⁹");
        assert_eq!(text(1e300, 1e299), "(1.00 ± 0.10) × 10³⁰⁰");
        assert_eq!(text(5e-324, 5e-324), "(4.9 ± 4.9) × 10⁻³²⁴");
    }

    #[test]
    fn what_has_no_digits_is_said_in_signs() {
        assert_eq!(text(f64::NAN, 1.0), "– ± 1.0");
        assert_eq!(text(12.0, f64::INFINITY), "12.00 ± ∞");
        assert_eq!(number(f64::NEG_INFINITY, 3, Style::Text), "−∞");
        assert_eq!(number(-0.0, 3, Style::Text), "0");
        assert_eq!(estimate(2.5, None, Style::Text), "2.500");
        assert_eq!(estimate(2.5, Some(0.0), Style::Text), "2.500");
        assert_eq!(text(-0.0001, 0.5), "0.00 ± 0.50");
    }

    #[test]
    fn a_tiny_deviation_does_not_ask_for_forty_digits() {
        assert_eq!(text(1e6, 1e-9), "1.00000000000 × 10⁶ ± 1.0 × 10⁻⁹");
    }

    #[test]
    fn latex_is_mathematics() {
        assert_eq!(estimate(-1.24e-5, Some(3.1e-6), Style::Latex), r"(-1.24 \pm 0.31)\times 10^{-5}");
        assert_eq!(number(123_456.0, 6, Style::Latex), r"123\,456");
    }

    #[test]
    fn files_get_numbers_that_read_back() {
        for x in [0.1, -3.0, 1.0 / 3.0, 1e-300, f64::MAX, f64::MIN_POSITIVE] {
            assert!(exact(x).parse::<f64>().is_ok_and(|y| y.to_bits() == x.to_bits()), "{x} as {}", exact(x));
        }
        assert_eq!(exact(f64::NAN), "");
        assert_eq!(exact(-0.0), "0");
    }
}
