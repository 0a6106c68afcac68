//! Records: a stream of bytes is cut into lines and fields; each record has the number of its first
//! physical line.
//!
//! `csv_core` reads the fields: line ends LF, CRLF or CR; a field may be quoted (`"a ""b"""`, RFC 4180) and
//! then contain line ends and delimiters. `csv_core` accepts any bytes as CSV, so this module refuses what
//! is no CSV: NUL, bytes that are not UTF-8, an unclosed quote, text after a closing quote, a record that
//! is too long. Blank lines and comments are skipped. Line numbers are counted from the bytes of each
//! record. Memory is one block and one record, for a file of any size.

use std::io::Read;
use std::ops::Range;

use csv_core::{ReadFieldResult, Reader, ReaderBuilder};

use super::encoding::{self, Opening};
use crate::finding::Quote;

const BLOCK: usize = 1 << 18;

/// Reason why there is no next record.
#[derive(Debug)]
pub enum Broken {
    /// The bytes are not text; the name of what they are.
    NotText(&'static str),
    /// A log in another format: its name, and the extra of the Python package that reads it.
    OtherLog(&'static str, &'static str),
    /// A NUL byte.
    Nul(u64),
    /// Not UTF-8: line and the first such byte.
    NotUtf8(u64, u8),
    /// Longer than the limit.
    TooLong(u64),
    /// A quote that is not closed: line, and number of the field.
    OpenQuote(u64, usize),
    /// Text after a closing quote: line, and number of the field.
    StrayQuote(u64, usize),
    /// The file could not be read further.
    Io(std::io::Error),
}

/// A field: range of its bytes in the text of its record, and range in the raw record.
#[derive(Debug, Clone)]
struct Field {
    text: Range<usize>,
    raw: Range<usize>,
}

/// One record; its text is borrowed from the reader.
#[derive(Debug)]
pub struct Record<'a> {
    /// Physical line of its first byte, from 1.
    pub line: u64,
    /// First blank line between the previous record and this one.
    pub blank: Option<u64>,
    /// Whether a line end follows the record.
    pub ended: bool,
    raw: &'a [u8],
    text: &'a [u8],
    fields: &'a [Field],
}

impl<'a> Record<'a> {
    /// Number of fields.
    pub fn width(&self) -> usize {
        self.fields.len()
    }

    /// Field `i` without quotes and blanks around it; `None` beyond the last.
    #[inline]
    pub fn field(&self, i: usize) -> Option<&'a [u8]> {
        self.text.get(self.fields.get(i)?.text.clone()).map(trim)
    }

    /// Whole text of the record, as it stands in the file.
    pub fn raw(&self) -> String {
        String::from_utf8_lossy(self.raw).into_owned()
    }

    /// Field `i` as text; lossless, because records are UTF-8.
    pub fn text(&self, i: usize) -> String {
        String::from_utf8_lossy(self.field(i).unwrap_or_default()).into_owned()
    }

    /// Returns the record with field `i` marked; the whole record is marked if there is no such field.
    pub fn quote(&self, i: usize) -> Quote {
        let marked = self.fields.get(i).map_or(0..self.raw.len(), |field| field.raw.clone());
        Quote::new(self.raw, marked)
    }
}

/// Removes blanks from both ends.
#[inline]
pub(super) fn trim(mut bytes: &[u8]) -> &[u8] {
    while let [b' ' | b'\t', rest @ ..] = bytes {
        bytes = rest;
    }
    while let [rest @ .., b' ' | b'\t'] = bytes {
        bytes = rest;
    }
    bytes
}

/// Cuts a source into records.
pub struct Records<R> {
    source: R,
    parser: Reader,
    delimiter: u8,
    comment: Option<Vec<u8>>,
    max_line: usize,
    buffer: Vec<u8>,
    position: usize,
    /// Whether the source is at its end.
    exhausted: bool,
    /// Whether the buffer holds only ASCII, no NUL and no quote: then no line of it needs a further check.
    plain: bool,
    line: u64,
    fields: Vec<Field>,
    /// Text of the fields of the record without quotes, one after the other; it has room for the
    /// whole buffer.
    text: Vec<u8>,
    /// Whether any byte except blanks has been read.
    seen: bool,
}

