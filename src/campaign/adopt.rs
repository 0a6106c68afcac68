//! Effects that were named, written into the text of a campaign: its list `effects` grows, everything else stays as it
//! stands, comments included.

use serde::Deserialize;
use toml::Spanned;

use super::baseline::Own;
use super::load::Campaign;
use crate::discover::Discovery;

/// Where a campaign lists the effects of its baseline.
#[derive(Deserialize)]
struct Listing {
    model: ModelListing,
}

#[derive(Deserialize)]
struct ModelListing {
    effects: Spanned<Vec<Spanned<String>>>,
}

/// Names under which a campaign lists what `found` added to its baseline, `"coriolis_yaw"`; of an effect of its own the id.
pub(super) fn named(campaign: &Campaign, found: &Discovery) -> Vec<String> {
    let terms = |step: Option<&crate::discover::Step>| -> Vec<String> {
        step.map_or(Vec::new(), |step| step.fit.model.terms.iter().map(crate::model::Term::name).collect())
    };
    let before = terms(found.steps.first());
    let own = |name: &String| {
        let of = |(effect, place): &Own| crate::model::name_of(effect.about().id, *place) == *name;
        campaign.candidates.iter().find(|own| of(own)).map(|(effect, _)| effect.about().id.to_string())
    };
    let added = terms(found.steps.last()).into_iter().filter(|name| !before.contains(name));
    // a term that left again does not count
    let kept = |name: &String| found.effects.iter().any(|e| e.id.split('@').next() == name.split('@').next());
    added.filter(kept).map(|name| own(&name).unwrap_or(name)).collect()
}

/// `text` of a campaign with `names` in its list `effects`; as it is where they stand there already.
///
/// # Errors
/// What `text` lacks to be the text of a campaign.
pub fn adopt(text: &str, names: &[String]) -> Result<String, String> {
    let listing: Listing = toml::from_str(text).map_err(|e| e.message().to_string())?;
    let effects = listing.model.effects;
    let there: Vec<&str> = effects.get_ref().iter().map(|name| name.get_ref().as_str()).collect();
    let new: Vec<&String> = names.iter().filter(|name| !there.contains(&name.as_str())).collect();
    let listed = effects.get_ref();
    let after = listed.last().map_or(effects.span().start + 1, |last| last.span().end);
    // a list with a line for each name goes on in that way
    let between = match listed.as_slice() {
        [.., before, last] => {
            let gap = &text[before.span().end..last.span().start];
            gap.find('\n').map_or(" ", |at| &gap[at..]).to_string()
        }
        _ => " ".to_string(),
    };
    let added: String = new
        .iter()
        .enumerate()
        .map(|(k, name)| match listed.is_empty() && k == 0 {
            true => format!("{name:?}"),
            false => format!(",{between}{name:?}"),
        })
        .collect();
    Ok([&text[..after], &added, &text[after..]].concat())
}

#[cfg(test)]
mod tests {
    use super::adopt;

    fn with(list: &str, names: &[&str]) -> String {
        let text = format!("# mine\n[model]\ndofs = [\"yaw\"] # one\neffects = {list} # so far\n[fit]\n");
        let names: Vec<String> = names.iter().map(ToString::to_string).collect();
        let text = adopt(&text, &names).unwrap();
        let (begin, end) = ("# mine\n[model]\ndofs = [\"yaw\"] # one\neffects = ", " # so far\n[fit]\n");
        text.strip_prefix(begin).and_then(|t| t.strip_suffix(end)).expect("the rest stands").to_string()
    }

    #[test]
    fn names_join_the_list_as_it_is_written() {
        assert_eq!(with("[\"inertia\"]", &["coriolis_yaw"]), "[\"inertia\", \"coriolis_yaw\"]");
        assert_eq!(with("[]", &["a", "b@yaw"]), "[\"a\", \"b@yaw\"]");
        assert_eq!(with("['inertia', 'a', ]", &["b"]), "['inertia', 'a', \"b\", ]");
        assert_eq!(with("['inertia', 'a']", &["a"]), "['inertia', 'a']");
        let lines = "[\n  'inertia',  # m\n  'a',\n]";
        assert_eq!(with(lines, &["b"]), "[\n  'inertia',  # m\n  'a',\n  \"b\",\n]");
    }

    #[test]
    fn what_is_no_campaign_is_told() {
        assert!(adopt("format = 1", &[]).unwrap_err().contains("model"));
    }
}
