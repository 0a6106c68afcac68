//! Parser from text to a syntax tree, with the Pratt parser of `winnow`.
//!
//! ```text
//! loosest  ||   &&   > < >= <= == !=   + -   * /   prefix - !   ^ (from the right)   tightest
//! ```
//!
//! −u^2 is −(u²), as in mathematics and in Python.

use winnow::ascii::{float, multispace0};
use winnow::combinator::{
    Infix, Prefix, alt, cut_err, delimited, expression, opt, peek, preceded, separated, terminated,
};
use winnow::error::{ContextError, ErrMode};
use winnow::prelude::*;
use winnow::stream::LocatingSlice;
use winnow::token::{any, one_of, take_while};

use super::FormulaError;

/// Maximum number of characters of a formula.
const LONGEST: usize = 1000;
/// Maximum nesting of brackets.
const DEEPEST: usize = 40;

/// A name with its position, in bytes from the beginning.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Name {
    pub text: String,
    pub at: usize,
}

/// An operator with two operands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Operator {
    Or,
    And,
    Greater,
    Less,
    GreaterEqual,
    LessEqual,
    Equal,
    Unequal,
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
}

/// The syntax tree of a formula.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Syntax {
    Number(f64),
    Name(Name),
    Call(Name, Vec<Syntax>),
    Minus(Box<Syntax>),
    Not(Box<Syntax>),
    Binary(Operator, Box<Syntax>, Box<Syntax>),
}

type Input<'i> = LocatingSlice<&'i str>;
type Error = ErrMode<ContextError>;

/// Parses a whole text.
///
/// # Errors
/// [`FormulaError::Syntax`], [`FormulaError::TooLarge`].
pub(super) fn parse(text: &str) -> Result<Syntax, FormulaError> {
    let mut depth = 0_usize;
    let deepest = text
        .chars()
        .map(|c| {
            match c {
                '(' => depth += 1,
                ')' => depth = depth.saturating_sub(1),
                _ => {}
            }
            depth
        })
        .max()
        .unwrap_or(0);
    let length = text.chars().count();
    // the parser recurses once per bracket and once per prefix
    if length > LONGEST || deepest > DEEPEST {
        return Err(FormulaError::TooLarge { length, depth: deepest, longest: LONGEST, deepest: DEEPEST });
    }
    formula.parse(LocatingSlice::new(text)).map_err(|error| {
        let rest = text[error.offset()..].trim_start();
        let before = &text[..text.len() - rest.len()];
        let complete = LocatingSlice::new(before.trim_end());
        let closed = formula.parse(complete).is_ok();
        let inside = before.matches('(').count() > before.matches(')').count();
        let expected = match (closed || inside && ends_an_operand(before), inside) {
            (true, true) => "an operator or `)`",
            (true, false) => "an operator or the end",
            (false, _) => "a number, a name or `(`",
        };
        let column = before.chars().count() + 1;
        FormulaError::Syntax { formula: text.to_string(), column, found: rest.chars().next(), expected }
    })
}

fn ends_an_operand(before: &str) -> bool {
    before.trim_end().ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == ')' || c == '.')
}

fn formula(input: &mut Input<'_>) -> Result<Syntax, Error> {
    delimited(multispace0, expression(operand).prefix(prefix).infix(infix), multispace0).parse_next(input)
}

fn infix<'i>(input: &mut Input<'i>) -> Result<Infix<Input<'i>, Syntax, Error>, Error> {
    use Operator::*;
    let long = alt(("||", "&&", ">=", "<=", "==", "!=", "**"));
    let short = one_of(['>', '<', '+', '-', '*', '/', '^']).take();
    Ok(match delimited(multispace0, alt((long, short)), multispace0).parse_next(input)? {
        "||" => Infix::Left(1, |_, a, b| Ok(join(Or, a, b))),
        "&&" => Infix::Left(2, |_, a, b| Ok(join(And, a, b))),
        ">" => Infix::Neither(3, |_, a, b| Ok(join(Greater, a, b))),
        "<" => Infix::Neither(3, |_, a, b| Ok(join(Less, a, b))),
        ">=" => Infix::Neither(3, |_, a, b| Ok(join(GreaterEqual, a, b))),
        "<=" => Infix::Neither(3, |_, a, b| Ok(join(LessEqual, a, b))),
        "==" => Infix::Neither(3, |_, a, b| Ok(join(Equal, a, b))),
        "!=" => Infix::Neither(3, |_, a, b| Ok(join(Unequal, a, b))),
        "+" => Infix::Left(5, |_, a, b| Ok(join(Add, a, b))),
        "-" => Infix::Left(5, |_, a, b| Ok(join(Subtract, a, b))),
        "*" => Infix::Left(7, |_, a, b| Ok(join(Multiply, a, b))),
        "/" => Infix::Left(7, |_, a, b| Ok(join(Divide, a, b))),
        _ => Infix::Right(11, |_, a, b| Ok(join(Power, a, b))),
    })
}

fn prefix<'i>(input: &mut Input<'i>) -> Result<Prefix<Input<'i>, Syntax, Error>, Error> {
    // a character that is no prefix must stay unread, so that the error has the right column
    peek(one_of(['-', '+', '!'])).parse_next(input)?;
    Ok(match terminated(any, multispace0).parse_next(input)? {
        '-' => Prefix(9, |_, a| Ok(Syntax::Minus(Box::new(a)))),
        '!' => Prefix(9, |_, a| Ok(Syntax::Not(Box::new(a)))),
        _ => Prefix(9, |_, a| Ok(a)),
    })
}

fn join(operator: Operator, a: Syntax, b: Syntax) -> Syntax {
    Syntax::Binary(operator, Box::new(a), Box::new(b))
}

fn operand(input: &mut Input<'_>) -> Result<Syntax, Error> {
    let bracketed = || delimited('(', cut_err(formula), cut_err(')'));
    let letter = |c: char| c.is_alphabetic() || c == '_';
    let word = (one_of(letter), take_while(0.., |c: char| c.is_alphanumeric() || c == '_')).take().with_span();
    let arguments = delimited('(', cut_err(separated(1.., formula, ',')), cut_err(')'));
    let named = (word, opt(preceded(multispace0, arguments))).map(|((text, span), arguments): (_, Option<Vec<_>>)| {
        let name = Name { text: String::from(text), at: span.start };
        match arguments {
            None => Syntax::Name(name),
            Some(arguments) => Syntax::Call(name, arguments),
        }
    });
    // `float` would also read inf and nan, which are names here, and signs, which are operators
    let number = preceded(peek(one_of(|c: char| c.is_ascii_digit() || c == '.')), float.map(Syntax::Number));
    alt((number, named, bracketed())).parse_next(input)
}
