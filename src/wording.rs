//! Wording shared by many messages: counts, numbers and probabilities for people.

/// Least p-value: 0 would mean impossible.
pub const LEAST_P: f64 = 1e-300;

/// Least p-value that is written as a number. A smaller one is written as below this limit, because
/// no approximation behind a p-value is valid so far out.
const LEAST_TOLD: f64 = 1e-15;

/// `1 warning`, `2 warnings`, `3 command histories`.
pub fn count(n: usize, thing: &str) -> String {
    match n {
        1 => format!("1 {thing}"),
        n => format!("{n} {}", plural(thing)),
    }
}

/// The plural of a noun whose last word is regular: `runs`, `histories`, `matches`.
fn plural(thing: &str) -> String {
    if let Some(stem) = thing.strip_suffix('y').filter(|stem| !stem.ends_with(['a', 'e', 'o', 'u'])) {
        return format!("{stem}ies");
    }
    let hisses = ["s", "x", "ch", "sh"].iter().any(|end| thing.ends_with(end));
    format!("{thing}{}", if hisses { "es" } else { "s" })
}

/// Items as a list in a sentence: `a`, `a and b`, `a, b and c`.
pub fn listed<T: AsRef<str>>(things: &[T]) -> String {
    let things: Vec<&str> = things.iter().map(AsRef::as_ref).collect();
    match things.split_last() {
        Some((last, before)) if !before.is_empty() => format!("{} and {last}", before.join(", ")),
        _ => things.concat(),
    }
}

/// A sentence with a capital at the beginning.
pub fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

/// The least and the greatest of some values; `None` if there are none.
pub fn range(values: impl IntoIterator<Item = f64>) -> Option<(f64, f64)> {
    values.into_iter().map(|x| (x, x)).reduce(|(least, greatest), (x, _)| (least.min(x), greatest.max(x)))
}

/// `least to greatest ± deviation by run` for per-run values; `None` if there are none. `told`:
/// text of a value.
pub fn by_run(values: impl IntoIterator<Item = f64>, told: impl Fn(f64) -> String) -> Option<String> {
    range(values).map(|(least, greatest)| {
        let (least, greatest) = (told(least), told(greatest));
        // a common standard deviation is written once
        let deviation = |text: &str| text.split_once(" ± ").map(|(_, std)| std.to_string());
        let alone =
            least.split_once(" ± ").map(|(value, _)| value).filter(|_| deviation(&least) == deviation(&greatest));
        format!("{} to {greatest} by run", alone.unwrap_or(&least))
    })
}

/// A number with two significant digits and all digits before the point: `0.031`, `12`, `123`.
pub fn digits(x: f64) -> String {
    if x == 0.0 || !x.is_finite() {
        return format!("{x}");
    }
    format!("{x:.*}", (1 - x.abs().log10().floor() as i32).max(0) as usize)
}

/// A value with its standard deviation, to two digits of the standard deviation: `12.30 ± 0.45`,
/// `5.65e10 ± 3.7e10`. A standard deviation that is 0 or not finite is written as it is.
pub fn measured(value: f64, std: f64) -> String {
    let place = std.log10().floor();
    match std {
        std if (1e-6..1e7).contains(&std) => {
            let decimals = (1 - place as i32).clamp(0, 9) as usize;
            format!("{value:.decimals$} ± {std:.decimals$}")
        }
        std if std > 0.0 && std.is_finite() => {
            // digits down to the second one of the standard deviation
            let digits = (value.abs().log10().floor() - place).clamp(0.0, 8.0) as usize + 1;
            format!("{value:.digits$e} ± {std:.1e}")
        }
        std => format!("{} ± {std}", format!("{value:.5e}").parse().unwrap_or(value)),
    }
}

/// A ratio in words: `9.5 times`, `more than 100 times`.
pub fn times(ratio: f64) -> String {
    if ratio > 100.0 { "more than 100 times".into() } else { format!("{} times", digits(ratio)) }
}

