//! Bad logs of the kinds of the corpus, with faults at other lines, columns and values, and logs
//! that must not be called bad.

use crate::swim::Swim;
use hydrosysid::finding::Finding;
use hydrosysid::log::{LogError, LogFile, LogOptions, PLANAR, read_from};
use hydrosysid::run::Run;
use proptest::prelude::*;

fn join(lines: &[String]) -> Vec<u8> {
    (lines.join("\n") + "\n").into_bytes()
}

fn read(bytes: &[u8], options: &str) -> Result<LogFile, LogError> {
    read_from(bytes, "f.csv", &toml::from_str::<LogOptions>(options).expect("options"), &PLANAR)
}

fn first(bytes: &[u8], options: &str) -> Finding {
    read(bytes, options).expect_err("refused").findings()[0].clone()
}

fn kinds(log: &LogFile) -> Vec<&'static str> {
    log.warnings.iter().map(|w| w.kind).collect()
}

/// The log of the swim with one cell replaced: line `line` (from 1), column `column`.
fn with_cell(line: usize, column: usize, cell: &str) -> Vec<u8> {
    let mut lines = Swim::new(10.0, 6.0, 1.0, 1).lines();
    let mut cells: Vec<&str> = lines[line - 1].split(',').collect();
    cells[column] = cell;
    lines[line - 1] = cells.join(",");
    join(&lines)
}

#[test]
fn sound_logs_are_accepted_without_a_word() {
    for (rate, seconds, scale) in
        [(5.0, 60.0, 1.0), (10.0, 20.0, 0.05), (20.0, 40.0, 1.0), (50.0, 30.0, 3.0), (10.0, 2.0, 1.0)]
    {
        for seed in 0..4 {
            let log = read(&join(&Swim::new(rate, seconds, scale, seed).lines()), "").unwrap();
            assert!(log.warnings.is_empty() && log.notes.is_empty(), "{rate} Hz, seed {seed}: {:?}", log.warnings);
        }
    }
}

#[test]
fn reversed_signs_are_named() {
    for (column, name) in [(1, "mu"), (2, "mv"), (3, "Ir"), (4, "mu"), (5, "mv"), (6, "Ir")] {
        for rate in [5.0, 10.0, 20.0] {
            let swim = Swim::new(rate, 40.0, 1.0, 2).change(|row| row[column] = -row[column]);
            let log = read(&join(&swim.lines()), "").unwrap();
            let warning = log.warnings.iter().find(|w| w.kind == "non-physical");
            let message = &warning.unwrap_or_else(|| panic!("{column} at {rate} Hz: {:?}", log.warnings)).message;
            assert!(message.contains(name) && message.contains("negative") && message.contains("frame"), "{message}");
        }
    }
}

#[test]
fn other_units_are_named() {
    let deg = Swim::new(10.0, 20.0, 1.0, 3).change(|row| row[3] = row[3].to_degrees());
    let log = read(&join(&deg.lines()), "").unwrap();
    assert!(log.warnings.iter().any(|w| w.kind == "unit" && w.message.contains("deg/s")));
    let read_right = read(&join(&deg.lines()), "columns.r = { name = \"r\", unit = \"deg/s\" }").unwrap();
    assert!(read_right.warnings.is_empty(), "{:?}", read_right.warnings);
    let cm = Swim::new(10.0, 20.0, 1.0, 3).change(|row| (row[1], row[2]) = (100.0 * row[1], 100.0 * row[2]));
    assert!(kinds(&read(&join(&cm.lines()), "").unwrap()).contains(&"unit"));
    let pwm = Swim::new(10.0, 20.0, 1.0, 3).change(|row| row[4..].iter_mut().for_each(|x| *x = (1500.0 + *x).round()));
    assert!(kinds(&read(&join(&pwm.lines()), "").unwrap()).contains(&"unit"));
}

#[test]
fn bad_cells_are_named_wherever_they_are() {
    for (column, name) in PLANAR.into_iter().enumerate().skip(1) {
        for line in [2, 17, 62] {
            for (cell, kind) in [
                ("nan", "non-finite"),
                ("-INF", "non-finite"),
                ("-1e999", "non-finite"),
                ("", "missing"),
                ("--", "parse"),
                ("1.2.3", "parse"),
                ("\u{2212}1", "parse"),
                ("1;5", "parse"),
                ("12 3", "parse"),
                ("#N/A", "parse"),
                ("\"\"", "missing"),
                ("\"a\nb\"", "parse"),
            ] {
                let found = first(&with_cell(line, column, cell), "");
                assert_eq!(
                    (found.kind, found.line, found.column.as_deref()),
                    (kind, Some(line as u64), Some(name)),
                    "{cell}"
                );
                assert!(found.message.contains(&format!("line {line}")) && found.message.contains("f.csv"));
            }
        }
    }
}

