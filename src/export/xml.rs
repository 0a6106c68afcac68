//! A writer of XML, element by element.

use std::fmt::Write;

use super::header::one_line;

/// A document under construction.
pub(super) struct Xml {
    text: String,
    open: Vec<String>,
}

impl Xml {
    /// A document that begins with a comment of these lines.
    pub fn new(head: &[String]) -> Xml {
        let mut xml = Xml { text: "<?xml version=\"1.0\"?>\n".into(), open: Vec::new() };
        xml.comment(head);
        xml
    }

    fn indent(&self) -> String {
        "  ".repeat(self.open.len())
    }

    /// A comment.
    pub fn comment(&mut self, lines: &[String]) {
        let indent = self.indent();
        let lines: Vec<String> = lines.iter().map(|line| speakable(line)).collect();
        let _ = match lines.as_slice() {
            [one] => writeln!(self.text, "{indent}<!-- {one} -->"),
            _ => writeln!(self.text, "{indent}<!--\n{indent}  {}\n{indent}-->", lines.join(&format!("\n{indent}  "))),
        };
    }

    /// Opens an element.
    pub fn open(&mut self, name: &str, attributes: &[(&str, &str)]) {
        let _ = writeln!(self.text, "{}<{name}{}>", self.indent(), written(attributes));
        self.open.push(name.to_string());
    }

    /// Closes the element opened last.
    pub fn close(&mut self) {
        if let Some(name) = self.open.pop() {
            let _ = writeln!(self.text, "{}</{name}>", self.indent());
        }
    }

    /// An element with text content.
    pub fn leaf(&mut self, name: &str, text: &str) {
        let _ = writeln!(self.text, "{}<{name}>{}</{name}>", self.indent(), escaped(text));
    }

    /// An element with attributes only.
    pub fn empty(&mut self, name: &str, attributes: &[(&str, &str)]) {
        let _ = writeln!(self.text, "{}<{name}{}/>", self.indent(), written(attributes));
    }

    /// The document, with all elements closed.
    pub fn finish(mut self) -> Vec<u8> {
        while !self.open.is_empty() {
            self.close();
        }
        self.text.into_bytes()
    }
}

fn written(attributes: &[(&str, &str)]) -> String {
    attributes.iter().map(|(name, value)| format!(" {name}=\"{}\"", escaped(value))).collect()
}

/// Escaped text on one line: a parser reads line ends in attributes as blanks, and XML 1.0 does not
/// allow other control characters, not even as references.
fn escaped(text: &str) -> String {
    let text = one_line(text).replace(['\u{fffe}', '\u{ffff}'], " ");
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// A line of a comment, without two hyphens in sequence, which would end the comment.
fn speakable(line: &str) -> String {
    let mut line = one_line(line).replace(['\u{fffe}', '\u{ffff}'], " ");
    while line.contains("--") {
        line = line.replace("--", "- -");
    }
    if line.ends_with('-') { line + " " } else { line }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hostile_names_do_not_leave_their_place() {
        let mut xml = Xml::new(&["a --- b".into(), "c-->".into()]);
        xml.open("model", &[("name", "\"<x>&\"")]);
        xml.leaf("a", "<b>");
        let text = String::from_utf8(xml.finish()).unwrap();
        assert_eq!(text.matches("-->").count(), 1, "{text}");
        assert!(text.contains("name=\"&quot;&lt;x&gt;&amp;&quot;\"") && text.contains("<a>&lt;b&gt;</a>"));
        assert!(text.ends_with("</model>\n"));
    }
}
