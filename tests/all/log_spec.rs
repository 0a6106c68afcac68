//! The reader compared with a simple implementation of the rules: a log with faults is refused for
//! the first of them, and a log without faults gives the numbers in its text.

#![allow(clippy::unwrap_used)] // tests, and the small functions they share

use crate::swim::Swim;
use hydrosysid::log::{LogOptions, PLANAR, read_from};
use proptest::prelude::*;

/// A change to a log; line 0 is the header.
#[derive(Debug, Clone)]
enum Edit {
    Cell(usize, usize, &'static str),
    Blank(usize),
    DropField(usize),
    AddField(usize),
    Repeat(usize),
    Swap(usize, usize),
    Delete(usize),
    Comment(usize),
    HeaderAgain(usize),
}

const CELLS: [&str; 22] = [
    "nan",
    "NaN",
    "inf",
    "-Infinity",
    "1e400",
    "",
    "  ",
    "abc",
    "0x10",
    "1_0",
    "1.2.3",
    "\u{2212}1",
    "--1",
    "1e",
    "1,0e",
    " 0.5 ",
    "+.25",
    "5.",
    "1e-3",
    "-0.0",
    "\"0.125\"",
    "4.9e-324",
];

fn edit() -> impl Strategy<Value = Edit> {
    let line = 1usize..40;
    prop_oneof![
        4 => (line.clone(), 0usize..7, prop::sample::select(&CELLS[..])).prop_map(|(l, c, x)| Edit::Cell(l, c, x)),
        1 => line.clone().prop_map(Edit::Blank),
        1 => line.clone().prop_map(Edit::DropField),
        1 => line.clone().prop_map(Edit::AddField),
        1 => line.clone().prop_map(Edit::Repeat),
        1 => (line.clone(), line.clone()).prop_map(|(a, b)| Edit::Swap(a, b)),
        1 => line.clone().prop_map(Edit::Delete),
        1 => line.clone().prop_map(Edit::Comment),
        1 => line.prop_map(Edit::HeaderAgain),
    ]
}

fn apply(lines: &mut Vec<String>, edit: &Edit) {
    let there = |l: usize| l.min(lines.len() - 1);
    match *edit {
        Edit::Cell(l, c, text) => {
            let l = there(l);
            let mut cells: Vec<String> = lines[l].split(',').map(str::to_string).collect();
            if let Some(cell) = cells.get_mut(c) {
                *cell = text.into();
            }
            lines[l] = cells.join(",");
        }
        Edit::Blank(l) => lines.insert(there(l), " \t".into()),
        Edit::DropField(l) => {
            let l = there(l);
            let end = lines[l].rfind(',').unwrap_or(lines[l].len());
            lines[l].truncate(end);
        }
        Edit::AddField(l) => {
            let l = there(l);
            lines[l].push_str(",7");
        }
        Edit::Repeat(l) => {
            let l = there(l);
            lines.insert(l, lines[l].clone());
        }
        Edit::Swap(a, b) => {
            let (a, b) = (there(a), there(b));
            lines.swap(a, b);
        }
        Edit::Delete(l) => {
            let l = there(l);
            if lines.len() > 20 {
                lines.remove(l);
            }
        }
        Edit::Comment(l) => lines.insert(there(l), "# made by hand".into()),
        Edit::HeaderAgain(l) => lines.insert(there(l), PLANAR.join(",")),
    }
}

/// A number by the rules: with a decimal point, and finite.
fn number(cell: &str) -> Result<f64, &'static str> {
    let cell = cell.trim();
    let cell = cell.strip_prefix('"').and_then(|c| c.strip_suffix('"')).unwrap_or(cell).trim();
    match cell.parse::<f64>() {
        _ if cell.is_empty() => Err("missing"),
        Ok(x) if x.is_finite() => Ok(x),
        Ok(_) => Err("non-finite"),
        Err(_) => Err("parse"),
    }
}

/// The rows, or the first fault as kind, line and column.
type Promise = Result<Vec<Vec<f64>>, (&'static str, u64, Option<&'static str>)>;

/// Applies the rules in order: the same width in each row, every cell a finite number, time increasing.
fn promise(lines: &[String]) -> Promise {
    let (mut rows, mut last) = (Vec::new(), f64::NEG_INFINITY);
    for (k, line) in lines.iter().enumerate().skip(1).filter(|(_, line)| !line.trim().is_empty()) {
        let at = k as u64 + 1;
        let cells: Vec<&str> = line.split(',').collect();
        if cells.len() != PLANAR.len() {
            return Err(("field-count", at, None));
        }
        let mut row = Vec::new();
        for (cell, column) in cells.iter().zip(PLANAR) {
            row.push(number(cell).map_err(|kind| (kind, at, Some(column)))?);
        }
        if row[0] <= last {
            return Err(("time-not-increasing", at, Some("t")));
        }
        last = row[0];
        rows.push(row);
    }
    Ok(rows)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 512, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn law_the_first_fault_is_the_first_finding(edits in prop::collection::vec(edit(), 0..5), end in 0usize..3) {
        let mut lines = Swim::new(10.0, 4.0, 1.0, 9).lines();
        edits.iter().for_each(|e| apply(&mut lines, e));
        let text = lines.join(["\n", "\r\n", "\r"][end]);
        let outcome = read_from(text.as_bytes(), "f.csv", &LogOptions::default(), &PLANAR);
        match (promise(&lines), outcome) {
            (Ok(rows), Ok(log)) => {
                prop_assert_eq!(log.rows, rows.len());
                for (c, name) in PLANAR.iter().enumerate().skip(1) {
                    let (times, values) = (log.signals[*name].time(), log.signals[*name].values());
                    prop_assert!(rows.iter().zip(times).all(|(r, t)| r[0].to_bits() == t.to_bits()));
                    prop_assert!(rows.iter().zip(values).all(|(r, x)| r[c].to_bits() == x.to_bits()));
                }
            }
            (Err((kind, line, column)), Err(refused)) => {
                let found = &refused.findings()[0];
                // of two faults in one row either may be reported first
                prop_assert_eq!(found.line, Some(line), "{:?} {:?}", kind, found);
                let both = refused.findings().iter().any(|f| {
                    (f.kind, f.line, f.column.as_deref()) == (kind, Some(line), column)
                });
                prop_assert!(both, "{:?} {:?} {:?}: {:?}", kind, line, column, refused.findings());
            }
            (Ok(_), Err(refused)) => prop_assert!(false, "refused: {refused}"),
            (Err(fault), Ok(_)) => prop_assert!(false, "accepted in spite of {fault:?}"),
        }
    }
}