impl<R: Read> Records<R> {
    /// Returns a reader of `source`; skips a byte order mark.
    ///
    /// # Errors
    /// [`Broken`] if the first bytes are not text, or cannot be read.
    pub fn new(source: R, delimiter: u8, comment: Option<&str>, max_line: usize) -> Result<Records<R>, Broken> {
        let mut records = Records {
            source,
            parser: ReaderBuilder::new().delimiter(delimiter).build(),
            delimiter,
            comment: comment.map(|c| c.trim().as_bytes().to_vec()),
            max_line,
            buffer: Vec::new(),
            position: 0,
            exhausted: false,
            plain: true,
            line: 1,
            fields: Vec::new(),
            text: Vec::new(),
            seen: false,
        };
        records.fill()?;
        match encoding::opening(&records.buffer) {
            Opening::Other(name) => return Err(Broken::NotText(name)),
            Opening::Log(name, extra) => return Err(Broken::OtherLog(name, extra)),
            Opening::Text(mark) => records.position = mark,
        }
        Ok(records)
    }

    /// Whether anything except blank lines has been read so far.
    pub fn seen_text(&self) -> bool {
        self.seen
    }

    /// Reads one more block after the unread rest of the buffer.
    fn fill(&mut self) -> Result<(), Broken> {
        self.buffer.drain(..self.position);
        self.position = 0;
        let old = self.buffer.len();
        self.buffer.resize(old + BLOCK, 0);
        let mut filled = old;
        while filled < self.buffer.len() {
            match self.source.read(&mut self.buffer[filled..]) {
                Ok(0) => {
                    self.exhausted = true;
                    break;
                }
                Ok(n) => filled += n,
                Err(e) if e.kind() == std::io::ErrorKind::Interrupted => {}
                Err(e) => return Err(Broken::Io(e)),
            }
        }
        self.buffer.truncate(filled);
        self.plain = self.buffer.is_ascii() && memchr::memchr2(b'"', 0, &self.buffer).is_none();
        Ok(())
    }

    /// Returns the number of the next line, and the whole lines in the buffer if none of their
    /// bytes needs a further check; may be empty.
    pub fn plain_lines(&self) -> (u64, &[u8]) {
        let text = if self.plain { &self.buffer[self.position..] } else { &[] };
        (self.line, &text[..memchr::memrchr(b'\n', text).map_or(0, |last| last + 1)])
    }

    /// Continues after the first `lines` lines of [`Records::plain_lines`], which have `bytes` bytes.
    pub fn skip(&mut self, lines: u64, bytes: usize) {
        self.line += lines;
        self.position += bytes;
    }

    /// Returns the line at which the reading ended, with the field marked that [`Broken`] names.
    pub fn quote(&self, broken: &Broken) -> Option<Quote> {
        let text = &self.buffer[self.position..];
        let line = &text[..memchr::memchr2(b'\n', b'\r', text).unwrap_or(text.len())];
        match broken {
            Broken::NotText(_) | Broken::Io(_) => None,
            Broken::OpenQuote(..) | Broken::StrayQuote(..) => {
                let field = self.fields.last().map_or(0..0, |field| field.raw.clone());
                Some(Quote::new(line, field.start.min(line.len())..field.end.min(line.len())))
            }
            _ => Some(Quote::new(line, 0..line.len())),
        }
    }

    /// Returns the fault of a record longer than the limit: [`Broken::Nul`] if there is a NUL in
    /// the buffer, since that says more.
    fn too_long(&self) -> Broken {
        match memchr::memchr(0, &self.buffer[self.position..]) {
            Some(_) => Broken::Nul(self.line),
            None => Broken::TooLong(self.line),
        }
    }

    /// Returns the length of the line at `position` without and with its line end; `None` at the
    /// end. Fills the buffer as needed.
    fn next_line(&mut self) -> Result<Option<(usize, usize)>, Broken> {
        let mut searched = 0;
        loop {
            let text = &self.buffer[self.position..];
            if let Some(i) = memchr::memchr2(b'\n', b'\r', &text[searched..]) {
                let length = searched + i;
                let carriage = text[length] == b'\r';
                if !carriage || length + 1 < text.len() || self.exhausted {
                    let pair = carriage && text.get(length + 1) == Some(&b'\n');
                    return match length > self.max_line {
                        true => Err(self.too_long()),
                        false => Ok(Some((length, length + 1 + usize::from(pair)))),
                    };
                }
                searched = length;
            } else {
                searched = text.len();
                if searched > self.max_line {
                    return Err(self.too_long());
                }
                if self.exhausted {
                    return Ok((searched > 0).then_some((searched, searched)));
                }
            }
            self.fill()?;
        }
    }

