//! Numbers: parsed from the bytes of a cell (plain decimals without allocation), and short in messages.

const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20,
    1e21, 1e22,
];

/// The first nine powers of ten as integers.
const WHOLE: [u64; 9] = [1, 10, 100, 1_000, 10_000, 100_000, 1_000_000, 10_000_000, 100_000_000];

/// Returns the number written in a cell, correctly rounded. It may be NaN or infinite (`nan`,
/// `inf`, `1e400`); `None` if the cell holds no number. `decimal` is the byte of the decimal mark.
#[inline]
pub fn parse(cell: &[u8], decimal: u8) -> Option<f64> {
    match leading(cell, decimal) {
        Some(plain) if plain.bytes == cell.len() => Some(plain.value),
        _ => any_number(cell, decimal),
    }
}

/// A plain decimal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Plain {
    /// Its value, correctly rounded.
    pub value: f64,
    /// Its length in bytes.
    pub bytes: usize,
    /// Number of digits after the decimal mark.
    pub decimals: usize,
}

/// Returns the plain decimal (`-12.345`) at the start of `text`; `None` if there is none or if it
/// has too many digits. A mantissa below 2⁵³ and the power of ten are both exact in f64, so one
/// division rounds once (Clinger, PLDI 1990).
#[inline]
pub(super) fn leading(text: &[u8], decimal: u8) -> Option<Plain> {
    let negative = text.first() == Some(&b'-');
    let begin = usize::from(negative || text.first() == Some(&b'+'));
    let (mantissa, whole) = digits(text.get(begin..)?, 0);
    let mark = begin + whole;
    let (mantissa, decimals, bytes) = if text.get(mark) == Some(&decimal) {
        let (mantissa, decimals) = digits(&text[mark + 1..], mantissa);
        (mantissa, decimals, mark + 1 + decimals)
    } else {
        (mantissa, 0, mark)
    };
    let count = whole + decimals;
    if count == 0 || count > 19 || mantissa >= 1 << 53 {
        return None;
    }
    #[allow(clippy::cast_precision_loss)] // below 2⁵³
    let x = mantissa as f64 / POWERS[decimals];
    Some(Plain { value: if negative { -x } else { x }, bytes, decimals })
}

/// Returns the number (modulo 2⁶⁴) whose digits are those of `before` followed by those at the
/// start of `text`, and the count of the latter. Reads eight bytes at a time, without a branch on
/// the number of digits among them (Langdale and Lemire, *VLDB Journal* 28 (2019) 941).
#[inline]
fn digits(mut text: &[u8], before: u64) -> (u64, usize) {
    const EACH: u64 = 0x0101_0101_0101_0101;
    let (mut number, mut count) = (before, 0);
    loop {
        let eight = text.first_chunk().copied().unwrap_or_else(|| padded(text));
        let values = u64::from_le_bytes(eight) ^ (0x30 * EACH);
        // the high bit of each byte that is no digit; a carry reaches only bytes after the first of them
        let others = (values | values.wrapping_add(0x76 * EACH)) & (0x80 * EACH);
        let here = (others.trailing_zeros() / 8) as usize;
        // the digits moved to the end of the eight bytes, zeros before them
        let eight = if here == 0 { 0 } else { values << (64 - 8 * here) };
        let pairs = (eight.wrapping_mul(10 * 256 + 1) >> 8) & 0x00ff_00ff_00ff_00ff;
        let fours = (pairs.wrapping_mul(100 * 65_536 + 1) >> 16) & 0x0000_ffff_0000_ffff;
        let all = fours.wrapping_mul(10_000 * (1 << 32) + 1) >> 32;
        number = number.wrapping_mul(WHOLE[here]).wrapping_add(all);
        count += here;
        if here < 8 {
            return (number, count);
        }
        text = &text[8..];
    }
}

/// Returns fewer than eight bytes, filled up with blanks, which are no digits.
#[cold]
fn padded(text: &[u8]) -> [u8; 8] {
    std::array::from_fn(|k| text.get(k).copied().unwrap_or(b' '))
}

/// Parses a number that is no plain decimal: an exponent, many digits, `nan`, `inf`.
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

/// Returns `x` with at most `digits` significant digits, as C's `%g` writes it: `0.1`, `3600.1`, `1e+08`.
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
        assert_eq!(number("0.000000000000000000001"), Some(1e-21));
        assert_eq!(number("00000000000000000000000000000007.5"), Some(7.5));
        assert_eq!(number("99999999999999999999"), Some(1e20));
    }

    #[test]
    fn a_plain_decimal_ends_at_the_first_byte_that_is_none() {
        let at = |text: &str| leading(text.as_bytes(), b'.').map(|p| (p.value, p.bytes, p.decimals));
        assert_eq!(at("-12.345,6"), Some((-12.345, 7, 3)));
        assert_eq!(at("12345678.87654321\n"), Some((12_345_678.876_543_21, 17, 8)));
        assert_eq!(at("7:8.5"), Some((7.0, 1, 0)));
        assert_eq!(at("3./"), Some((3.0, 2, 0)));
        for text in ["", "-", ".", "+.x", " 1", "\u{2212}1", "12345678901234567890"] {
            assert_eq!(at(text), None, "{text}");
        }
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
