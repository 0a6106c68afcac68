//! Text that may contain mathematical symbols: `k_u|u|` with a true subscript in HTML, SVG and
//! LaTeX.
//!
//! In a symbol `_` makes a subscript and `^` a superscript of what follows: a group in braces, or
//! the letters, digits and bars that follow directly. Plain text is left unchanged, so that
//! `surge_p28.csv` stays a file name.

use super::escape::escape;

/// A word or a symbol.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Label {
    /// Shown as it is.
    Plain(String),
    /// `_` makes a subscript, `^` a superscript.
    Symbol(String),
}

impl From<&str> for Label {
    fn from(text: &str) -> Label {
        Label::Plain(text.into())
    }
}

impl From<String> for Label {
    fn from(text: String) -> Label {
        Label::Plain(text)
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Level {
    Base,
    Lowered,
    Raised,
}

impl Label {
    /// A symbol: `Label::symbol("k_u|u|")`.
    pub fn symbol(text: impl Into<String>) -> Label {
        Label::Symbol(text.into())
    }

    /// The text as it was given.
    pub fn text(&self) -> &str {
        match self {
            Label::Plain(text) | Label::Symbol(text) => text,
        }
    }

    /// Escaped HTML.
    pub fn html(&self) -> String {
        let mut out = String::new();
        for (level, text) in self.pieces() {
            let text = escape(&text);
            match level {
                Level::Base => out.push_str(&text),
                Level::Lowered => out.push_str(&format!("<sub>{text}</sub>")),
                Level::Raised => out.push_str(&format!("<sup>{text}</sup>")),
            }
        }
        out
    }

    /// Escaped content of an SVG `<text>`.
    pub fn svg(&self) -> String {
        let mut out = String::new();
        let mut height = 0;
        for (level, text) in self.pieces() {
            let (target, small) = match level {
                Level::Base => (0, ""),
                Level::Lowered => (3, " font-size=\"78%\""),
                Level::Raised => (-5, " font-size=\"78%\""),
            };
            let text = escape(&text);
            if target == height && small.is_empty() {
                out.push_str(&text);
            } else {
                out.push_str(&format!("<tspan dy=\"{}\"{small}>{text}</tspan>", target - height));
            }
            height = target;
        }
        out
    }

    /// LaTeX: text with its special characters escaped, or mathematics.
    pub fn latex(&self) -> String {
        match self {
            Label::Plain(text) => latex_text(text),
            Label::Symbol(_) => {
                let mut out = String::from("$");
                for (level, text) in self.pieces() {
                    let text = latex_text(&text);
                    match level {
                        Level::Base => out.push_str(&text),
                        Level::Lowered => out.push_str(&format!("_{{{text}}}")),
                        Level::Raised => out.push_str(&format!("^{{{text}}}")),
                    }
                }
                out.push('$');
                out
            }
        }
    }

    /// Number of characters that take up width.
    pub(super) fn length(&self) -> usize {
        self.pieces().iter().map(|(_, text)| text.chars().count()).sum()
    }

    fn pieces(&self) -> Vec<(Level, String)> {
        let text = match self {
            Label::Plain(text) => return vec![(Level::Base, text.clone())],
            Label::Symbol(text) => text,
        };
        let mut pieces = Vec::new();
        let mut base = String::new();
        let mut rest = text.chars().peekable();
        while let Some(c) = rest.next() {
            let level = match c {
                '_' => Level::Lowered,
                '^' => Level::Raised,
                c => {
                    base.push(c);
                    continue;
                }
            };
            let mut script = String::new();
            if rest.next_if_eq(&'{').is_some() {
                script.extend(rest.by_ref().take_while(|c| *c != '}'));
            } else {
                while let Some(c) = rest.next_if(|c| c.is_alphanumeric() || *c == '|') {
                    script.push(c);
                }
            }
            if !base.is_empty() {
                pieces.push((Level::Base, std::mem::take(&mut base)));
            }
            pieces.push((level, script));
        }
        if !base.is_empty() {
            pieces.push((Level::Base, base));
        }
        pieces
    }
}

/// A unit in print form: `N*m` becomes N·m, `m^2` and `m2` become m².
pub fn unit(text: &str) -> String {
    let mut out = String::new();
    let mut rest = text.chars().peekable();
    let mut raised = false;
    let mut before = ' ';
    while let Some(c) = rest.next() {
        raised |= c.is_ascii_digit() && before.is_ascii_alphabetic();
        before = c;
        match c {
            '*' => out.push('·'),
            '^' => {
                raised = true;
                continue;
            }
            '-' if raised => {
                out.push('⁻');
                continue;
            }
            '0'..='9' if raised => {
                out.extend(super::number::power_of_ten(c.to_digit(10).unwrap_or(0) as i32).chars().skip(2));
                if rest.peek().is_some_and(char::is_ascii_digit) {
                    continue;
                }
            }
            c => out.push(c),
        }
        raised = false;
    }
    out
}

fn latex_text(text: &str) -> String {
    let mut out = String::new();
    for c in text.chars() {
        match c {
            '&' | '%' | '$' | '#' | '_' | '{' | '}' => out.extend(['\\', c]),
            '\\' => out.push_str(r"\textbackslash{}"),
            '~' => out.push_str(r"\textasciitilde{}"),
            '^' => out.push_str(r"\textasciicircum{}"),
            '\u{202f}' => out.push_str(r"\,"),
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn subscripts_and_superscripts() {
        let label = Label::symbol("X_u|u| = k^2·u_{<a>}");
        assert_eq!(label.html(), "X<sub>u|u|</sub> = k<sup>2</sup>·u<sub>&lt;a&gt;</sub>");
        assert_eq!(label.latex(), "$X_{u|u|} = k^{2}·u_{<a>}$");
        assert_eq!(label.length(), "Xu|u| = k2·u<a>".chars().count());
        assert!(
            label.svg().starts_with("X<tspan dy=\"3\" font-size=\"78%\">u|u|</tspan><tspan dy=\"-3\"> = k</tspan>")
        );
    }

    #[test]
    fn plain_text_is_no_mathematics() {
        assert_eq!(Label::from("surge_p28.csv").html(), "surge_p28.csv");
        assert_eq!(Label::from("a_b & 5%").latex(), r"a\_b \& 5\%");
    }

    #[test]
    fn units_are_printed_with_dots_and_powers() {
        assert_eq!(unit("N*m"), "N·m");
        assert_eq!(unit("kg*m^2"), "kg·m²");
        assert_eq!(unit("m*s^-12/kg"), "m·s⁻¹²/kg");
        assert_eq!(unit("kg/m"), "kg/m");
        assert_eq!(unit("kg*m2/s"), "kg·m²/s");
        assert_eq!(unit("1/s"), "1/s");
    }
}