    /// Returns the next record that is neither blank nor comment; `None` at the end.
    ///
    /// # Errors
    /// [`Broken`] if the record cannot be cut into fields. Nothing can be read after it.
    pub fn next_record(&mut self) -> Result<Option<Record<'_>>, Broken> {
        let mut blank = None;
        loop {
            let Some((length, next)) = self.next_line()? else { return Ok(None) };
            let text = &self.buffer[self.position..self.position + length];
            if text.iter().all(|b| self.is_blank(*b)) {
                blank.get_or_insert(self.line);
            } else if !self.comment.as_ref().is_some_and(|c| trim(text).starts_with(c)) {
                self.seen = true;
                return self.cut(blank).map(Some);
            } else {
                self.seen = true;
            }
            self.skip(1, next);
        }
    }

    #[inline]
    fn is_blank(&self, byte: u8) -> bool {
        matches!(byte, b' ' | b'\t') && byte != self.delimiter
    }

    /// Returns the byte `at` bytes after the position; `None` at the end. Fills the buffer as needed.
    #[inline]
    fn byte(&mut self, at: usize) -> Result<Option<u8>, Broken> {
        while self.position + at >= self.buffer.len() && !self.exhausted {
            if at > self.max_line {
                return Err(self.too_long());
            }
            self.fill()?;
        }
        Ok(self.buffer.get(self.position + at).copied())
    }

    /// Cuts the record at `position` into fields; a quoted field may span several lines.
    fn cut(&mut self, blank: Option<u64>) -> Result<Record<'_>, Broken> {
        self.fields.clear();
        let (mut taken, mut filled) = (0, 0);
        let (ended, fault) = loop {
            // `csv_core` recognises a quote only as the first byte of a field
            while self.byte(taken)?.is_some_and(|b| self.is_blank(b)) {
                taken += 1;
            }
            let (raw, text) = (taken, filled);
            let end = self.read_field(&mut taken, &mut filled)?;
            let raw = raw..taken - usize::from(end != End::Source);
            self.fields.push(Field { text: text..filled, raw: raw.clone() });
            let fault = self.wrong_quote(raw);
            if fault.is_some() || end != End::Field {
                break (end == End::Record, fault);
            }
        };
        // the LF of a CRLF
        if ended && self.buffer[self.position + taken - 1] == b'\r' && self.byte(taken)? == Some(b'\n') {
            taken += 1;
        }
        let (from, line) = (self.position, self.line);
        self.check(taken)?;
        if let Some(fault) = fault {
            return Err(fault);
        }
        let whole = &self.buffer[from..from + taken];
        if whole.len() > self.max_line + 2 {
            return Err(self.too_long());
        }
        self.line += if self.plain { 1 } else { line_ends(whole).max(1) };
        self.position += taken;
        let raw = &self.buffer[from..from + self.fields.last().map_or(taken, |field| field.raw.end)];
        Ok(Record { line, blank, ended, raw, text: &self.text[..filled], fields: &self.fields })
    }

    /// Reads the field that begins `taken` bytes after the position into the text from `filled` on;
    /// advances both.
    fn read_field(&mut self, taken: &mut usize, filled: &mut usize) -> Result<End, Broken> {
        loop {
            // `csv_core` takes an empty input for the end of the file
            let is_left = self.byte(*taken)?.is_some();
            if self.text.len() <= self.buffer.len() {
                self.text.resize(self.buffer.len() + 1, 0);
            }
            let input = &self.buffer[self.position + *taken..];
            let (result, read, written) = self.parser.read_field(input, &mut self.text[*filled..]);
            *taken += read;
            *filled += written;
            match result {
                ReadFieldResult::Field { record_end: false } => return Ok(End::Field),
                ReadFieldResult::Field { record_end: true } if is_left => return Ok(End::Record),
                ReadFieldResult::Field { .. } | ReadFieldResult::End => return Ok(End::Source),
                ReadFieldResult::InputEmpty | ReadFieldResult::OutputFull => {}
            }
        }
    }

    /// Returns the fault in the quotes of the last field, whose bytes are `raw`; `csv_core` would read on.
    fn wrong_quote(&self, raw: Range<usize>) -> Option<Broken> {
        let raw = &self.buffer[self.position + raw.start..self.position + raw.end];
        let field = self.fields.len() - 1;
        match (raw.first(), closing_quote(raw)) {
            (Some(b'"'), None) => Some(Broken::OpenQuote(self.line, field)),
            (Some(b'"'), Some(at)) if !trim(&raw[at + 1..]).is_empty() => Some(Broken::StrayQuote(self.line, field)),
            _ => None,
        }
    }

    /// Refuses NUL and bytes that are not UTF-8 in the next `length` bytes.
    fn check(&self, length: usize) -> Result<(), Broken> {
        let text = &self.buffer[self.position..self.position + length];
        if self.plain {
            return Ok(());
        }
        if memchr::memchr(0, text).is_some() {
            return Err(Broken::Nul(self.line));
        }
        match std::str::from_utf8(text) {
            Err(e) => Err(Broken::NotUtf8(self.line, text.get(e.valid_up_to()).copied().unwrap_or(0))),
            Ok(_) => Ok(()),
        }
    }
}

