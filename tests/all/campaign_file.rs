//! Campaign files on disk: the examples are read, run files are found, and nothing outside the
//! folder is read.

#![allow(clippy::unwrap_used)] // tests, and the small functions they share

use std::fs;
use std::path::{Path, PathBuf};

use hydrosysid::campaign::file::{CampaignErrors, CampaignFile, ModelTable, Problem, ReadOptions, RunFile, RunTable};
use hydrosysid::frame::Dof;
use hydrosysid::run::Role;

use crate::shared;

/// An empty folder for one test.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    if folder.exists() {
        fs::remove_dir_all(&folder).unwrap();
    }
    fs::create_dir_all(folder.join("campaign")).unwrap();
    folder
}

fn campaign(files: &[&str]) -> String {
    let model = ModelTable {
        dofs: vec![Dof::Surge],
        effects: vec!["inertia".parse().unwrap(), "linear_drag".parse().unwrap()],
        ..ModelTable::default()
    };
    let run = |file: &&str| RunTable { files: vec![RunFile::from(*file)], ..RunTable::default() };
    CampaignFile { model, runs: files.iter().map(run).collect(), ..CampaignFile::default() }.to_toml().unwrap()
}

fn read(folder: &Path, files: &[&str], allow_outside: bool) -> Result<CampaignFile, CampaignErrors> {
    let path = folder.join("campaign/campaign.toml");
    fs::write(&path, campaign(files)).unwrap();
    CampaignFile::read(&path, &ReadOptions { allow_outside, ..ReadOptions::default() })
}

#[test]
fn the_example_campaigns_read_and_come_back() {
    let Some(examples) = shared::path("example_campaigns") else { return };
    for name in ["munk_hidden", "nothing_hidden"] {
        let path = examples.join(name).join("campaign.toml");
        let campaign = CampaignFile::read(&path, &ReadOptions::default()).unwrap();
        assert_eq!(campaign.runs.len(), 9);
        assert_eq!(campaign.runs.iter().filter(|run| run.role == Role::Validate).count(), 3);
        assert!(campaign.path_of(&campaign.runs[8].files[0]).ends_with("run08.csv"));
        let text = campaign.to_toml().unwrap();
        let again = CampaignFile::from_bytes(text.as_bytes(), &path, &ReadOptions::default()).unwrap();
        assert_eq!(CampaignFile { source: None, ..again }, CampaignFile { source: None, ..campaign });
    }
}

#[test]
fn run_files_are_found_or_named_with_where_they_were_looked_for() {
    let folder = folder("found");
    fs::create_dir(folder.join("campaign/logs")).unwrap();
    fs::write(folder.join("campaign/logs/a.csv"), "t,u\n").unwrap();
    assert!(read(&folder, &["logs/a.csv", "logs/../logs/a.csv"], false).is_ok());
    let errors = read(&folder, &["logs/a.csv", "logs/b.csv", "logs", "logs/a.csv/c"], false).unwrap_err().errors;
    let at = |file: &str| folder.join("campaign").join(file);
    let problems: Vec<&Problem> = errors.iter().map(|e| &e.problem).collect();
    assert_eq!(
        problems,
        [
            &Problem::MissingFile { path: at("logs/b.csv") },
            &Problem::NotAFile { path: at("logs") },
            &Problem::MissingFile { path: at("logs/a.csv/c") },
        ]
    );
    assert_eq!((errors[0].key.as_str(), errors[0].value.as_deref()), ("run[1].file", Some("\"logs/b.csv\"")));
}

#[test]
fn nothing_outside_the_folder_is_read_unless_allowed() {
    let folder = folder("outside");
    let secret = folder.join("secret.csv");
    fs::write(&secret, "t,u\n").unwrap();
    let absolute = secret.to_str().unwrap();
    for file in ["../secret.csv", "../campaign/../secret.csv", absolute, "../no_such.csv"] {
        let errors = read(&folder, &[file], false).unwrap_err().errors;
        assert!(matches!(errors[0].problem, Problem::OutsideFolder { .. }), "{file}: {}", errors[0]);
    }
    assert!(read(&folder, &["../secret.csv", absolute], true).is_ok());
    let errors = read(&folder, &["../no_such.csv"], true).unwrap_err().errors;
    assert!(matches!(errors[0].problem, Problem::MissingFile { .. }), "{}", errors[0]);
}

#[cfg(unix)]
#[test]
fn links_that_lead_out_are_refused() {
    let folder = folder("links");
    fs::write(folder.join("secret.csv"), "t,u\n").unwrap();
    fs::write(folder.join("campaign/a.csv"), "t,u\n").unwrap();
    let link = |from: &str, to: &str| std::os::unix::fs::symlink(from, folder.join("campaign").join(to)).unwrap();
    link("../secret.csv", "out.csv");
    link("..", "up");
    link("a.csv", "within.csv");
    link("nowhere.csv", "dangling.csv");
    assert!(read(&folder, &["within.csv"], false).is_ok());
    for file in ["out.csv", "up/secret.csv"] {
        let errors = read(&folder, &[file], false).unwrap_err().errors;
        assert!(matches!(errors[0].problem, Problem::OutsideFolder { .. }), "{file}: {}", errors[0]);
    }
    let errors = read(&folder, &["dangling.csv"], false).unwrap_err().errors;
    assert!(matches!(errors[0].problem, Problem::MissingFile { .. }), "{}", errors[0]);
}

#[test]
fn a_campaign_that_cannot_be_read_says_so() {
    let folder = folder("unreadable");
    // a folder means the campaign.toml in it
    for (path, named) in [("no.toml", "no.toml"), ("campaign", "campaign/campaign.toml")] {
        let errors = CampaignFile::read(&folder.join(path), &ReadOptions::default()).unwrap_err();
        assert!(matches!(errors.errors[0].problem, Problem::CannotRead { .. }));
        let named = folder.join(named);
        assert!(errors.to_string().starts_with(&format!("{}: cannot be read: ", named.display())), "{errors}");
    }
}
