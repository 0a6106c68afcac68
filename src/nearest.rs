//! The nearest known word to a mistyped one, for "did you mean …?".
//!
//! The measure is the Damerau-Levenshtein distance: letters inserted, left out, changed, or swapped
//! with a neighbour.

/// The known word nearest to `word`; `None` if none is near: up to a third of its letters, and at
/// least one, may be wrong. Capitals do not count, and `-` equals `_`.
pub fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    // A long word is no typing error, and the time for the distance is proportional to both
    // lengths.
    if word.len() > 100 {
        return None;
    }
    let word = as_written(word);
    let allowed = (word.chars().count() / 3).max(1);
    known
        .into_iter()
        .map(|k| (strsim::damerau_levenshtein(&word, &k.to_lowercase()), k))
        .filter(|(distance, _)| *distance <= allowed)
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, k)| k)
}

/// The `most` known words closest to `word`, however far they are, for a list of suggestions.
pub fn most_alike<'a>(word: &str, known: impl IntoIterator<Item = &'a str>, most: usize) -> Vec<&'a str> {
    // the rest of a long word gives no further information
    let word: String = as_written(word).chars().take(100).collect();
    let mut ranked: Vec<(f64, &str)> =
        known.into_iter().map(|k| (strsim::normalized_damerau_levenshtein(&word, &k.to_lowercase()), k)).collect();
    ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
    ranked.into_iter().take(most).map(|(_, k)| k).collect()
}

/// A word in the form of the known ones: without capitals, `-` as `_`.
fn as_written(word: &str) -> String {
    word.trim().to_lowercase().replace('-', "_")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_of_the_pen_are_understood_and_no_more() {
        let known = ["surge", "sway", "linear_drag", "quadratic_drag"];
        assert_eq!(nearest("sruge", known), Some("surge"));
        assert_eq!(nearest("Linear-Drag", known), Some("linear_drag"));
        assert_eq!(nearest("quadratic", known), None);
        assert_eq!(nearest("", known), None);
        assert_eq!(most_alike("quadratic", known, 1), ["quadratic_drag"]);
        assert_eq!(most_alike("", known, 9).len(), known.len());
        assert_eq!(nearest(&"s".repeat(1000), known), None);
    }
}
