//! The records as a table.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use crate::peer::{self, Peer};
use crate::plan::{ABSENT, Cell, NOTHING, SECTIONS};
use crate::record::Record;

/// Held-out gap over noise from which on an effect has to be found.
const VISIBLE: f64 = 1.5;

/// Counts of one row.
#[derive(Default)]
struct Row {
    campaigns: usize,
    judged: usize,
    exact: usize,
    first: usize,
    listed: usize,
    false_names: usize,
    alarms: usize,
    unexplained: usize,
    explained_wrongly: usize,
    closed: Vec<f64>,
    seconds: Vec<f64>,
    answers: BTreeMap<String, usize>,
}

impl Row {
    fn add(&mut self, record: &Record, allowed: &[&str]) {
        self.campaigns += 1;
        self.seconds.push(record.seconds);
        self.alarms += usize::from(!record.named.is_empty());
        self.unexplained += usize::from(record.verdict == "unexplained");
        if !record.hidden.is_empty() && record.before < VISIBLE {
            return;
        }
        self.judged += 1;
        let is =
            |hidden: &String, (name, _): &(String, Vec<String>)| name == hidden || allowed.contains(&name.as_str());
        let may_be = |hidden: &String, one: &(String, Vec<String>)| is(hidden, one) || one.1.contains(hidden);
        let listed = record.hidden.iter().all(|h| record.named.iter().any(|n| may_be(h, n)));
        let first = record.hidden.iter().all(|h| record.named.iter().any(|n| is(h, n)));
        let wrong = record.named.iter().filter(|n| !record.hidden.iter().any(|h| may_be(h, n))).count();
        let exact = listed && wrong == 0 && record.named.len() <= record.hidden.len();
        self.exact += usize::from(exact);
        self.first += usize::from(exact && first);
        self.listed += usize::from(listed);
        self.false_names += wrong;
        self.explained_wrongly += usize::from(wrong > 0 && record.verdict == "explained");
        if let Some(truth) = record.truth.filter(|truth| record.before > *truth) {
            self.closed.push(((record.before - record.after) / (record.before - truth)).clamp(0.0, 1.0));
        }
        if !exact {
            let names: Vec<&str> = record.named.iter().map(|n| n.0.as_str()).collect();
            let answer = if names.is_empty() { record.verdict.clone() } else { names.join(" + ") };
            *self.answers.entry(answer).or_default() += 1;
        }
    }

    fn print(&self, name: &str) -> String {
        let mut answers: Vec<_> = self.answers.iter().collect();
        answers.sort_by(|a, b| b.1.cmp(a.1));
        let other = answers.iter().take(3).map(|(n, c)| format!("{c}× {n}")).collect::<Vec<_>>().join("; ");
        format!(
            "| {name} | {} | {} | {} | {} | {} | {} | {:.2} | {other} |\n",
            self.campaigns,
            share(self.exact, self.judged),
            share(self.first, self.judged),
            share(self.listed, self.judged),
            self.false_names,
            median(&self.closed).map_or("–".into(), |c| format!("{:.1} %", 100.0 * c)),
            median(&self.seconds).unwrap_or(0.0),
        )
    }

    fn absorb(&mut self, other: &Row) {
        self.campaigns += other.campaigns;
        self.judged += other.judged;
        self.exact += other.exact;
        self.first += other.first;
        self.listed += other.listed;
        self.false_names += other.false_names;
        self.alarms += other.alarms;
        self.unexplained += other.unexplained;
        self.explained_wrongly += other.explained_wrongly;
        self.closed.extend(&other.closed);
        self.seconds.extend(&other.seconds);
    }
}

/// n of a total with Wilson's 95 % interval.
fn share(n: usize, of: usize) -> String {
    if of == 0 {
        return "–".into();
    }
    let (low, high) = wilson(n, of);
    format!("{n}/{of} ({:.1}–{:.1} %)", 100.0 * low, 100.0 * high)
}

fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied()
}

/// Wilson's 95 % interval of a share.
fn wilson(hits: usize, of: usize) -> (f64, f64) {
    let (n, z) = (of as f64, 1.96f64);
    let p = hits as f64 / n;
    let centre = (p + z * z / (2.0 * n)) / (1.0 + z * z / n);
    let half = z / (1.0 + z * z / n) * (p * (1.0 - p) / n + z * z / (4.0 * n * n)).sqrt();
    ((centre - half).max(0.0), (centre + half).min(1.0))
}

/// The whole table; both vehicles stand in one row.
pub fn table(cells: &[Cell], records: &BTreeMap<(String, u64), Record>, peer: &Peer) -> String {
    let mut text = String::new();
    for section in SECTIONS {
        let mut rows: Vec<(String, Row)> = Vec::new();
        let (mut theirs, mut held) = (Row::default(), Row::default());
        for cell in cells.iter().filter(|cell| cell.section == section) {
            if !rows.iter().any(|(name, _)| *name == cell.row) {
                rows.push((cell.row.clone(), Row::default()));
            }
            let Some((_, row)) = rows.iter_mut().find(|(name, _)| *name == cell.row) else { continue };
            let id = cell.id();
            for ((known, _), record) in records {
                if *known == id {
                    row.add(record, cell.allowed);
                    if let Some((answer, holds)) = peer.record(record) {
                        theirs.add(&answer, cell.allowed);
                        if holds {
                            held.add(&answer, cell.allowed);
                        }
                    }
                }
            }
        }
        if section == NOTHING && theirs.campaigns > 0 {
            rows.push((format!("{}, all three", peer::NAME), std::mem::take(&mut theirs)));
        }
        rows.retain(|(_, row)| row.campaigns > 0);
        if rows.is_empty() {
            continue;
        }
        let _ = write!(text, "\n## {section}\n\n");
        if section == NOTHING {
            text +=
                "| noise | campaigns | false alarms: an effect named | `unexplained` | s |\n|---|---|---|---|---|\n";
            for (name, row) in &rows {
                let seconds = median(&row.seconds).unwrap_or(0.0);
                let _ = writeln!(
                    text,
                    "| {name} | {} | {} | {} | {seconds:.2} |",
                    row.campaigns,
                    share(row.alarms, row.campaigns),
                    share(row.unexplained, row.campaigns)
                );
            }
            continue;
        }
        text += "| hidden | campaigns | exact | truth as first name | named or listed | false names | gap closed | s | otherwise |\n";
        text += "|---|---|---|---|---|---|---|---|---|\n";
        let mut pooled = Row::default();
        for (name, row) in &rows {
            text += &row.print(name);
            pooled.absorb(row);
        }
        text += &pooled.print("**all**");
        if theirs.campaigns > 0 {
            text += &Row { answers: BTreeMap::new(), ..theirs }.print(peer::NAME);
        }
        if held.campaigns > 0 {
            text += &Row { answers: BTreeMap::new(), ..held }.print("the same, of what its library holds");
        }
        if section == ABSENT {
            let wrongly = share(pooled.explained_wrongly, pooled.judged);
            let _ = write!(text, "\nA wrong name with the verdict `explained`: {wrongly}.\n");
        }
    }
    text
}
