//! Edits of runs: their role and stretch, further stretches of one log, runs of new logs.

use toml_edit::{DocumentMut, Item, Table};

use super::{document, put, run, runs, unplaced};
use crate::run::Role;
use crate::view::answer::Refusal;

/// The part of a log that a run uses, and its role.
#[derive(Debug, Clone, Copy, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stretch {
    /// Fit or validation.
    pub role: Role,
    /// First instant, s; that of the log if absent.
    #[serde(default)]
    pub from: Option<f64>,
    /// Last instant, s; that of the log if absent.
    #[serde(default)]
    pub to: Option<f64>,
}

impl Stretch {
    fn write(self, table: &mut Table) {
        put(table, "role", if self.role == Role::Validate { "validate" } else { "train" });
        for (key, value) in [("from", self.from), ("to", self.to)] {
            match value {
                Some(value) => put(table, key, value),
                None => drop(table.remove(key)),
            }
        }
    }
}

/// Sets the stretch and role of run `index`.
pub fn set(text: &str, index: usize, stretch: Stretch) -> Result<String, Refusal> {
    let mut document = document(text)?;
    stretch.write(run(&mut document, index)?);
    Ok(document.to_string())
}

/// Adds a further run of the logs of run `index`, after it.
pub fn add(text: &str, index: usize, stretch: Stretch) -> Result<String, Refusal> {
    let mut document = document(text)?;
    let mut copy = run(&mut document, index)?.clone();
    unplaced(&mut copy);
    copy.decor_mut().set_prefix("\n");
    stretch.write(&mut copy);
    runs(&mut document)?.insert(index + 1, copy);
    Ok(document.to_string())
}

/// Removes run `index`; its log stays where it is.
pub fn remove(text: &str, index: usize) -> Result<String, Refusal> {
    let mut document = document(text)?;
    run(&mut document, index)?;
    runs(&mut document)?.remove(index);
    Ok(document.to_string())
}

/// Adds the runs of `written`, a campaign of new logs only, after the existing ones. Reading
/// options that its runs share are added to each run, unless they equal those of the campaign.
pub fn append(text: &str, written: &str) -> Result<String, Refusal> {
    let (mut document, mut new) = (document(text)?, document(written)?);
    let options = |document: &DocumentMut| document.get("log").and_then(Item::as_table).cloned().unwrap_or_default();
    let plain = |table: &Table| {
        let text = table.to_string();
        toml::from_str::<toml::Table>(&text).unwrap_or_default()
    };
    let common = options(&new);
    let own = !common.is_empty() && plain(&common) != plain(&options(&document));
    let fresh: Vec<Table> = runs(&mut new)?.iter().cloned().collect();
    let there = runs(&mut document)?;
    for mut table in fresh {
        if own && !table.contains_key("log") {
            let mut log = common.clone();
            log.decor_mut().clear();
            table.insert("log", Item::Table(log));
        }
        unplaced(&mut table);
        there.push(table);
    }
    Ok(document.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "# mine\nformat = 1\n\n[[run]]\nfile = 'a.csv' # the first\nrole = 'train' # so far\nfrom = 1.0 # s\n\n[run.log]\nsort = true # why\n\n[[run]]\nfile = 'b.csv'\n\n# at the end\n[fit]\nsegment = 5.0\n";

    #[test]
    fn a_stretch_is_written_in_place_and_comments_stay() {
        let stretch = Stretch { role: Role::Validate, from: Some(2.5), to: Some(9.0) };
        let text = set(TEXT, 0, stretch).unwrap();
        let first = "file = 'a.csv' # the first\nrole = \"validate\" # so far\nfrom = 2.5 # s\nto = 9.0\n\n[run.log]";
        assert!(text.contains(first), "{text}");
        let whole = set(&text, 0, Stretch { role: Role::Train, from: None, to: None }).unwrap();
        assert!(whole.contains("role = \"train\" # so far\n\n[run.log]\nsort = true # why"), "{whole}");
        assert_eq!(set(TEXT, 2, stretch).unwrap_err().status, 404);
    }

    #[test]
    fn a_further_stretch_stands_behind_its_log_with_its_options() {
        let text = add(TEXT, 0, Stretch { role: Role::Validate, from: Some(4.0), to: None }).unwrap();
        let read: toml::Table = toml::from_str(&text).unwrap();
        let runs = read["run"].as_array().unwrap();
        assert_eq!(runs.len(), 3);
        assert_eq!(runs[1]["from"].as_float(), Some(4.0));
        assert_eq!(runs[1]["log"], runs[0]["log"]);
        assert_eq!(runs[2]["file"].as_str(), Some("b.csv"));
        assert!(text.find("# at the end") > text.find("b.csv"), "{text}");
        let back = remove(&text, 1).unwrap();
        assert_eq!(toml::from_str::<toml::Table>(&back).unwrap(), toml::from_str::<toml::Table>(TEXT).unwrap());
        assert!(back.contains("# the first") && back.contains("# at the end"));
    }

    #[test]
    fn runs_of_new_logs_bring_their_options_where_they_are_others() {
        let new = "format = 1\n[log]\n# guessed: semicolons\ndelimiter = ';'\n[[run]]\nfile = 'c.csv' # 9 rows\n";
        let text = append(TEXT, new).unwrap();
        let read: toml::Table = toml::from_str(&text).unwrap();
        assert_eq!(read["run"][2]["log"]["delimiter"].as_str(), Some(";"), "{text}");
        assert!(text.contains("# guessed: semicolons") && text.contains("# 9 rows"), "{text}");
        let alike = append("[log]\ndelimiter = ';'\n", new).unwrap();
        assert!(!alike.contains("[run.log]"), "{alike}");
        let first = append("format = 1\n[vehicle]\nname = 'x'\n", "[[run]]\nfile = 'c.csv'\n").unwrap();
        assert_eq!(toml::from_str::<toml::Table>(&first).unwrap()["run"][0]["file"].as_str(), Some("c.csv"));
    }
}
