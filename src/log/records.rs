//! Records: a stream of bytes cut into lines and fields, with the physical line each record starts at.
//!
//! Line ends are LF, CRLF or CR. A field may be quoted (`"a ""b"""`, RFC 4180) and then hold line ends and delimiters.
//! Blank lines and comments are skipped. Memory is one block and one record, whatever the size of the file.
//! The csv crate counts lines by LF alone and skips blank lines in silence, so this is our own.

use std::io::Read;

use super::encoding::{self, Opening};

const BLOCK: usize = 1 << 18;

/// Why there is no next record.
#[derive(Debug)]
pub enum Broken {
    /// The bytes are something else than text: its name.
    NotText(&'static str),
    /// A NUL byte.
    Nul(u64),
    /// Not UTF-8: line and the first such byte.
    NotUtf8(u64, u8),
    /// Longer than the limit.
    TooLong(u64),
    /// A quote that is not closed; the field's number.
    OpenQuote(u64, usize),
    /// Something follows a closing quote; the field's number.
    StrayQuote(u64, usize),
    /// The file could not be read further.
    Io(std::io::Error),
}

/// One record; its text is borrowed from the reader.
#[derive(Debug)]
pub struct Record<'a> {
    /// Physical line of its first byte, from 1.
    pub line: u64,
    /// First blank line between the record before and this one.
    pub blank: Option<u64>,
    /// Whether a line end follows.
    pub ended: bool,
    bytes: &'a [u8],
    fields: &'a [(usize, usize)],
}

impl<'a> Record<'a> {
    /// Number of fields.
    pub fn width(&self) -> usize {
        self.fields.len()
    }

    /// Field `i`, blanks around it taken off; `None` beyond the last.
    #[inline]
    pub fn field(&self, i: usize) -> Option<&'a [u8]> {
        let &(from, to) = self.fields.get(i)?;
        self.bytes.get(from..to).map(trim)
    }

    /// All of its text, as it is when nothing is quoted.
    pub fn raw(&self) -> String {
        String::from_utf8_lossy(self.bytes).into_owned()
    }

    /// Field `i` as text. Records are UTF-8, so nothing is lost.
    pub fn text(&self, i: usize) -> String {
        String::from_utf8_lossy(self.field(i).unwrap_or_default()).into_owned()
    }
}

/// Takes blanks off both ends.
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
    delimiter: u8,
    comment: Option<Vec<u8>>,
    max_line: usize,
    buffer: Vec<u8>,
    position: usize,
    /// The source is at its end.
    exhausted: bool,
    /// The buffer holds no NUL, no quote and nothing beyond ASCII: no line of it needs a closer look.
    plain: bool,
    line: u64,
    fields: Vec<(usize, usize)>,
    unquoted: Vec<u8>,
    /// Whether any byte but blanks has been seen.
    seen: bool,
}

/// A line in the buffer: `from..to`, the next one at `next`.
#[derive(Clone, Copy)]
struct Line {
    to: usize,
    next: usize,
    ended: bool,
}

impl<R: Read> Records<R> {
    /// A reader; takes the byte order mark off.
    ///
    /// # Errors
    /// When the first bytes are not text, or cannot be read.
    pub fn new(source: R, delimiter: u8, comment: Option<&str>, max_line: usize) -> Result<Records<R>, Broken> {
        let mut records = Records {
            source,
            delimiter,
            comment: comment.map(|c| c.trim().as_bytes().to_vec()),
            max_line,
            buffer: Vec::new(),
            position: 0,
            exhausted: false,
            plain: true,
            line: 1,
            fields: Vec::new(),
            unquoted: Vec::new(),
            seen: false,
        };
        records.fill()?;
        match encoding::opening(&records.buffer) {
            Opening::Other(name) => return Err(Broken::NotText(name)),
            Opening::Text(mark) => records.position = mark,
        }
        Ok(records)
    }

    /// Whether the source held anything but blank lines so far.
    pub fn seen_text(&self) -> bool {
        self.seen
    }

