//! The nearest known word to a mistyped one, for "did you mean …?".
//!
//! Nearness is the Damerau-Levenshtein distance: letters inserted, left out, changed, or swapped with a neighbour.

/// The known word nearest to `word`; `None` when none is near: at most a third of its letters, and at least one, may
/// be wrong. Capitals do not count, and `-` is `_`.
pub fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    // A long word is no slip of the pen, and the distance takes time in proportion to both lengths.
    if word.len() > 100 {
        return None;
    }
    let word = word.trim().to_lowercase().replace('-', "_");
    let allowed = (word.chars().count() / 3).max(1);
    known
        .into_iter()
        .map(|k| (strsim::damerau_levenshtein(&word, &k.to_lowercase()), k))
        .filter(|(distance, _)| *distance <= allowed)
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, k)| k)
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
        assert_eq!(nearest(&"s".repeat(1000), known), None);
    }
}
