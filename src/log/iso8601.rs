//! Dates of ISO 8601: converts `2024-07-01T10:40:00.100Z` to nanoseconds since
//! 1970-01-01T00:00:00Z.
//!
//! The day number of the civil calendar is computed after H. Hinnant, "chrono-compatible low-level
//! date algorithms". The offset may be `Z`, `+02:00`, `+0200`, `+02` or absent (then all stamps are
//! assumed to be in the same zone, since only differences count).

/// Nanoseconds since 1970; `None` if the text is no such date.
pub fn nanoseconds(text: &[u8]) -> Option<i128> {
    let (date, clock) = (text.get(..10)?, text.get(11..)?);
    if !matches!(text[10], b'T' | b't' | b' ') || date[4] != b'-' || date[7] != b'-' {
        return None;
    }
    let days = days(digits(&date[..4])?, digits(&date[5..7])?, digits(&date[8..])?)?;
    let zone_at = clock.iter().position(|b| matches!(b, b'Z' | b'z' | b'+' | b'-')).unwrap_or(clock.len());
    let (clock, zone) = clock.split_at(zone_at);
    let seconds = i128::from(days * 86_400 - zone_seconds(zone)?);
    Some(seconds * 1_000_000_000 + i128::from(of_day(clock)?))
}

/// Nanoseconds since 1970 of a date (`2024-07-01`, `2024/07/01`, `20240701`, `01.07.2024`) and a
/// time of day in two texts.
pub fn of_date_and_time(date: &[u8], time: &[u8]) -> Option<i128> {
    let days = match *date {
        [y1, y2, y3, y4, b'-' | b'/', m1, m2, b'-' | b'/', d1, d2] | [y1, y2, y3, y4, m1, m2, d1, d2] => {
            days(digits(&[y1, y2, y3, y4])?, digits(&[m1, m2])?, digits(&[d1, d2])?)?
        }
        [d1, d2, b'.', m1, m2, b'.', y1, y2, y3, y4] => {
            days(digits(&[y1, y2, y3, y4])?, digits(&[m1, m2])?, digits(&[d1, d2])?)?
        }
        _ => return None,
    };
    Some(i128::from(days) * NANOSECONDS_A_DAY + i128::from(of_day(time)?))
}

/// Nanoseconds since midnight of `hh:mm`, `hh:mm:ss` or `hh:mm:ss.fff`.
pub fn time_of_day(text: &[u8]) -> Option<i128> {
    of_day(text).map(i128::from)
}

/// Nanoseconds per day.
pub const NANOSECONDS_A_DAY: i128 = 86_400_000_000_000;

/// Whether the text begins like a date, `dddd-dd-dd`.
pub fn looks_like_one(text: &[u8]) -> bool {
    text.len() >= 10
        && text[..10].iter().enumerate().all(|(i, b)| if i == 4 || i == 7 { *b == b'-' } else { b.is_ascii_digit() })
}

fn digits(text: &[u8]) -> Option<i64> {
    if text.is_empty() || text.len() > 9 {
        return None;
    }
    text.iter().try_fold(0, |n, b| b.is_ascii_digit().then(|| n * 10 + i64::from(b - b'0')))
}

/// Days since 1970-01-01.
fn days(year: i64, month: i64, day: i64) -> Option<i64> {
    let leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
    let length = match month {
        2 => 28 + i64::from(leap),
        4 | 6 | 9 | 11 => 30,
        1..=12 => 31,
        _ => return None,
    };
    if !(1..=length).contains(&day) {
        return None;
    }
    let year = year - i64::from(month <= 2);
    let era = year.div_euclid(400);
    let of_era = year.rem_euclid(400);
    let of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
    Some(era * 146_097 + of_era * 365 + of_era / 4 - of_era / 100 + of_year - 719_468)
}

/// Nanoseconds of the day, from `hh:mm`, `hh:mm:ss` or `hh:mm:ss.fff`; second 60 is accepted as a
/// leap second.
fn of_day(clock: &[u8]) -> Option<i64> {
    if clock.len() < 5 || clock[2] != b':' {
        return None;
    }
    let (hour, minute) = (digits(&clock[..2])?, digits(&clock[3..5])?);
    let (second, fraction) = match &clock[5..] {
        [] => (0, 0),
        [b':', a, b] => (digits(&[*a, *b])?, 0),
        [b':', a, b, b'.' | b',', fraction @ ..] => {
            // digits beyond the nanosecond are cut
            let kept = &fraction[..fraction.len().min(9)];
            if !fraction.iter().all(u8::is_ascii_digit) {
                return None;
            }
            let unit = 10_i64.pow(u32::try_from(9 - kept.len()).ok()?);
            (digits(&[*a, *b])?, digits(kept)? * unit)
        }
        _ => return None,
    };
    (hour < 24 && minute < 60 && second <= 60)
        .then_some((hour * 3600 + minute * 60 + second) * 1_000_000_000 + fraction)
}

fn zone_seconds(zone: &[u8]) -> Option<i64> {
    let (sign, hours, minutes) = match zone {
        [] | [b'Z' | b'z'] => return Some(0),
        [sign, a, b] => (sign, digits(&[*a, *b])?, 0),
        [sign, a, b, c, d] | [sign, a, b, b':', c, d] => (sign, digits(&[*a, *b])?, digits(&[*c, *d])?),
        _ => return None,
    };
    let seconds = hours * 3600 + minutes * 60;
    match sign {
        b'+' => Some(seconds),
        b'-' => Some(-seconds),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_become_nanoseconds() {
        // `date -u -d 2024-07-01T10:40:00Z +%s` (GNU coreutils 9.1)
        let t0 = 1_719_830_400_000_000_000;
        for text in ["2024-07-01T10:40:00Z", "2024-07-01 10:40", "2024-07-01T12:40:00+02:00", "2024-07-01T05:10-0530"] {
            assert_eq!(nanoseconds(text.as_bytes()), Some(t0), "{text}");
        }
        assert_eq!(nanoseconds(b"2024-07-01T10:40:00.100Z"), Some(t0 + 100_000_000));
        assert_eq!(nanoseconds(b"2024-07-01T10:40:00.1234567891Z"), Some(t0 + 123_456_789));
        assert_eq!(nanoseconds(b"1970-01-01T00:00:00Z"), Some(0));
        assert_eq!(nanoseconds(b"2000-02-29T00:00:00Z"), Some(951_782_400_000_000_000));
    }

    #[test]
    fn impossible_dates_are_none() {
        for text in
            ["2023-02-29T00:00:00Z", "2024-13-01T00:00:00Z", "2024-07-01", "2024-07-01T25:00:00Z", "00:00:00.00", ""]
        {
            assert_eq!(nanoseconds(text.as_bytes()), None, "{text}");
        }
        assert!(looks_like_one(b"2024-07-01") && !looks_like_one(b"1719830400"));
    }
}
