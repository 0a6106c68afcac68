//! The page on results describes every key that a verb writes as JSON.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

use hydrosysid::frame::Dof;
use hydrosysid::tank::{BlindOptions, Hidden, write_blind};
use serde_json::Value;

struct Folder(PathBuf);

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Collects the keys of all tables in `value`, except names of channels, degrees of freedom and terms.
fn keys(value: &Value, found: &mut BTreeSet<String>) {
    match value {
        Value::Object(table) => {
            for (key, inner) in table {
                let channel = ["u", "v", "w", "p", "q", "r", "x", "y", "z", "phi", "theta", "psi", "supply_V"];
                let named = channel.contains(&key.as_str()) || Dof::from_name(key).is_some() || key.starts_with("tau_");
                if !named && !key.contains([' ', '@']) {
                    found.insert(key.clone());
                }
                keys(inner, found);
            }
        }
        Value::Array(list) => list.iter().for_each(|inner| keys(inner, found)),
        _ => {}
    }
}

#[test]
fn the_page_on_results_knows_every_key() {
    let folder = Folder(std::env::temp_dir().join(format!("hydrosysid-results-{}", std::process::id())));
    let hidden = vec![Hidden::new("coriolis_yaw", 1.0)];
    write_blind(&folder.0, &BlindOptions { duration: 40.0, hidden, ..BlindOptions::default() }).unwrap();
    let path = |name: &str| folder.0.join(name).display().to_string();
    let (file, model, other, log) = (path("campaign.toml"), path("model.toml"), path("other.toml"), path("run00.csv"));
    let params = path("params.toml");
    std::fs::write(&params, "format = 1\nconvention = \"sname\"\n[parameters]\n\"X_u|u|\" = -200.0\n").unwrap();
    let (page, exported, plain) = (path("page.html"), path("linear.json"), path("plain.csv"));
    let calls: [&[&str]; 18] = [
        &["fit", &file, "--model", &model, "--thorough", "--bootstrap", "5"],
        &["fit", &file, "--model", &other, "--estimator", "integral", "--thorough"],
        &["simulate", &file, "--model", &model],
        &["compare", &file, "--model", &model],
        &["compare", &file, "--cross"],
        &["compare", &file, "--model", &model, "--params", &params],
        &["compare", &model, &other],
        &["discover", &file],
        &["plan", &other, "--limit", "surge=100", "--limit", "sway=60", "--limit", "yaw=40", "--most", "1"],
        &["monitor", &other, &log, "--window", "5"],
        &["monitor", &model, &log],
        &["check", &file],
        &["convert", &log, "-o", &plain],
        &["report", &file, "--no-discovery", "-o", &page],
        &["export", &model, "--to", "linear-json", "-o", &exported],
        &["export"],
        &["effects"],
        &["explain"],
    ];
    let mut found = BTreeSet::new();
    for words in calls {
        let output = Command::new(env!("CARGO_BIN_EXE_hydrosysid")).args(words).args(["--json", "-"]).output().unwrap();
        assert!(output.status.success(), "{words:?}: {}", String::from_utf8_lossy(&output.stderr));
        keys(&serde_json::from_slice(&output.stdout).expect("JSON alone on standard output"), &mut found);
    }
    assert!(found.len() > 100, "{found:?}");
    let book = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/results.md");
    let told = std::fs::read_to_string(book).unwrap();
    let absent: Vec<&String> = found.iter().filter(|key| !told.contains(&format!("`{key}`"))).collect();
    assert!(absent.is_empty(), "docs/results.md does not know {absent:?}");
}