#[test]
fn missing_cells_under_the_options() {
    for cell in ["", "NaN", "-99.9"] {
        let bytes = with_cell(20, 2, cell);
        let options = "missing_values = [\"-99.90\"]\nmissing = ";
        let dropped = read(&bytes, &format!("{options}\"drop\"")).unwrap();
        assert_eq!((dropped.rows, kinds(&dropped)), (60, vec!["rows-dropped"]));
        let sparse = read(&bytes, &format!("{options}\"no_sample\"")).unwrap();
        assert_eq!((sparse.rows, sparse.signals["v"].len(), sparse.signals["u"].len()), (61, 60, 61));
        assert_eq!(kinds(&sparse), [""; 0]);
        assert!(read(&bytes, &format!("{options}\"error\"")).is_err());
    }
    assert_eq!(first(&with_cell(20, 2, "inf"), "missing = \"drop\"\nmissing_values = [\"inf\"]").kind, "non-finite");
}

#[test]
fn structure_faults_are_named_wherever_they_are() {
    let good = Swim::new(10.0, 6.0, 1.0, 1).lines();
    for at in [1, 7, 40, 60] {
        let line = Some(at as u64 + 1);
        let edit = |change: &dyn Fn(&mut String)| {
            let mut lines = good.clone();
            change(&mut lines[at]);
            first(&join(&lines), "")
        };
        let found = edit(&|l| l.push_str(",1"));
        assert_eq!((found.kind, found.line), ("field-count", line));
        let found = edit(&|l| l.truncate(l.rfind(',').unwrap()));
        assert_eq!((found.kind, found.line), ("field-count", line));
        let found = edit(&|l| l.push('\0'));
        assert_eq!((found.kind, found.line), ("encoding", line));
        let found = edit(&|l| l.insert(0, '"'));
        assert_eq!((found.kind, found.line), ("quote", line));
        let found = edit(&|l| *l = "x".repeat(2 << 20));
        assert_eq!((found.kind, found.line), ("line-length", line));
        let mut bytes = join(&good[..at]);
        bytes.extend([0xe9, b'\n']);
        let found = first(&bytes, "");
        assert_eq!((found.kind, found.line), ("encoding", line));
        let mut lines = good.clone();
        lines.insert(at, "  ".into());
        let log = read(&join(&lines), "").unwrap();
        // a blank line directly below the header is between records as well
        assert_eq!((kinds(&log), log.warnings[0].line), (vec!["blank-line"], line));
    }
}

#[test]
fn time_faults_are_named_wherever_they_are() {
    let good = Swim::new(10.0, 6.0, 1.0, 1).lines();
    for at in [3, 30, 61] {
        let line = Some(at as u64 + 1);
        let mut lines = good.clone();
        lines.insert(at, good[at - 1].clone());
        let found = first(&join(&lines), "");
        assert_eq!((found.kind, found.line, found.column.as_deref()), ("time-not-increasing", line, Some("t")));
        assert_eq!(
            read(&join(&lines), "duplicates = \"first\"").unwrap().signals,
            read(&join(&good), "").unwrap().signals
        );
        let mut joined = good[..at].to_vec();
        joined.extend(good.clone());
        let found = first(&join(&joined), "");
        assert_eq!((found.kind, found.line, found.column.as_deref()), ("parse", line, Some("t")));
    }
    let mut shuffled = good.clone();
    shuffled.swap(10, 50);
    assert_eq!(first(&join(&shuffled), "").kind, "time-not-increasing");
    assert_eq!(read(&join(&shuffled), "sort = true").unwrap().signals, read(&join(&good), "").unwrap().signals);
    let jump = Swim::new(10.0, 6.0, 1.0, 1).change(|row| row[0] += if row[0] > 2.95 { 86_400.0 } else { 0.0 });
    let log = read(&join(&jump.lines()), "").unwrap();
    assert_eq!((kinds(&log), log.warnings[0].line, log.segments()), (vec!["gap"], Some(32), 2));
}

#[test]
fn a_log_that_was_cut_off() {
    let bytes = join(&Swim::new(10.0, 6.0, 1.0, 1).lines());
    for cut in 1..50 {
        let cut_off = &bytes[..bytes.len() - cut];
        let log = read(cut_off, "truncated = \"drop\"").unwrap();
        assert!((60..=61).contains(&log.rows), "{cut}: {}", log.rows);
        if log.rows == 61 && cut > 1 {
            assert!(kinds(&log).contains(&"no-final-newline-short-field"), "{cut}");
        }
    }
}

