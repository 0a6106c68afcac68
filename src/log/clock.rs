//! Conversion of time stamps to seconds.
//!
//! A 64-bit float resolves the nanoseconds of a wall clock to 256 ns only. Stamps of a wall clock are
//! therefore read as integers (decimals as integers of 10⁻⁹ units), the first one is subtracted, and only
//! the difference becomes a float. Stamps that start near zero are kept as they are.

use super::iso8601;
use super::number;
use super::options::{TimeFormat, TimeUnit};
use crate::run::WALL_CLOCK;

/// Reason why a cell is no time stamp.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoTime {
    /// Not a number.
    Parse,
    /// NaN or infinite.
    NonFinite,
    /// A date where a number was expected.
    Date,
    /// No date where one was expected.
    NoDate,
    /// No date and time of day where two columns should hold them.
    NoDateAndTime,
    /// No time of day where one was expected.
    NoTimeOfDay,
    /// No number with a unit of time where one was expected.
    NoDuration,
}

/// Nanoseconds of a duration such as `12.3 sec`; `None` if the cell holds no number with a unit of time.
#[allow(clippy::cast_possible_truncation)] // a duration of 300 years fits
pub fn duration(cell: &[u8], decimal: u8) -> Option<i128> {
    let text = std::str::from_utf8(cell).ok()?.trim();
    let digits = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let seconds = match &text[digits.len()..] {
        "ms" => 1e-3,
        "s" | "sec" | "second" | "seconds" => 1.0,
        "min" => 60.0,
        "h" | "hr" | "hours" => 3600.0,
        "d" | "day" | "days" => 86_400.0,
        _ => return None,
    };
    let x = number::parse(digits.trim_end().as_bytes(), decimal)?;
    (x.is_finite() && x.abs() < 1e10).then(|| (x * seconds * 1e9).round() as i128)
}

/// Reader of the time column.
#[derive(Debug, Clone)]
pub struct Clock {
    written: Written,
    per_second: f64,
    decimal: u8,
    zero: Zero,
}

/// Notation of the stamps.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Written {
    /// As numbers.
    Number,
    /// As dates.
    Date,
    /// As numbers with a unit.
    Duration,
    /// As times of day: number of midnights passed, and the previous stamp.
    TimeOfDay { days: i128, before: i128 },
}

/// Value that is subtracted from the stamps.
#[derive(Debug, Clone, Copy)]
enum Zero {
    /// No stamp has been read yet.
    Unknown,
    /// Nothing.
    None,
    /// An exact stamp, in 10⁻⁹ of the unit.
    Exact(i128),
    /// A stamp that is written with an exponent.
    Float(f64),
}

impl Clock {
    /// Returns a clock for numbers in this unit or, if `format` is given, for stamps in that format.
    pub fn new(unit: TimeUnit, format: Option<TimeFormat>, decimal: u8) -> Clock {
        let written = match format {
            None => Written::Number,
            Some(TimeFormat::Iso8601) => Written::Date,
            Some(TimeFormat::Duration) => Written::Duration,
            Some(TimeFormat::TimeOfDay) => Written::TimeOfDay { days: 0, before: 0 },
        };
        let per_second = if written == Written::Number { unit.per_second() } else { 1e9 };
        Clock { written, per_second, decimal, zero: Zero::Unknown }
    }

    /// Returns the clock with a unit `times` as long: 0.1 for a counter of rows at 10 Hz.
    #[must_use]
    pub fn scaled(self, times: f64) -> Clock {
        Clock { per_second: self.per_second / times, ..self }
    }

    /// Value subtracted from the stamps, s (since 1970 for dates); `None` if nothing was subtracted.
    #[allow(clippy::cast_precision_loss)] // for people, the differences are exact
    pub fn origin(&self) -> Option<f64> {
        match self.zero {
            Zero::Unknown | Zero::None => None,
            Zero::Exact(n) => Some(n as f64 / self.scale()),
            Zero::Float(x) => Some(x / self.per_second),
        }
    }

    /// Number of integer units of an exact stamp per second.
    fn scale(&self) -> f64 {
        if self.written == Written::Number { 1e9 * self.per_second } else { 1e9 }
    }

