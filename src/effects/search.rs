//! Search of the catalogue by words: ids, common names and meanings.

use std::sync::Arc;

use super::{Effect, common_name};
use crate::nearest::nearest;

/// The effects of `all` that contain every word of `text` in id, common name or meaning. Case does
/// not matter, and `_` and `-` are spaces.
pub fn search<'e>(all: &'e [Arc<dyn Effect>], text: &str) -> Vec<&'e dyn Effect> {
    let text = plain(text);
    let wanted: Vec<&str> = text.split_whitespace().collect();
    let holds = |effect: &&Arc<dyn Effect>| {
        let told = words_of(effect.as_ref());
        wanted.iter().all(|word| told.contains(word))
    };
    all.iter().filter(holds).map(AsRef::as_ref).collect()
}

/// `text` with each unknown word replaced by the nearest word of the catalogue: `munc` becomes
/// `munk`. `None` if an unknown word has no near one, or no effect contains all words.
pub fn meant(all: &[Arc<dyn Effect>], text: &str) -> Option<String> {
    let catalogue: Vec<String> = all.iter().map(|effect| words_of(effect.as_ref())).collect();
    let known = |word: &str| catalogue.iter().any(|told| told.contains(word));
    let every = || catalogue.iter().flat_map(|told| told.split(|c: char| !c.is_alphanumeric()));
    let mended = |word: &str| match known(word) {
        true => Some(word.to_string()),
        false => nearest(word, every()).map(str::to_string),
    };
    let words: Option<Vec<String>> = plain(text).split_whitespace().map(mended).collect();
    words.map(|words| words.join(" ")).filter(|words| !search(all, words).is_empty())
}

/// The text of an effect that is searched.
fn words_of(effect: &dyn Effect) -> String {
    let about = effect.about();
    plain(&format!("{} {} {}", about.id, common_name(about.id), about.meaning))
}

fn plain(text: &str) -> String {
    text.to_lowercase().replace(['_', '-'], " ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::{Coriolis, catalogue};

    fn ids(text: &str) -> Vec<String> {
        search(&catalogue(Coriolis::Tied), text).iter().map(|e| e.about().id.to_string()).collect()
    }

    #[test]
    fn effects_are_found_by_id_common_name_and_meaning() {
        assert_eq!(ids("MUNK"), ["coriolis_pitch", "coriolis_yaw"]);
        assert_eq!(ids("rotor lag"), ["thrust_lag"]);
        assert_eq!(ids("thrust-lag"), ["thrust_lag"]);
        assert!(ids("added mass").contains(&"inertia".to_string()), "its meaning tells of added mass");
        assert_eq!(ids("").len(), catalogue(Coriolis::Tied).len());
        assert!(ids("munk rotor").is_empty());
    }

    #[test]
    fn a_mistyped_word_is_understood() {
        let all = catalogue(Coriolis::Tied);
        assert_eq!(meant(&all, "Munc moment").as_deref(), Some("munk moment"));
        assert_eq!(meant(&all, "warp drive"), None);
        assert_eq!(meant(&all, "munk rotor"), None, "each is known, and no effect has both");
    }
}