/// A probability for a cell of a table: `0.045`, `3.1e-7`, `<1e-15`.
pub fn probability(p: f64) -> String {
    match p {
        p if p.is_nan() => "-".into(),
        p if p <= LEAST_TOLD => format!("<{LEAST_TOLD:e}"),
        p if p < 1e-3 => format!("{p:.1e}"),
        // two digits: 0.0451 as 0.045, 0.9 as 0.90
        p => format!(
            "{p:.*}",
            if p < 0.01 {
                4
            } else if p < 0.1 {
                3
            } else {
                2
            }
        ),
    }
}

/// A probability in a sentence: `p = 0.045`, `p < 1e-15`.
pub fn p_value(p: f64) -> String {
    match probability(p).strip_prefix('<') {
        Some(least) => format!("p < {least}"),
        None => format!("p = {}", probability(p)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_deviation_has_two_digits_and_its_value_ends_with_them() {
        assert_eq!(measured(12.3004, 0.4512), "12.30 ± 0.45");
        assert_eq!(measured(17_902_464.2, 300_721.4), "17902464 ± 300721");
        assert_eq!(measured(5.652e10, 3.718e10), "5.7e10 ± 3.7e10");
        assert_eq!(measured(0.0, 1.194e9), "0.0e0 ± 1.2e9");
        assert_eq!(measured(180.0, 0.0), "180 ± 0");
        assert_eq!(measured(0.2, f64::NAN), "0.2 ± NaN");
    }

    #[test]
    fn what_each_run_has_its_own_of_is_told_from_the_least_to_the_greatest() {
        let alike = |x: f64| format!("{x} ± 0.1");
        assert_eq!(by_run([2.0, -1.5, 0.0], alike).unwrap(), "-1.5 to 2 ± 0.1 by run");
        assert_eq!(by_run([2.0, 1.0], |x| format!("{x} ± {x}")).unwrap(), "1 ± 1 to 2 ± 2 by run");
        assert_eq!(by_run([3.0], digits).unwrap(), "3.0 to 3.0 by run");
        assert_eq!(by_run([], digits), None);
    }

    #[test]
    fn numbers_have_two_digits_and_all_before_the_point() {
        assert_eq!([0.0, 0.0312, 12.34, 123.4].map(digits), ["0", "0.031", "12", "123"]);
    }

    #[test]
    fn things_are_listed_as_in_a_sentence() {
        assert_eq!([&["a"][..], &["a", "b"], &["a", "b", "c"], &[]].map(listed), ["a", "a and b", "a, b and c", ""]);
    }

    #[test]
    fn sentences_begin_with_a_capital() {
        assert_eq!(["surge: 3 N", "écart", ""].map(capitalised), ["Surge: 3 N", "Écart", ""]);
    }

    #[test]
    fn ratios_end_at_a_hundred() {
        assert_eq!([9.53, 95.0, 78073.0].map(times), ["9.5 times", "95 times", "more than 100 times"]);
    }

    #[test]
    fn things_are_counted_in_english() {
        let told = |n, thing| count(n, thing);
        assert_eq!(told(1, "command history"), "1 command history");
        assert_eq!(told(3, "command history"), "3 command histories");
        assert_eq!((told(0, "warning"), told(1, "warning")), ("0 warnings".into(), "1 warning".into()));
        assert_eq!((told(2, "batch"), told(2, "day")), ("2 batches".into(), "2 days".into()));
    }

    #[test]
    fn no_probability_is_nothing() {
        assert_eq!((probability(0.0), p_value(0.0)), ("<1e-15".into(), "p < 1e-15".into()));
        assert_eq!((probability(3.14e-7), p_value(0.0451)), ("3.1e-7".into(), "p = 0.045".into()));
        assert_eq!(
            (probability(0.9), probability(0.00451), probability(1.0)),
            ("0.90".into(), "0.0045".into(), "1.00".into())
        );
        assert_eq!(probability(f64::NAN), "-");
    }
}