/// What a field ends with.
#[derive(Clone, Copy, PartialEq, Eq)]
enum End {
    /// A delimiter.
    Field,
    /// A line end.
    Record,
    /// The end of the file.
    Source,
}

/// Position of the quote that closes the quote at the start of `raw`.
fn closing_quote(raw: &[u8]) -> Option<usize> {
    let mut at = 1;
    loop {
        at += memchr::memchr(b'"', raw.get(at..)?)?;
        match raw.get(at + 1) {
            Some(b'"') => at += 2,
            _ => return Some(at),
        }
    }
}

/// Number of line ends: LF, CRLF or CR.
fn line_ends(text: &[u8]) -> u64 {
    let ends = memchr::memchr2_iter(b'\n', b'\r', text);
    ends.map(|at| u64::from(text[at] == b'\n' || text.get(at + 1) != Some(&b'\n'))).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gives `step` bytes at a time, so that every boundary of a block is met.
    struct Slow<'a>(&'a [u8], usize);

    impl Read for Slow<'_> {
        fn read(&mut self, to: &mut [u8]) -> std::io::Result<usize> {
            let n = self.1.min(self.0.len()).min(to.len());
            to[..n].copy_from_slice(&self.0[..n]);
            self.0 = &self.0[n..];
            Ok(n)
        }
    }

    fn all(text: &[u8]) -> Vec<(u64, Vec<String>)> {
        let mut records = Records::new(Slow(text, 3), b',', Some("#"), 1000).unwrap();
        let mut found = Vec::new();
        while let Some(r) = records.next_record().unwrap() {
            found.push((r.line, (0..r.width()).map(|i| r.text(i)).collect()));
        }
        found
    }

    #[test]
    fn lines_are_counted_whatever_their_ends() {
        let expected = all(b"t,u\n\n1,2\n# c \"\n3,4\n");
        assert_eq!(expected.iter().map(|r| r.0).collect::<Vec<_>>(), [1, 3, 5]);
        assert_eq!(all(b"t,u\r\n\r\n1,2\r\n# c \"\r\n3,4"), expected);
        assert_eq!(all(b"t,u\r\r1,2\r# c \"\r3,4\r"), expected);
        assert_eq!(all(b"\xef\xbb\xbft,u\n \n\"1\", \"2\" \n#\n\"3\",4"), expected);
    }

    #[test]
    fn quotes_hold_delimiters_and_lines() {
        let found = all(b"a,b\n\"x,\r\ny\",\"q\"\"q\"\n5,6\n");
        assert_eq!(found[1], (2, vec!["x,\r\ny".to_string(), "q\"q".to_string()]));
        assert_eq!(found[2].0, 4);
    }

    #[test]
    fn broken_text_is_named_with_its_line() {
        let broken = |text: &[u8], max| {
            let mut records = Records::new(text, b',', None, max).unwrap();
            loop {
                match records.next_record() {
                    Ok(Some(_)) => {}
                    Ok(None) => panic!("nothing broken"),
                    Err(e) => return e,
                }
            }
        };
        assert!(matches!(broken(b"a\n\0\n", 9), Broken::Nul(2)));
        assert!(matches!(broken(b"a\nb\xb0\n", 9), Broken::NotUtf8(2, 0xb0)));
        assert!(matches!(broken(b"a\n0123456789\n", 9), Broken::TooLong(2)));
        assert!(matches!(broken(b"a\n1,\"2\n3\n", 99), Broken::OpenQuote(2, 1)));
        assert!(matches!(broken(b"a\n\"2\"x\n", 99), Broken::StrayQuote(2, 0)));
        assert!(matches!(broken(&[b'x'; 1 << 20], 1 << 19), Broken::TooLong(1)));
        let mut endless = vec![b'"'];
        endless.resize(1 << 20, b'\n');
        assert!(matches!(broken(&endless, 1 << 19), Broken::TooLong(1)));
    }
}
