//! Terminal output of the command: plots, colours, completions, manual page.

use std::path::PathBuf;
use std::process::{Command, Output};

use hydrosysid::tank::{BlindOptions, write_blind};

struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Folder {
        let path = std::env::temp_dir().join(format!("hydrosysid-terminal-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&path);
        Folder(path)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn run(arguments: &[&str], environment: &[(&str, &str)]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hydrosysid"));
    for name in ["NO_COLOR", "CLICOLOR", "CLICOLOR_FORCE"] {
        command.env_remove(name);
    }
    command.args(arguments).envs(environment.iter().copied()).output().expect("the command starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Lines drawn in braille.
fn drawn(text: &str) -> Vec<&str> {
    text.lines().filter(|line| line.chars().any(|c| ('\u{2801}'..='\u{28ff}').contains(&c))).collect()
}

#[test]
fn motions_are_drawn_in_the_terminal_by_choice() {
    let folder = Folder::new("plot");
    write_blind(&folder.0, &BlindOptions { duration: 40.0, ..BlindOptions::default() }).unwrap();
    let file = folder.0.join("campaign.toml").display().to_string();
    let model = folder.0.join("model.toml").display().to_string();
    let plain = run(&["fit", &file, "--model", &model], &[]);
    assert!(plain.status.success(), "{}", text(&plain.stderr));
    assert!(drawn(&text(&plain.stdout)).is_empty(), "nobody asked");
    for verb in ["simulate", "compare"] {
        let output = run(&[verb, &file, "--model", &model, "--plot"], &[]);
        assert!(output.status.success(), "{}", text(&output.stderr));
        let told = text(&output.stdout);
        assert!(!drawn(&told).is_empty() && drawn(&told).iter().all(|line| line.chars().count() <= 80), "{told}");
        assert!(told.contains("run06.csv, surge") && !told.contains("run00.csv, surge"), "those that took no part");
    }
    let one = run(&["fit", &file, "--plot=run00.csv"], &[]);
    let told = text(&one.stdout);
    assert!(told.contains("run00.csv, yaw") && !told.contains("run06.csv, yaw"), "{told}");
    let none = run(&["simulate", &file, "--model", &model, "--plot=run99.csv"], &[]);
    assert_eq!(none.status.code(), Some(2));
    assert!(text(&none.stderr).contains("no such run; there are run00.csv"), "{}", text(&none.stderr));
    let quiet = run(&["simulate", &file, "--model", &model, "--plot", "--json", "-"], &[]);
    assert!(serde_json::from_slice::<serde_json::Value>(&quiet.stdout).is_ok(), "JSON alone on standard output");
}

#[test]
fn every_verb_that_makes_something_tells_it_as_json() {
    let folder = Folder::new("json");
    write_blind(&folder.0, &BlindOptions { duration: 40.0, ..BlindOptions::default() }).unwrap();
    let path = |name: &str| folder.0.join(name).display().to_string();
    let told = |words: &[&str]| -> serde_json::Value {
        let output = run(&[words, &["--json", "-"]].concat(), &[]);
        assert!(output.status.success(), "{words:?}: {}", text(&output.stderr));
        serde_json::from_slice(&output.stdout).expect("JSON alone on standard output")
    };
    let (file, log) = (path("campaign.toml"), path("run00.csv"));
    let made = told(&["init", &log, "-o", &path("new.toml")]);
    assert!(made["campaign"].as_str().is_some_and(|text| text.contains("[vehicle]")));
    let converted = told(&["convert", &log, "-o", &path("plain.csv")]);
    assert_eq!(converted["channels"]["u"]["from"], 0.0);
    let report = told(&["report", &file, "--no-discovery", "-o", &path("page.html")]);
    assert!(report["bytes"].as_u64().is_some_and(|bytes| bytes > 100_000));
    let crossed = told(&["compare", &file, "--cross"]);
    assert!(crossed["models"].as_array().is_some_and(|models| models.len() > 2));
    let own = crossed["crossed"].as_array().into_iter().flatten().find(|c| c["model"] == c["run"]);
    assert!(own.is_some_and(|c| c["mean_abs"].as_f64().is_some_and(|e| e > 0.0 && e < 0.02)), "{own:?}");
}

#[test]
fn colours_are_for_terminals_and_for_who_asks() {
    let coloured = |environment: &[(&str, &str)]| {
        let output = run(&["fit", "nowhere.toml"], environment);
        assert_eq!(output.status.code(), Some(2));
        text(&output.stderr).contains('\u{1b}')
    };
    assert!(!coloured(&[]), "a pipe is no terminal");
    assert!(coloured(&[("CLICOLOR_FORCE", "1")]));
    assert!(!coloured(&[("NO_COLOR", "1")]));
    let told = run(&["fit", "nowhere.toml", "--no-color"], &[("CLICOLOR_FORCE", "1")]);
    assert!(!text(&told.stderr).contains('\u{1b}'), "the option wins");
}

const VERBS: [&str; 17] = [
    "demo",
    "init",
    "check",
    "convert",
    "fit",
    "simulate",
    "compare",
    "discover",
    "plan",
    "monitor",
    "report",
    "view",
    "export",
    "effects",
    "explain",
    "completions",
    "man",
];

#[test]
fn completions_and_the_manual_page_know_every_verb() {
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let output = run(&["completions", shell], &[]);
        assert!(output.status.success());
        let told = text(&output.stdout);
        for verb in VERBS {
            assert!(told.contains(verb), "{shell}: {verb}");
        }
        assert!(told.contains("plot") && told.contains("estimator"), "{shell}: options");
    }
    let page = text(&run(&["man"], &[]).stdout);
    for verb in VERBS {
        assert!(page.contains(&format!("hydrosysid\\-{verb}")), "{verb}");
    }
    assert!(page.contains(".TH hydrosysid") && page.contains("\\-\\-no\\-discovery"));
}

#[test]
fn every_verb_that_takes_arguments_shows_an_example() {
    for verb in VERBS.iter().filter(|v| !["effects", "explain", "completions", "man"].contains(v)) {
        let told = text(&run(&[verb, "--help"], &[]).stdout);
        assert!(told.contains("Example") && told.contains(&format!("hydrosysid {verb}")), "{verb}: {told}");
    }
}
