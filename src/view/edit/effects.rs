//! Edits that switch effects of the baseline on and off.

use toml_edit::{Array, Item, RawString, Value};

use super::{document, put};
use crate::campaign;
use crate::view::answer::Refusal;

/// Removes `name` from `effects` of `[model]`. If the list contains the plain id instead, `others`
/// (the id at all other places) replace it.
pub fn without(text: &str, name: &str, others: &[String]) -> Result<String, Refusal> {
    let mut document = document(text)?;
    let list = document.get_mut("model").and_then(|model| model.get_mut("effects")).and_then(Item::as_array_mut);
    let list = list.ok_or_else(|| Refusal::unusable("the campaign has no list `effects` in [model]"))?;
    let at = |list: &Array, name: &str| list.iter().position(|e| e.as_str() == Some(name));
    let id = name.split('@').next().unwrap_or(name);
    let (index, others) = match (at(list, name), at(list, id)) {
        (Some(index), _) => (index, &[][..]),
        (None, Some(index)) => (index, others),
        (None, None) => return Ok(text.to_string()),
    };
    take(list, index);
    for (k, other) in
        others.iter().filter(|other| at(list, other).is_none()).cloned().collect::<Vec<_>>().iter().enumerate()
    {
        let mut value = Value::from(other.as_str());
        if index + k > 0 {
            value.decor_mut().set_prefix(" ");
        }
        list.insert_formatted((index + k).min(list.len()), value);
    }
    // the element that was first may be second now, and then needs a leading blank
    if let Some(second) = list.get_mut(1).filter(|v| v.decor().prefix().and_then(RawString::as_str) == Some("")) {
        second.decor_mut().set_prefix(" ");
    }
    Ok(document.to_string())
}

/// Removes an element from a list; comments around it stay.
fn take(list: &mut Array, index: usize) {
    let before = |value: &Value| value.decor().prefix().and_then(RawString::as_str).unwrap_or_default().to_string();
    let gone = list.remove(index);
    let own = before(&gone);
    let behind = gone.decor().suffix().and_then(RawString::as_str).unwrap_or_default().to_string();
    let joined = |next: &str| match (own.contains('#'), behind.contains('#') || next.contains('#')) {
        (false, false) => own.clone(),
        (true, false) => own.clone() + behind.trim_end(),
        _ => format!("{}{}{next}", own.trim_end_matches([' ', '\t']), behind),
    };
    match list.get_mut(index) {
        Some(next) => {
            let prefix = joined(&before(next));
            next.decor_mut().set_prefix(prefix);
        }
        None => {
            let trailing = list.trailing().as_str().unwrap_or_default().to_string();
            if own.contains('#') || behind.contains('#') || trailing.contains('#') {
                let all = joined(&trailing);
                list.set_trailing(all);
            }
        }
    }
}

/// Adds `name` to `effects` of `[model]`, as `discover --adopt` does.
pub fn with(text: &str, name: &str) -> Result<String, Refusal> {
    campaign::with_effects(text, &[name.to_string()]).map_err(Refusal::unusable)
}

/// Sets the role of the user's own effect `id`: `baseline` or `candidate`.
pub fn own(text: &str, id: &str, role: &str) -> Result<String, Refusal> {
    let mut document = document(text)?;
    let tables = document.get_mut("effect").and_then(Item::as_array_of_tables_mut);
    let table = tables.and_then(|list| list.iter_mut().find(|t| t.get("id").and_then(Item::as_str) == Some(id)));
    let table = table.ok_or_else(|| Refusal::absent(format!("no [[effect]] has the id {id:?}")))?;
    put(table, "role", role);
    Ok(document.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn off(list: &str, name: &str, others: &[&str]) -> String {
        let text = format!("# mine\n[model] # m\neffects = {list} # so far\n");
        let others: Vec<String> = others.iter().map(ToString::to_string).collect();
        let text = without(&text, name, &others).unwrap();
        let rest = text.strip_prefix("# mine\n[model] # m\neffects = ").and_then(|t| t.strip_suffix(" # so far\n"));
        rest.expect("the rest stands").to_string()
    }

    #[test]
    fn names_leave_the_list_as_it_is_written() {
        assert_eq!(off("[\"a\", \"b\", \"c\"]", "b", &[]), "[\"a\", \"c\"]");
        assert_eq!(off("[\"a\", \"b\"]", "a", &[]), "[\"b\"]");
        assert_eq!(off("[\"a\", \"b\"]", "b", &[]), "[\"a\"]");
        assert_eq!(off("[\"a\"]", "z", &[]), "[\"a\"]");
        assert_eq!(off("[\n  'a',  # of a\n  'b',\n  'c',\n]", "b", &[]), "[\n  'a',  # of a\n  'c',\n]");
        let kept = off("[\n  'a',\n  'b',  # of b\n  'c',\n]", "b", &[]);
        assert!(kept.contains("# of b") && !kept.contains("'b'"), "{kept}");
    }

    #[test]
    fn of_a_plain_id_the_other_places_stay() {
        let list = off("[\"a\", \"d\", \"c\"]", "d@yaw", &["d@surge", "d@sway"]);
        assert_eq!(list, "[\"a\", \"d@surge\", \"d@sway\", \"c\"]");
        assert_eq!(off("[\"d\"]", "d@yaw", &["d@surge"]), "[\"d@surge\"]");
        assert_eq!(off("[\"d\", \"c\"]", "d@yaw", &["d@surge"]), "[\"d@surge\", \"c\"]");
        assert_eq!(off("[\"d@yaw\", \"d@surge\"]", "d@yaw", &[]), "[\"d@surge\"]");
    }

    #[test]
    fn an_own_effect_changes_its_role() {
        let text = "[[effect]]\nid = 'wind' # blows\nrole = 'candidate' # so far\n";
        assert_eq!(
            own(text, "wind", "baseline").unwrap(),
            "[[effect]]\nid = 'wind' # blows\nrole = \"baseline\" # so far\n"
        );
        assert_eq!(own(text, "sail", "baseline").unwrap_err().status, 404);
    }
}
