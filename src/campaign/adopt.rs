//! Adds named effects to the text of a campaign: extends its list `effects`, sets `input`, and gives
//! the role `train` to runs that took part in the fit. All other text stays as it is, comments
//! included.

use std::path::{Path, PathBuf};

use serde::Deserialize;
use thiserror::Error;
use toml::Spanned;

use super::file::{CampaignFile, ReadOptions};
use super::load::names;
use crate::atomic_file;
use crate::discover::Discovery;
use crate::model::Interpolation;

/// The place of the list `effects` in the text of a campaign.
#[derive(Deserialize)]
struct Listing {
    model: ModelListing,
}

#[derive(Deserialize)]
struct ModelListing {
    effects: Spanned<Vec<Spanned<String>>>,
    input: Option<Spanned<String>>,
}

/// What a search changes in a campaign.
#[derive(Debug, Clone, Copy, Default)]
pub struct Adoption<'a> {
    /// Names to add to the list of effects.
    pub names: &'a [String],
    /// Runs that get the role `train`.
    pub training: &'a [String],
    /// Interpolation of the commands, if it changes.
    pub input: Option<Interpolation>,
}

impl<'a> From<&'a Discovery> for Adoption<'a> {
    fn from(found: &'a Discovery) -> Adoption<'a> {
        Adoption { names: &found.adopt, training: &found.took_part, input: found.input }
    }
}

impl Adoption<'_> {
    /// Whether it changes nothing.
    pub fn is_empty(&self) -> bool {
        self.names.is_empty() && self.training.is_empty() && self.input.is_none()
    }
}

/// The places of the roles of the runs in the text of a campaign.
#[derive(Deserialize)]
struct Roles {
    #[serde(default)]
    run: Vec<RoleOfRun>,
}

#[derive(Deserialize)]
struct RoleOfRun {
    role: Option<Spanned<String>>,
}

/// The reason why nothing was adopted.
#[derive(Debug, Error)]
pub enum AdoptError {
    /// The target is in another folder than the campaign, and would not find its logs from there.
    #[error(
        "{} lies in another folder, but logs are located relative to the campaign: choose a name next to {}",
        .to.display(), .campaign.display()
    )]
    Elsewhere {
        /// The requested target.
        to: PathBuf,
        /// The campaign.
        campaign: PathBuf,
    },
    /// The file is not a campaign.
    #[error("{}: {message}", .file.display())]
    NoCampaign {
        /// The file.
        file: PathBuf,
        /// What the file lacks.
        message: String,
    },
    /// A file cannot be read or written.
    #[error("{}: {source}", .file.display())]
    File {
        /// The file.
        file: PathBuf,
        /// The cause.
        source: std::io::Error,
    },
}

/// Writes `what` into `campaign` (or the folder that holds `campaign.toml`), or into `to`, a campaign
/// in the same folder; if `to` does not exist, it begins as a copy. Returns the file that was
/// written.
///
/// # Errors
/// [`AdoptError`].
pub fn adopt(campaign: &Path, to: Option<&Path>, what: &Adoption<'_>) -> Result<PathBuf, AdoptError> {
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
    let adopted = with_effects(&text, what.names)
        .and_then(|text| with_input(&text, what.input))
        .and_then(|text| with_training(&text, from, what.training));
    let text = adopted.map_err(|message| AdoptError::NoCampaign { file: from.clone(), message })?;
    atomic_file::write(&to, |file| std::io::Write::write_all(file, text.as_bytes())).map_err(unusable(&to))?;
    Ok(to)
}

/// Returns `text` of a campaign with `names` added to its list `effects`; names that it has already
/// are not added again.
///
/// # Errors
/// A message with what `text` lacks to be the text of a campaign.
pub fn with_effects(text: &str, names: &[String]) -> Result<String, String> {
    let listing: Listing = toml::from_str(text).map_err(|e| e.message().to_string())?;
    let effects = listing.model.effects;
    let there: Vec<&str> = effects.get_ref().iter().map(|name| name.get_ref().as_str()).collect();
    let new: Vec<&String> = names.iter().filter(|name| !there.contains(&name.as_str())).collect();
    let listed = effects.get_ref();
    let after = listed.last().map_or(effects.span().start + 1, |last| last.span().end);
    // a list with one name per line continues with that layout
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

/// Returns `text` of a campaign with `input` in its table `model`, unless that is `None`.
///
/// # Errors
/// A message with what `text` lacks to be the text of a campaign.
pub fn with_input(text: &str, input: Option<Interpolation>) -> Result<String, String> {
    let Some(input) = input else { return Ok(text.to_string()) };
    let Listing { model } = toml::from_str(text).map_err(|e| e.message().to_string())?;
    let value = format!("{:?}", input.name());
    let mut text = text.to_string();
    match model.input {
        Some(there) => text.replace_range(there.span(), &value),
        // before the list of effects, whose line is the only one that every campaign has there
        None => {
            let line = text[..model.effects.span().start].rfind('\n').map_or(0, |end| end + 1);
            text.insert_str(line, &format!("input = {value}\n"));
        }
    }
    Ok(text)
}

/// Returns `text` of the campaign `file` with the role `train` for those of `runs` that have
/// another role.
///
/// # Errors
/// A message with what `text` lacks to be the text of a campaign.
pub fn with_training(text: &str, file: &Path, runs: &[String]) -> Result<String, String> {
    let mut text = text.to_string();
    if runs.is_empty() {
        return Ok(text);
    }
    // the search has shown already that the campaign can be used: here its runs only need their
    // names
    let options = ReadOptions { look_for_files: false, allow_outside: true, ..ReadOptions::default() };
    let read = CampaignFile::from_bytes(text.as_bytes(), file, &options);
    let named = names(&read.map_err(|e| e.to_string())?.runs);
    let roles: Roles = toml::from_str(&text).map_err(|e| e.message().to_string())?;
    // from the last run to the first, so that the places of the earlier roles stay valid
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

    use super::{with_effects, with_input, with_training};
    use crate::model::Interpolation;

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
    fn the_interpolation_is_set_where_it_stands_or_beside_the_effects() {
        let with = |text: &str, input| with_input(text, input).unwrap();
        let (held, lines) = (Some(Interpolation::Hold), Some(Interpolation::Linear));
        let set = |input: &str| format!("[model]\ninput = {input} # of init\neffects = [] # none\n");
        assert_eq!(with(&set("'hold'"), lines), set("\"linear\""));
        assert_eq!(with(&set("'hold'"), None), set("'hold'"));
        let unset = "[model]\ndofs = [\"yaw\"]\neffects = []\n";
        assert_eq!(with(unset, held), "[model]\ndofs = [\"yaw\"]\ninput = \"hold\"\neffects = []\n");
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