    /// Reads one more block behind what is left in the buffer.
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

    /// Whole lines at hand, if no byte of them needs a closer look, and the number of the first one; may be empty.
    pub fn plain_lines(&self) -> (u64, &[u8]) {
        let text = if self.plain { &self.buffer[self.position..] } else { &[] };
        (self.line, &text[..memchr::memrchr(b'\n', text).map_or(0, |last| last + 1)])
    }

    /// Goes on behind the first `lines` of [`Records::plain_lines`], `bytes` in all.
    pub fn skip(&mut self, lines: u64, bytes: usize) {
        self.line += lines;
        self.position += bytes;
    }

    /// The line that starts at `position`, filling the buffer as needed; `None` at the end.
    fn next_line(&mut self) -> Result<Option<Line>, Broken> {
        let mut searched = 0;
        loop {
            let start = self.position + searched;
            if let Some(i) = memchr::memchr2(b'\n', b'\r', &self.buffer[start..]) {
                let to = start + i;
                let carriage = self.buffer[to] == b'\r';
                if !carriage || to + 1 < self.buffer.len() || self.exhausted {
                    let pair = carriage && self.buffer.get(to + 1) == Some(&b'\n');
                    return match to - self.position > self.max_line {
                        true => Err(Broken::TooLong(self.line)),
                        false => Ok(Some(Line { to, next: to + 1 + usize::from(pair), ended: true })),
                    };
                }
                searched = to - self.position;
            } else {
                searched = self.buffer.len() - self.position;
                if searched > self.max_line {
                    return Err(Broken::TooLong(self.line));
                }
                if self.exhausted {
                    let to = self.buffer.len();
                    return Ok((searched > 0).then_some(Line { to, next: to, ended: false }));
                }
            }
            self.fill()?;
        }
    }

    /// The next record that is neither blank nor comment; `None` at the end.
    ///
    /// # Errors
    /// What cannot be cut into fields. Nothing can be read after it.
    pub fn next_record(&mut self) -> Result<Option<Record<'_>>, Broken> {
        let mut blank = None;
        loop {
            let Some(line) = self.next_line()? else { return Ok(None) };
            let text = &self.buffer[self.position..line.to];
            let delimiter = self.delimiter;
            if text.iter().all(|b| *b == b' ' || (*b == b'\t' && delimiter != b'\t')) {
                blank.get_or_insert(self.line);
            } else if !self.comment.as_ref().is_some_and(|c| trim(text).starts_with(c)) {
                self.seen = true;
                return self.cut(line, blank).map(Some);
            } else {
                self.seen = true;
            }
            self.position = line.next;
            self.line += 1;
        }
    }

    /// Cuts the line at `position` into fields.
    fn cut(&mut self, line: Line, blank: Option<u64>) -> Result<Record<'_>, Broken> {
        let (from, number) = (self.position, self.line);
        if !self.plain && self.check(from, line.to)? {
            return self.cut_quoted(blank);
        }
        self.fields.clear();
        let text = &self.buffer[from..line.to];
        let mut start = 0;
        for end in memchr::memchr_iter(self.delimiter, text) {
            self.fields.push((start, end));
            start = end + 1;
        }
        self.fields.push((start, text.len()));
        self.position = line.next;
        self.line += 1;
        Ok(Record { line: number, blank, ended: line.ended, bytes: &self.buffer[from..line.to], fields: &self.fields })
    }

    /// Refuses NUL and anything but UTF-8; says whether there is a quote.
    fn check(&self, from: usize, to: usize) -> Result<bool, Broken> {
        let text = &self.buffer[from..to];
        if memchr::memchr(0, text).is_some() {
            return Err(Broken::Nul(self.line));
        }
        if let Err(e) = std::str::from_utf8(text) {
            return Err(Broken::NotUtf8(self.line, text.get(e.valid_up_to()).copied().unwrap_or(0)));
        }
        Ok(memchr::memchr(b'"', text).is_some())
    }

    /// Cuts a record with quotes, which may go over several lines.
    fn cut_quoted(&mut self, blank: Option<u64>) -> Result<Record<'_>, Broken> {
        loop {
            self.fields.clear();
            self.unquoted.clear();
            let scan = scan_quoted(&self.buffer[self.position..], self.delimiter, &mut self.unquoted, &mut self.fields);
            let length = scan.length;
            let open = !matches!(scan.end, End::Line | End::Stray(_));
            // A CR at the very end of the buffer may be half of a CRLF.
            let half = self.buffer.get(self.position + length - 1) == Some(&b'\r')
                && self.position + length == self.buffer.len();
            if (open || half) && !self.exhausted {
                if self.buffer.len() - self.position > self.max_line {
                    return Err(Broken::TooLong(self.line));
                }
                self.fill()?;
                continue;
            }
            let (line, from) = (self.line, self.position);
            let whole = &self.buffer[from..from + length];
            if memchr::memchr(0, whole).is_some() {
                return Err(Broken::Nul(line));
            }
            if let Err(e) = std::str::from_utf8(whole) {
                return Err(Broken::NotUtf8(line, whole.get(e.valid_up_to()).copied().unwrap_or(0)));
            }
            match scan.end {
                End::Stray(field) => return Err(Broken::StrayQuote(line, field)),
                End::InQuote(field) => return Err(Broken::OpenQuote(line, field)),
                _ if length > self.max_line => return Err(Broken::TooLong(line)),
                End::Line | End::Text => {}
            }
            self.position += length;
            self.line += scan.lines.max(1);
            let ended = matches!(scan.end, End::Line);
            return Ok(Record { line, blank, ended, bytes: &self.unquoted, fields: &self.fields });
        }
    }
}

