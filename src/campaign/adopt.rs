//! Effects that were named, written into the text of a campaign: its list `effects` grows, runs that took part in the fit have the
//! role `train`, everything else stays as it stands, comments included.

use std::path::{Path, PathBuf};

use serde::Deserialize;
use thiserror::Error;
use toml::Spanned;

use super::file::{CampaignFile, ReadOptions};
use super::load::names;
use crate::atomic_file;

/// Where a campaign lists the effects of its baseline.
#[derive(Deserialize)]
struct Listing {
    model: ModelListing,
}

#[derive(Deserialize)]
struct ModelListing {
    effects: Spanned<Vec<Spanned<String>>>,
}

/// Where it gives its runs their roles.
#[derive(Deserialize)]
struct Roles {
    #[serde(default)]
    run: Vec<RoleOfRun>,
}

#[derive(Deserialize)]
struct RoleOfRun {
    role: Option<Spanned<String>>,
}

/// Why nothing was adopted.
#[derive(Debug, Error)]
pub enum AdoptError {
    /// Another folder than the campaign's, from which its logs would not be found.
    #[error("{} lies in another folder, and logs are found from there: choose a name beside {}", .to.display(), .campaign.display())]
    Elsewhere {
        /// Where it was to go.
        to: PathBuf,
        /// The campaign.
        campaign: PathBuf,
    },
    /// No campaign.
    #[error("{}: {message}", .file.display())]
    NoCampaign {
        /// The file.
        file: PathBuf,
        /// What it lacks.
        message: String,
    },
    /// A file cannot be read or written.
    #[error("{}: {source}", .file.display())]
    File {
        /// The file.
        file: PathBuf,
        /// Why.
        source: std::io::Error,
    },
}

/// Writes `names` into the effects of `campaign` (or the folder that holds `campaign.toml`), or into `to`, a campaign
/// beside it, which begins as its copy where it does not exist; the runs `training` get the role `train`. Returns the file that was
/// written.
///
/// # Errors
/// [`AdoptError`].
pub fn adopt(campaign: &Path, to: Option<&Path>, names: &[String], training: &[String]) -> Result<PathBuf, AdoptError> {
    let own = CampaignFile::at(campaign);
    let to = to.map_or_else(|| own.clone(), Path::to_path_buf);
    let unusable = |file: &Path| {
        let file = file.to_path_buf();
        move |source| AdoptError::File { file, source }
    };
    let folder = |path: &Path| {
        let parent = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        parent.canonicalize().map_err(unusable(parent))
    };
    if folder(&to)? != folder(&own)? {
        return Err(AdoptError::Elsewhere { to, campaign: own });
    }
    let from = if to.is_file() { &to } else { &own };
    let text = crate::text_file::read(from).map_err(unusable(from))?;
    let adopted = with_effects(&text, names).and_then(|text| with_training(&text, from, training));
    let text = adopted.map_err(|message| AdoptError::NoCampaign { file: from.clone(), message })?;
    atomic_file::write(&to, |file| std::io::Write::write_all(file, text.as_bytes())).map_err(unusable(&to))?;
    Ok(to)
}

/// `text` of a campaign with `names` in its list `effects`; as it is where they stand there already.
///
/// # Errors
/// What `text` lacks to be the text of a campaign.
pub fn with_effects(text: &str, names: &[String]) -> Result<String, String> {
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

/// `text` of the campaign `file` with the role `train` where the runs of these names have another one.
///
/// # Errors
/// What `text` lacks to be the text of a campaign.
pub fn with_training(text: &str, file: &Path, runs: &[String]) -> Result<String, String> {
    let mut text = text.to_string();
    if runs.is_empty() {
        return Ok(text);
    }
    // that it can be worked with was seen when it was searched: its runs have to be told apart, no more
    let options = ReadOptions { look_for_files: false, allow_outside: true, ..ReadOptions::default() };
    let read = CampaignFile::from_bytes(text.as_bytes(), file, &options);
    let named = names(&read.map_err(|e| e.to_string())?.runs);
    let roles: Roles = toml::from_str(&text).map_err(|e| e.message().to_string())?;
    // from the last one on, so that the places of those before stay
    for (_, run) in named.iter().zip(roles.run).filter(|(name, _)| runs.contains(name)).rev().collect::<Vec<_>>() {
        if let Some(role) = run.role {
            text.replace_range(role.span(), "\"train\"");
        }
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::{with_effects, with_training};

    fn with(list: &str, names: &[&str]) -> String {
        let text = format!("# mine\n[model]\ndofs = [\"yaw\"] # one\neffects = {list} # so far\n[fit]\n");
        let names: Vec<String> = names.iter().map(ToString::to_string).collect();
        let text = with_effects(&text, &names).unwrap();
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
    fn runs_that_took_part_have_the_role_train() {
        let text = |a: &str, b: &str| {
            format!(
                "format = 1\n[model]\ndofs = [\"yaw\"]\neffects = [\"inertia\"]\n[[run]]\nfile = \"a.csv\"\n[[run]] # of May\n\
                 role = {a} # judges\nfile = \"b.csv\"\n[[run]]\nfile = \"b.csv\"\nrole = {b}\nfrom = 3.0\n"
            )
        };
        let held_out = text("\"validate\"", "'validate'");
        let with = |runs: &[&str]| {
            let runs: Vec<String> = runs.iter().map(ToString::to_string).collect();
            with_training(&held_out, Path::new("campaign.toml"), &runs).unwrap()
        };
        assert_eq!(with(&[]), held_out);
        assert_eq!(with(&["b.csv #2"]), text("\"validate\"", "\"train\""));
        assert_eq!(with(&["a.csv", "b.csv", "b.csv #2"]), text("\"train\"", "\"train\""));
    }

    #[test]
    fn what_is_no_campaign_is_told() {
        assert!(with_effects("format = 1", &[]).unwrap_err().contains("model"));
    }
}
