//! Format of numbers in files.

/// A number with eleven significant digits, with an exponent only if it is very small or large, and
/// never −0.
pub(super) fn number(x: f64) -> String {
    let short: f64 = format!("{x:.10e}").parse().unwrap_or(x);
    if short == 0.0 {
        return "0".into();
    }
    if (1e-5..1e15).contains(&short.abs()) { format!("{short}") } else { format!("{short:e}") }
}

/// Numbers joined by `between`.
pub(super) fn numbers(values: &[f64], between: &str) -> String {
    values.iter().map(|x| number(*x)).collect::<Vec<_>>().join(between)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_does_not_show() {
        assert_eq!(number(0.1 + 0.2), "0.3");
        assert_eq!(number(-0.0), "0");
        assert_eq!(number(-299.99999999999994), "-300");
        assert_eq!(number(1.5e-9), "1.5e-9");
        assert_eq!(numbers(&[1.0, -2.5], " "), "1 -2.5");
    }
}