/// How the scan of a quoted record ended.
enum End {
    /// With a line end.
    Line,
    /// With the bytes, outside quotes.
    Text,
    /// With the bytes, inside the quotes of this field.
    InQuote(usize),
    /// At something behind the closing quote of this field.
    Stray(usize),
}

struct Scan {
    /// Bytes taken, the line end included.
    length: usize,
    /// Line ends taken.
    lines: u64,
    end: End,
}

/// Takes the quotes off one record: its text goes to `text`, the bounds of its fields to `fields`.
fn scan_quoted(bytes: &[u8], delimiter: u8, text: &mut Vec<u8>, fields: &mut Vec<(usize, usize)>) -> Scan {
    #[derive(PartialEq)]
    enum State {
        Before,
        Plain,
        Quoted,
        After,
    }
    let (mut state, mut start, mut lines, mut i) = (State::Before, 0, 0, 0);
    while let Some(&byte) = bytes.get(i) {
        let line_end = byte == b'\n' || byte == b'\r';
        let pair = usize::from(byte == b'\r' && bytes.get(i + 1) == Some(&b'\n'));
        if state == State::Quoted {
            match (byte, bytes.get(i + 1)) {
                (b'"', Some(b'"')) => {
                    text.push(b'"');
                    i += 1;
                }
                (b'"', _) => state = State::After,
                _ => {
                    text.extend_from_slice(&bytes[i..=i + pair]);
                    lines += u64::from(line_end);
                    i += pair;
                }
            }
        } else if line_end {
            fields.push((start, text.len()));
            return Scan { length: i + 1 + pair, lines: lines + 1, end: End::Line };
        } else if byte == delimiter {
            fields.push((start, text.len()));
            start = text.len();
            state = State::Before;
        } else if byte == b'"' && state == State::Before {
            text.truncate(start);
            state = State::Quoted;
        } else if state == State::After {
            if byte != b' ' && byte != b'\t' {
                return Scan { length: i + 1, lines, end: End::Stray(fields.len()) };
            }
        } else {
            if byte != b' ' && byte != b'\t' {
                state = State::Plain;
            }
            text.push(byte);
        }
        i += 1;
    }
    let end = if state == State::Quoted { End::InQuote(fields.len()) } else { End::Text };
    fields.push((start, text.len()));
    Scan { length: i, lines, end }
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
