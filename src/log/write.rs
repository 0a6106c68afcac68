//! Writing a run as CSV: headers `name [unit]`, shortest decimals that read back to the same bits. A name
//! that a spreadsheet would take for a formula gets an apostrophe in front, which the reader removes.
//!
//! Signals with their own time stamps are written in one table over all stamps, with empty cells
//! where a sensor has no sample; such a file is read back with `missing = "no_sample"`.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::Write;
use std::path::Path;

use csv::{Terminator, WriterBuilder};

use super::columns::quantity;
use super::read::LogFile;
use crate::atomic_file;
use crate::progress;
use crate::run::{Run, Signal};
use crate::spreadsheet::harmless;

/// Number of rows between two checks for cancellation.
const ROWS_A_LOOK: usize = 1024;

/// Reason why a run was not written.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The file cannot be made or written.
    #[error("{file}: {source}")]
    File {
        /// As given.
        file: String,
        /// The system's reason.
        source: std::io::Error,
    },
}

/// Writes a run to a file atomically: the file is replaced completely or not at all.
///
/// # Errors
/// [`WriteError`] if the file cannot be written.
pub fn write(run: &Run, path: impl AsRef<Path>) -> Result<(), WriteError> {
    let path = path.as_ref();
    atomic_file::write(path, |file| write_to(run, file))
        .map_err(|source| WriteError::File { file: path.display().to_string(), source })
}

/// Writes a log that was read: its signals, commands in the unit in which they were logged.
///
/// # Errors
/// Those of the sink.
pub fn write_log(log: &LogFile, sink: &mut impl Write) -> std::io::Result<()> {
    write_signals(&log.signals, &log.units, sink)
}

/// Writes a run: `t`, then the signals by name.
///
/// # Errors
/// Those of the sink.
pub fn write_to(run: &Run, sink: &mut impl Write) -> std::io::Result<()> {
    write_signals(&run.signals, &BTreeMap::new(), sink)
}

/// Writes signals; a header has the unit in `units`, or else the default unit of the quantity.
///
/// # Errors
/// Those of the sink.
pub fn write_signals(
    signals: &BTreeMap<String, Signal>,
    units: &BTreeMap<String, &'static str>,
    sink: &mut impl Write,
) -> std::io::Result<()> {
    write_stamped(signals, units, "t [s]", |t, digits| write!(digits, "{t:?}"), sink)
}

/// Writes signals with the stamps of a wall clock, in whole nanoseconds: `t = 0` of the signals is
/// `origin`, ns since 1970.
///
/// # Errors
/// Those of the sink.
#[allow(clippy::cast_possible_truncation)] // a log of 292 years
pub fn write_wall_clock(
    signals: &BTreeMap<String, Signal>,
    units: &BTreeMap<String, &'static str>,
    origin: i64,
    sink: &mut impl Write,
) -> std::io::Result<()> {
    write_stamped(signals, units, "t [ns]", |t, digits| write!(digits, "{}", origin + (t * 1e9).round() as i64), sink)
}

/// Writes signals; `time` is the header of the time column, and `stamp` writes a time, s, into it.
fn write_stamped(
    signals: &BTreeMap<String, Signal>,
    units: &BTreeMap<String, &'static str>,
    time: &str,
    stamp: impl Fn(f64, &mut String) -> std::fmt::Result,
    sink: &mut impl Write,
) -> std::io::Result<()> {
    let signals: Vec<(&str, &Signal)> = signals.iter().map(|(name, s)| (name.as_str(), s)).collect();
    let mut table = WriterBuilder::new().terminator(Terminator::Any(b'\n')).from_writer(sink);
    table.write_field(time)?;
    for (name, _) in &signals {
        let usual = quantity(name).and_then(|q| q.units().first()).map(|unit| unit.name);
        let header = match units.get(*name).copied().or(usual) {
            Some(unit) => format!("{name} [{unit}]"),
            None => (*name).to_string(),
        };
        table.write_field(&*harmless(&header))?;
    }
    table.write_record(None::<&[u8]>)?;
    // merge of the time stamps: each row holds the signals that have a sample at its time
    let mut next = vec![0; signals.len()];
    let mut digits = String::new();
    for row in 0_usize.. {
        if row.is_multiple_of(ROWS_A_LOOK) {
            progress::look();
        }
        let stamps = signals.iter().zip(&next).filter_map(|((_, s), k)| s.time().get(*k));
        let Some(t) = stamps.copied().min_by(f64::total_cmp) else { return table.flush() };
        digits.clear();
        let _ = stamp(t, &mut digits);
        table.write_field(&digits)?;
        let mut put = |x: Option<f64>| {
            digits.clear();
            let _ = x.map(|x| write!(digits, "{x:?}"));
            table.write_field(&digits)
        };
        for ((_, signal), k) in signals.iter().zip(&mut next) {
            let there = signal.time().get(*k).is_some_and(|s| s.to_bits() == t.to_bits());
            put(there.then(|| signal.values()[*k]))?;
            *k += usize::from(there);
        }
        table.write_record(None::<&[u8]>)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::{LogOptions, options::Missing, read_from};

    #[test]
    fn commands_keep_the_unit_of_their_log() {
        let text = b"t,u,V1 [us],V2 [1],V3\n0,1,1500,0.5,12\n1,1,1600,0.25,6\n";
        let log = read_from(&text[..], "pwm", &LogOptions::default(), &["t", "u"]).unwrap();
        let mut bytes = Vec::new();
        write_log(&log, &mut bytes).unwrap();
        assert!(bytes.starts_with(b"t [s],V1 [us],V2 [1],V3 [V],u [m/s]\n0.0,1500.0,0.5,12.0,1.0\n"));
        let again = read_from(&bytes[..], "written", &LogOptions::default(), &["t", "u"]).unwrap();
        assert_eq!((again.signals, again.units), (log.signals, log.units));
    }

    #[test]
    fn sensors_of_different_rates_come_back() {
        let mut run = Run::default();
        let signal = |t: &[f64], x: &[f64]| Signal::new(t.into(), x);
        run.signals.insert("u".into(), signal(&[0.0, 0.5], &[1e300, -0.0]));
        run.signals.insert("tau_r".into(), signal(&[0.0, 0.1, 0.5], &[1.0, 0.1 + 0.2, 4.9e-324]));
        run.signals.insert("wind, \"gusts\"".into(), signal(&[0.1], &[7.5]));
        // formulas to a spreadsheet, one of them quoted
        run.signals.insert("=cmd|' /C calc'!A0".into(), signal(&[0.1], &[-2.5]));
        run.signals.insert("@sum(1,2)".into(), signal(&[0.5], &[1.0]));
        let mut bytes = Vec::new();
        write_to(&run, &mut bytes).unwrap();
        let header = "t [s],'=cmd|' /C calc'!A0,\"'@sum(1,2)\",tau_r [N*m],u [m/s],\"wind, \"\"gusts\"\"\"\n";
        assert!(bytes.starts_with(header.as_bytes()), "{}", String::from_utf8_lossy(&bytes));
        assert!(bytes[header.len()..].starts_with(b"0.0,,,1.0,1e300,\n"), "{}", String::from_utf8_lossy(&bytes));
        let options = LogOptions { missing: Missing::NoSample, ..LogOptions::default() };
        let log = read_from(&bytes[..], "written", &options, &["t", "u"]).unwrap();
        assert_eq!(log.signals, run.signals);
    }
}