#[test]
fn codes_and_spikes_are_named() {
    for (code, name, column) in [("-9999", "u", 1), ("32.767", "v", 2), ("99.99", "r", 3)] {
        let mut lines = Swim::new(10.0, 20.0, 1.0, 5).lines();
        for line in [100, 101, 150] {
            let mut cells: Vec<&str> = lines[line].split(',').collect();
            cells[column] = code;
            lines[line] = cells.join(",");
        }
        let log = read(&join(&lines), "").unwrap();
        let found = &log.warnings[0];
        assert_eq!(
            (found.kind, found.line, found.column.as_deref()),
            ("sentinel", Some(101), Some(name)),
            "{:?}",
            log.warnings
        );
        let options = format!("missing_values = [\"{code}\"]\nmissing = \"drop\"");
        assert_eq!(kinds(&read(&join(&lines), &options).unwrap()), ["rows-dropped"]);
    }
    for (column, cell, kind) in [(1, "7.5", "outlier"), (3, "-20", "outlier"), (5, "1e200", "implausible-magnitude")] {
        let log = read(&with_cell(33, column, cell), "").unwrap();
        assert_eq!((kinds(&log), log.warnings[0].line), (vec![kind], Some(33)), "{:?}", log.warnings);
    }
}

#[test]
fn other_axes_become_ours() {
    let good = read(&join(&Swim::new(10.0, 6.0, 1.0, 1).lines()), "").unwrap();
    let flu = Swim::new(10.0, 6.0, 1.0, 1).change(|row| [2, 3, 5, 6].into_iter().for_each(|i| row[i] = -row[i]));
    let log = read(&join(&flu.lines()), "body_frame = \"flu\"").unwrap();
    // both are rounded to six decimals, so they are the same to the bit
    assert_eq!(log.signals, good.signals);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    // Line ends, byte order mark, quotes, blanks and the order of columns do not change the numbers.
    #[test]
    fn law_the_dress_does_not_matter(
        order in Just((0..7).collect::<Vec<usize>>()).prop_shuffle(), end in 0usize..3, mark: bool, quotes: bool,
        blanks: bool, last: bool, delimiter in 0usize..4, comma: bool,
    ) {
        let lines = Swim::new(10.0, 2.0, 1.0, 7).lines();
        let (delimiter, end) = ([",", ";", "\t", "|"][delimiter], ["\n", "\r\n", "\r"][end]);
        let comma = comma && delimiter != ",";
        let dress = |line: &String| {
            let cells: Vec<&str> = line.split(',').collect();
            let cell = |i: &usize| {
                let cell = if comma { cells[*i].replace('.', ",") } else { cells[*i].to_string() };
                let cell = if quotes { format!("\"{cell}\"") } else { cell };
                if blanks { format!(" {cell}  ") } else { cell }
            };
            order.iter().map(cell).collect::<Vec<_>>().join(delimiter)
        };
        let mut text = if mark { "\u{feff}".to_string() } else { String::new() };
        text += &lines.iter().map(dress).collect::<Vec<_>>().join(end);
        if last { text += end; }
        let options = format!("delimiter = {delimiter:?}\ndecimal = {:?}", if comma { "," } else { "." });
        let log = read(text.as_bytes(), &options).unwrap();
        prop_assert_eq!(log.signals, read(&join(&lines), "").unwrap().signals);
        prop_assert!(log.warnings.is_empty());
    }

    // A written log is read back to the bit, for any numbers.
    #[test]
    fn law_write_then_read_is_the_same(
        rows in prop::collection::vec(prop::array::uniform6(prop::num::f64::NORMAL | prop::num::f64::ZERO | prop::num::f64::SUBNORMAL), 2..20),
        start in -100.0..100.0f64, step in 1e-3..10.0f64,
    ) {
        let time: std::sync::Arc<[f64]> = (0u32..).take(rows.len()).map(|k| start + step * f64::from(k)).collect();
        let mut run = Run::default();
        for (i, name) in PLANAR[1..].iter().enumerate() {
            let values: Vec<f64> = rows.iter().map(|r| r[i]).collect();
            run.signals.insert((*name).to_string(), hydrosysid::run::Signal::new(time.clone(), values));
        }
        let mut bytes = Vec::new();
        hydrosysid::log::write_to(&run, &mut bytes).unwrap();
        let log = read(&bytes, "").unwrap();
        for (name, signal) in &run.signals {
            let bits = |x: &[f64]| x.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            prop_assert_eq!(bits(log.signals[name].values()), bits(signal.values()));
            prop_assert_eq!(bits(log.signals[name].time()), bits(signal.time()));
        }
    }

    // Any bytes give a log with finite values or an error, never a panic.
    #[test]
    fn law_any_bytes_are_survived(noise in prop::collection::vec((0usize..1400, any::<u8>()), 0..8), cut in 0usize..1400) {
        let mut bytes = join(&Swim::new(10.0, 2.0, 1.0, 7).lines());
        let length = bytes.len();
        for (at, byte) in noise { bytes[at % length] = byte; }
        bytes.truncate(cut);
        if let Ok(log) = read(&bytes, "missing = \"no_sample\"\nsort = true") {
            prop_assert!(log.signals.values().all(|s| s.values().iter().all(|x| x.is_finite())));
        }
    }
}
