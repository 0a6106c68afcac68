//! Numbers: from the bytes of a cell without allocating, and short in messages.

const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20,
    1e21, 1e22,
];

/// The number written in a cell, correctly rounded. It may be NaN or infinite (`nan`, `inf`, `1e400`); `None` when
/// the cell holds no number. `decimal` is the byte of the decimal mark.
#[inline]
pub fn parse(cell: &[u8], decimal: u8) -> Option<f64> {
    match short_decimal(cell, decimal) {
        Some(x) => Some(x),
        None => any_number(cell, decimal),
    }
}

/// `-12.345` with at most 15 digits: mantissa and power of ten are both exact in f64, so one division rounds once
/// (Clinger, PLDI 1990).
#[inline]
fn short_decimal(cell: &[u8], decimal: u8) -> Option<f64> {
    let (negative, digits) = match cell {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        _ => (false, cell),
    };
    if digits.is_empty() || digits.len() > 16 {
        return None;
    }
    let mut mantissa = 0u64;
    let mut after = None;
    for (i, &byte) in digits.iter().enumerate() {
        let digit = byte.wrapping_sub(b'0');
        if digit < 10 {
            mantissa = mantissa * 10 + u64::from(digit);
        } else if byte == decimal && after.is_none() {
            after = Some(digits.len() - 1 - i);
        } else {
            return None;
        }
    }
    if digits.len() - usize::from(after.is_some()) == 0 || mantissa >= 1 << 53 {
        return None;
    }
    #[allow(clippy::cast_precision_loss)] // below 2⁵³
    let x = mantissa as f64 / POWERS[after.unwrap_or(0)];
    Some(if negative { -x } else { x })
}

/// Exponents, many digits, `nan`, `inf`.
#[cold]
fn any_number(cell: &[u8], decimal: u8) -> Option<f64> {
    let text = std::str::from_utf8(cell).ok()?;
    if decimal == b'.' {
        return text.parse().ok();
    }
    if text.contains('.') {
        return None;
    }
    text.replace(char::from(decimal), ".").parse().ok()
}

/// `x` with at most `digits` significant digits, as C's `%g` writes it: `0.1`, `3600.1`, `1e+08`.
pub fn short(x: f64, digits: usize) -> String {
    if x == 0.0 || !x.is_finite() {
        return x.to_string();
    }
    let text = format!("{x:.*e}", digits.max(1) - 1);
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let trimmed = |t: &str| {
        if t.contains('.') { t.trim_end_matches('0').trim_end_matches('.').to_string() } else { t.to_string() }
    };
    if exponent < -4 || exponent >= i32::try_from(digits).unwrap_or(i32::MAX) {
        let sign = if exponent < 0 { '-' } else { '+' };
        return format!("{}e{sign}{:02}", trimmed(mantissa), exponent.abs());
    }
    let decimals = usize::try_from(i32::try_from(digits).unwrap_or(0) - 1 - exponent).unwrap_or(0);
    trimmed(&format!("{x:.decimals$}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn what_is_a_number_and_what_is_not() {
        let number = |text: &str| parse(text.as_bytes(), b'.');
        for (text, x) in [("0.10", 0.1), ("+3e-1", 0.3), ("1.0E+00", 1.0), (".5", 0.5), ("5.", 5.0), ("-7", -7.0)] {
            assert_eq!(number(text), Some(x), "{text}");
        }
        assert!(number("-0.0").is_some_and(|x| x == 0.0 && x.is_sign_negative()));
        assert_eq!(number("4.9e-324"), Some(f64::from_bits(1)));
        assert_eq!(number("1e400"), Some(f64::INFINITY));
        for text in ["", "-", ".", "0.12.3", "1,5", "0x10", "1_000", "\u{2212}0.5", "N/A", "1 2", "--1"] {
            assert_eq!(number(text), None, "{text}");
        }
        assert_eq!(parse(b"0,10", b','), Some(0.1));
        assert_eq!(parse(b"1,5e3", b','), Some(1500.0));
        assert_eq!(parse(b"0.10", b','), None);
        assert_eq!(parse(b"1.5e3", b','), None);
    }

    #[test]
    fn short_numbers_as_percent_g() {
        for (x, text) in [(1e8, "1e+08"), (100.0, "100"), (3600.1, "3600.1"), (0.1, "0.1"), (-32.768, "-32.768")] {
            assert_eq!(short(x, 6), text);
        }
        assert_eq!(short(1.0e-7, 6), "1e-07");
        assert_eq!(short(123_456.7, 3), "1.23e+05");
        assert_eq!(short(999_999.9, 6), "1e+06");
        assert_eq!(short(0.0, 6), "0");
    }

    proptest! {
        // Both ways of reading must agree with the standard library to the bit.
        #[test]
        fn law_same_as_the_standard_library(negative: bool, whole in 0u64..1_000_000_000, fraction in 0u64..100_000_000, width in 1usize..9) {
            let text = format!("{}{whole}.{fraction:0width$}", if negative { "-" } else { "" });
            let x: f64 = text.parse().unwrap();
            prop_assert_eq!(parse(text.as_bytes(), b'.').map(f64::to_bits), Some(x.to_bits()));
        }

        #[test]
        fn law_what_is_printed_is_read_back(x in proptest::num::f64::NORMAL | proptest::num::f64::SUBNORMAL | proptest::num::f64::ZERO) {
            prop_assert_eq!(parse(format!("{x:?}").as_bytes(), b'.').map(f64::to_bits), Some(x.to_bits()));
        }
    }
}