    /// Divisor that turns a number into seconds; `None` if the stamp must be read from the bytes of
    /// its cell.
    #[inline]
    pub fn per_second(&self) -> Option<f64> {
        matches!(self.zero, Zero::None).then_some(self.per_second)
    }

    /// Whether a stamp has been read, so that the zero of the clock is known.
    #[inline]
    pub fn has_begun(&self) -> bool {
        !matches!(self.zero, Zero::Unknown)
    }

    /// Returns the time in this cell, s.
    ///
    /// # Errors
    /// [`NoTime`] if the cell holds no time stamp.
    #[inline]
    pub fn read(&mut self, cell: &[u8]) -> Result<f64, NoTime> {
        if let (Zero::None, Some(x)) = (self.zero, number::parse(cell, self.decimal)) {
            return if x.is_finite() { Ok(x / self.per_second) } else { Err(NoTime::NonFinite) };
        }
        self.read_wall_clock(cell)
    }

    /// Returns the time in a cell with the date and a cell with the time of day, s.
    ///
    /// # Errors
    /// [`NoTime::NoDateAndTime`] if they hold none.
    #[allow(clippy::cast_precision_loss)] // differences of stamps
    pub fn read_dated(&mut self, date: &[u8], time: &[u8]) -> Result<f64, NoTime> {
        let n = iso8601::of_date_and_time(date, time).ok_or(NoTime::NoDateAndTime)?;
        self.per_second = 1e9;
        self.written = Written::Date;
        Ok((n - self.exact_zero(n)) as f64 / 1e9)
    }

    #[allow(clippy::cast_precision_loss)] // differences of stamps; exact below 2⁵³ units
    fn read_wall_clock(&mut self, cell: &[u8]) -> Result<f64, NoTime> {
        let exact = match &mut self.written {
            Written::Number => None,
            Written::Date => Some(iso8601::nanoseconds(cell).ok_or(NoTime::NoDate)?),
            Written::Duration => Some(duration(cell, self.decimal).ok_or(NoTime::NoDuration)?),
            Written::TimeOfDay { days, before } => {
                let n = iso8601::time_of_day(cell).ok_or(NoTime::NoTimeOfDay)?;
                // back by more than half a day: midnight has passed
                if *before - n > iso8601::NANOSECONDS_A_DAY / 2 {
                    *days += 1;
                }
                *before = n;
                Some(n + *days * iso8601::NANOSECONDS_A_DAY)
            }
        };
        if let Some(n) = exact {
            return Ok((n - self.exact_zero(n)) as f64 / 1e9);
        }
        let Some(x) = number::parse(cell, self.decimal) else {
            return Err(if iso8601::looks_like_one(cell) { NoTime::Date } else { NoTime::Parse });
        };
        if !x.is_finite() {
            return Err(NoTime::NonFinite);
        }
        if matches!(self.zero, Zero::Unknown) {
            self.zero = match decimal_nanos(cell, self.decimal) {
                _ if x.abs() / self.per_second < WALL_CLOCK => Zero::None,
                Some(n) => Zero::Exact(n),
                None => Zero::Float(x),
            };
        }
        Ok(match self.zero {
            Zero::Exact(zero) => match decimal_nanos(cell, self.decimal) {
                Some(n) => (n - zero) as f64 / self.scale(),
                None => (x - zero as f64 / 1e9) / self.per_second,
            },
            Zero::Float(zero) => (x - zero) / self.per_second,
            Zero::Unknown | Zero::None => x / self.per_second,
        })
    }

    fn exact_zero(&mut self, first: i128) -> i128 {
        match self.zero {
            Zero::Exact(zero) => zero,
            _ => {
                self.zero = Zero::Exact(first);
                first
            }
        }
    }
}

