//! Faults of the rows: the first case of each kind and column, and the number of further ones.

use super::codes;
use super::header::quoted;
use super::records::Broken;
use crate::finding::{Code, Finding, Quote};

/// Largest number of cases (kind and column) that are kept; faults of further cases are only counted.
const KEPT: usize = 20;

#[derive(Debug)]
struct Case {
    code: Code,
    column: Option<String>,
    line: Option<u64>,
    text: String,
    quote: Option<Quote>,
    count: u64,
}

/// Faults, counted by kind and column.
#[derive(Debug, Default)]
pub struct Faults {
    cases: Vec<Case>,
    further: u64,
}

impl Faults {
    /// Counts a fault; `text` is called only for the first of its kind and column.
    #[cold]
    pub fn add(&mut self, code: &Code, line: Option<u64>, column: Option<&str>, text: impl FnOnce() -> String) {
        self.add_quoting(code, line, column, || (text(), None));
    }

    /// Counts a fault and quotes its line; `told`, which gives the text and the quotation, is called
    /// only for the first of its kind and column.
    #[cold]
    pub fn add_quoting(
        &mut self,
        code: &Code,
        line: Option<u64>,
        column: Option<&str>,
        told: impl FnOnce() -> (String, Option<Quote>),
    ) {
        if let Some(case) = self.cases.iter_mut().find(|c| c.code == *code && c.column.as_deref() == column) {
            case.count += 1;
        } else if self.cases.len() < KEPT {
            let (column, (text, quote)) = (column.map(str::to_string), told());
            self.cases.push(Case { code: *code, column, line, text, quote, count: 1 });
        } else {
            self.further += 1;
        }
    }

    /// Counts the fault that ended the reading, in the line of `quote`; `column` gives the name of a field.
    pub fn add_broken(
        &mut self,
        broken: &Broken,
        quote: Option<Quote>,
        max_line: usize,
        column: impl Fn(usize) -> Option<String>,
    ) {
        let (code, line, field, text) = match broken {
            Broken::NotText(name) => {
                let text = format!("this is {name}, not UTF-8 text; convert or unpack it first");
                (codes::ENCODING, None, None, text)
            }
            Broken::OtherLog(name, extra) => {
                let text = format!(
                    "this is {name}, not CSV: `hydrosysid init LOG -o FOLDER` reads it and writes a campaign, \
                     `hydrosysid convert LOG --map map.toml -o log.csv` turns it into CSV; both with the command of \
                     the Python package (pip install 'hydrosysid[{extra}]')"
                );
                (codes::OTHER_FORMAT, None, None, text)
            }
            Broken::Nul(line @ 1) => {
                let text = "a NUL byte in the first line: this is not text, and its first bytes are not those of a \
                            known log format; if it is a log of another format, its beginning is missing: copy it off \
                            the vehicle again";
                (codes::ENCODING, Some(*line), None, text.to_string())
            }
            Broken::Nul(line) => {
                let text = "a NUL byte: a block that was never written, as after a power loss; cut these bytes out, or \
                            cut the file off here";
                (codes::ENCODING, Some(*line), None, text.to_string())
            }
            Broken::NotUtf8(line, byte) => {
                let text =
                    format!("byte 0x{byte:02X} is not UTF-8; convert the file, e.g. with iconv -f LATIN1 -t UTF-8");
                (codes::ENCODING, Some(*line), None, text)
            }
            Broken::TooLong(line) => {
                let text =
                    format!("longer than max_line_bytes = {max_line}: line ends are missing or a quote is not closed");
                (codes::LINE_LENGTH, Some(*line), None, text)
            }
            Broken::OpenQuote(line, field) => {
                (codes::QUOTE, Some(*line), Some(*field), "a quote is opened here but never closed".to_string())
            }
            Broken::StrayQuote(line, field) => {
                let text = "text follows the closing quote; a quote inside quotes is written twice";
                (codes::QUOTE, Some(*line), Some(*field), text.to_string())
            }
            Broken::Io(error) => {
                (codes::ENCODING, None, None, format!("the file could not be read to its end: {error}"))
            }
        };
        let column = field.and_then(column);
        self.add_quoting(&code, line, column.as_deref(), || (text, quote));
    }

    /// Whether there is no fault.
    pub fn is_empty(&self) -> bool {
        self.cases.is_empty()
    }

    /// Returns the findings in order of line, and the number of faults of further kinds and columns.
    pub fn into_findings(mut self, file: &str) -> (Vec<Finding>, u64) {
        self.cases.sort_by_key(|c| c.line);
        let total = |code: &Code| self.cases.iter().filter(|c| c.code == *code).map(|c| c.count).sum::<u64>();
        let findings = self.cases.iter().map(|case| {
            let mut text = case.text.clone();
            let all = total(&case.code);
            if all > case.count {
                text += &format!(" ({} of these in this column, {all} in the file)", case.count);
            } else if all > 1 {
                text += &format!(" ({all} of these in the file)");
            }
            Finding::at(&case.code, file, case.line, case.column.as_deref(), &text).quoting(case.quote.clone())
        });
        (findings.collect(), self.further)
    }
}

/// Returns a message that a cell is not a number, with the option that would allow it.
pub fn no_number(cell: &[u8], decimal: char, missing_is_error: bool) -> String {
    let text = String::from_utf8_lossy(cell);
    let mut message = format!("{} is not a number", quoted(&text));
    let marks: Vec<String> =
        text.chars().filter(|c| !c.is_ascii()).take(3).map(|c| format!("U+{:04X}", c as u32)).collect();
    if !marks.is_empty() {
        message += &format!("; it contains {}", marks.join(", "));
    }
    let other = if decimal == '.' { ',' } else { '.' };
    let swapped: String = text.chars().map(|c| if c == other { decimal } else { c }).collect();
    let looks_missing = !text.chars().any(|c| c.is_ascii_digit()) && text.chars().count() <= 8;
    if text.contains(other) && super::number::parse(swapped.as_bytes(), decimal as u8).is_some() {
        message += &format!("; if {other:?} is the decimal mark set decimal = \"{other}\"");
    } else if looks_missing {
        let drop = if missing_is_error { " and missing = \"drop\" or \"no_sample\"" } else { "" };
        message += &format!("; if it means no value set missing_values = [{:?}]{drop}", text.as_ref());
    }
    message
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_case_and_counts() {
        let mut faults = Faults::default();
        for (line, column) in [(15, "r"), (8, "u"), (9, "u")] {
            faults.add(&codes::NON_FINITE, Some(line), Some(column), || "'NaN'".to_string());
        }
        let (found, further) = faults.into_findings("f.csv");
        assert_eq!((found.len(), further), (2, 0));
        assert_eq!(found[0].message, "f.csv, line 8, column u: 'NaN' (2 of these in this column, 3 in the file)");
    }

    #[test]
    fn the_message_names_the_option() {
        let says = |cell: &str| no_number(cell.as_bytes(), '.', true);
        assert!(says("\u{2212}0.5").contains("U+2212"));
        assert!(says("0,5").contains("decimal = \",\""));
        assert!(says("N/A").contains("missing_values = [\"N/A\"]"));
        assert!(!says("0.12.3").contains("missing"));
        assert!(says(&"\n".repeat(2000)).len() < 200);
    }
}
