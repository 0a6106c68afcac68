//! Tables as CSV for spreadsheets, which take some text for formulas.

use std::borrow::Cow;

use csv::{Terminator, WriterBuilder};

/// `word` as a cell that no spreadsheet takes for a formula: text with `=`, `+`, `-`, `@`, their
/// full-width forms, or a control character at the start gets an apostrophe in front.
pub(crate) fn harmless(word: &str) -> Cow<'_, str> {
    let is_formula = word.trim_start().starts_with(['=', '+', '-', '@', '\t', '\r', '＝', '＋', '－', '＠'])
        || word.starts_with(['\t', '\r', '\n']);
    if is_formula { Cow::Owned(format!("'{word}")) } else { Cow::Borrowed(word) }
}

/// The original text of [`harmless`]: `word` without the apostrophe that keeps it from being a
/// formula.
pub(crate) fn without_mark(word: &str) -> &str {
    match word.strip_prefix('\'') {
        Some(rest) if matches!(harmless(rest), Cow::Owned(_)) => rest,
        _ => word,
    }
}

/// Rows as CSV, with fields quoted as RFC 4180 requires.
pub(crate) fn csv(rows: impl IntoIterator<Item = Vec<String>>, end: Terminator) -> String {
    let mut writer = WriterBuilder::new().terminator(end).flexible(true).from_writer(Vec::new());
    for row in rows {
        // writing to memory does not fail, and rows may have any length
        let _ = writer.write_record(row);
    }
    String::from_utf8(writer.into_inner().unwrap_or_default()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formulas_become_words_and_numbers_stay() {
        for word in ["+1", "-2", "@x", "\t=1", " =1", "＝1"] {
            assert_eq!(harmless(word), format!("'{word}"));
            assert_eq!(without_mark(&harmless(word)), word);
        }
        assert_eq!((without_mark("'quoted'"), without_mark("k_u|u|")), ("'quoted'", "k_u|u|"));
        assert_eq!(harmless("k_u|u|"), "k_u|u|");
        let row = vec![harmless("=HYPERLINK(\"x\",\"y\")").into_owned(), "-0.1".into(), String::new()];
        assert_eq!(csv([row], Terminator::CRLF), "\"'=HYPERLINK(\"\"x\"\",\"\"y\"\")\",-0.1,\r\n");
    }
}