/// A plain decimal with at most 9 digits after the mark and at most 30 bytes without its sign, as
/// an integer of 10⁻⁹ units.
fn decimal_nanos(cell: &[u8], decimal: u8) -> Option<i128> {
    let (negative, digits) = match cell {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        _ => (false, cell),
    };
    let (mut n, mut after) = (0i128, None);
    for &byte in digits {
        match byte {
            b'0'..=b'9' => {
                n = n.checked_mul(10)?.checked_add(i128::from(byte - b'0'))?;
                after = after.map(|a: u32| a + 1);
            }
            _ if byte == decimal && after.is_none() => after = Some(0),
            _ => return None,
        }
    }
    let left = 9u32.checked_sub(after.unwrap_or(0))?;
    let n = n.checked_mul(10i128.pow(left))?;
    (digits.len() <= 30).then_some(if negative { -n } else { n })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(unit: TimeUnit, format: Option<TimeFormat>, cells: &[&str]) -> Vec<f64> {
        let mut clock = Clock::new(unit, format, b'.');
        cells.iter().map(|c| clock.read(c.as_bytes()).unwrap()).collect()
    }

    #[test]
    fn exact_nanosecond_stamps_keep_every_nanosecond() {
        let t = read(TimeUnit::Ns, None, &["1719830400000000000", "1719830400000000001", "1719830400100000000"]);
        assert_eq!(t, [0.0, 1e-9, 0.1]);
        let t = read(TimeUnit::S, None, &["1719830400.0", "1719830400.1"]);
        assert_eq!(t, [0.0, 0.1]);
        // nanoseconds read as seconds by mistake: the step of 1e8 s shows it
        assert_eq!(read(TimeUnit::S, None, &["1719830400000000000", "1719830400100000000"]), [0.0, 1e8]);
    }

    #[test]
    fn stamps_near_zero_are_kept() {
        assert_eq!(read(TimeUnit::Ms, None, &["100", "200"]), [0.1, 0.2]);
        assert_eq!(read(TimeUnit::S, None, &["12.5", "12.6"]), [12.5, 12.6]);
        let mut rows = Clock::new(TimeUnit::S, None, b'.').scaled(0.1);
        assert_eq!(["1", "2", "15"].map(|cell| rows.read(cell.as_bytes()).unwrap()), [0.1, 0.2, 1.5]);
    }

    #[test]
    fn dates_count_from_the_first() {
        let cells = ["2024-07-01T23:59:59.900Z", "2024-07-02T00:00:00.000Z"];
        assert_eq!(read(TimeUnit::S, Some(TimeFormat::Iso8601), &cells), [0.0, 0.1]);
        let mut dated = Clock::new(TimeUnit::S, None, b'.');
        let of = |date: &str, time: &str, clock: &mut Clock| clock.read_dated(date.as_bytes(), time.as_bytes());
        assert_eq!(of("2024-02-28", "23:59:59.5", &mut dated), Ok(0.0));
        assert_eq!(of("29.02.2024", "00:00:00", &mut dated), Ok(0.5));
        assert_eq!(of("20240229", "00:00:01", &mut dated), Ok(1.5));
        assert_eq!(of("02/29/2024", "00:00:02", &mut dated), Err(NoTime::NoDateAndTime));
        let durations = ["0.1 sec", "0.35 sec", "1 min", "2.5 hr"];
        assert_eq!(read(TimeUnit::S, Some(TimeFormat::Duration), &durations), [0.0, 0.25, 59.9, 8999.9]);
        assert_eq!(duration(b"12.3", b'.'), None);
        assert_eq!(duration(b"12.3 parsec", b'.'), None);
        // a letter of several bytes, and the replacement character
        for text in ["3.5 µ", "3.5\u{fffd}", "µs", "ms"] {
            assert_eq!(duration(text.as_bytes(), b'.'), None, "{text}");
        }
        let night = ["23:59:59.900", "00:00:00.100", "12:00:00", "23:00:00", "00:00:00"];
        let t = read(TimeUnit::S, Some(TimeFormat::TimeOfDay), &night);
        assert_eq!(t, [0.0, 0.2, 43_200.1, 82_800.1, 86_400.1]);
        let mut clock = Clock::new(TimeUnit::S, None, b'.');
        assert_eq!(clock.read(cells[0].as_bytes()), Err(NoTime::Date));
        assert_eq!(clock.read(b"00:00:00.00"), Err(NoTime::Parse));
        assert_eq!(clock.read(b"inf"), Err(NoTime::NonFinite));
    }
}
