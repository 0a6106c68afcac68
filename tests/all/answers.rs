//! Form of every answer on a terminal of 80 columns: a verdict of at most three lines, one table,
//! the next command.

use std::path::PathBuf;
use std::process::{Command, Output};

use hydrosysid::tank::{BlindOptions, CraftKind, Hidden, write_blind};

/// Width of the terminal into which all answers must fit.
pub(crate) const COLUMNS: usize = 80;

/// A campaign of the tank whose model lacks the Munk moment, in a folder that is removed with it.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Folder {
        Folder::of_runs(name, CraftKind::Small, 40.0)
    }

    /// The same with another vehicle and runs of `duration` seconds.
    fn of_runs(name: &str, craft: CraftKind, duration: f64) -> Folder {
        let path = std::env::temp_dir().join(format!("hydrosysid-answers-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&path);
        let options = BlindOptions {
            duration,
            craft,
            hidden: vec![Hidden::new("coriolis_yaw".to_string(), 1.0)],
            ..BlindOptions::default()
        };
        write_blind(&path, &options).expect("the tank sails");
        Folder(path)
    }

    fn run(&self, words: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_hydrosysid"));
        command.args(words).current_dir(&self.0).env("COLUMNS", COLUMNS.to_string()).env("NO_COLOR", "1");
        command.output().expect("the command starts")
    }

    /// Standard output of a call that must succeed.
    fn told(&self, words: &[&str]) -> String {
        let output = self.run(words);
        assert!(output.status.success(), "{words:?}: {}", text(&output.stderr));
        text(&output.stdout)
    }

    fn write(&self, name: &str, content: &str) {
        std::fs::write(self.0.join(name), content).expect("the folder can be written");
    }

    fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.0.join(name)).expect("the file is there")
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Lines before the first table; a table has a ruled line under its headers.
fn before_the_table(told: &str) -> Vec<&str> {
    // the caption of a matrix belongs to it
    let lines: Vec<&str> = told.lines().filter(|line| !line.starts_with("rms error in ")).collect();
    let rule = lines.iter().position(|line| line.contains("───"));
    lines[..rule.map_or(lines.len(), |at| at - 1)].to_vec()
}

pub(crate) fn holds_the_form(words: &[&str], told: &str) {
    let wide: Vec<&str> = told.lines().filter(|line| line.chars().count() > COLUMNS).collect();
    assert!(wide.is_empty() || wide.iter().all(|line| line.starts_with("next: ")), "{words:?}: {wide:#?}\n{told}");
    let first = before_the_table(told);
    let warnings = first.iter().filter(|line| line.starts_with("warning: ") || line.starts_with("error: ")).count();
    assert!(warnings <= 2, "{words:?}: {first:#?}");
    let verdict = first.len() - warnings;
    assert!((1..=3).contains(&verdict), "{words:?}: a verdict of {verdict} lines\n{told}");
    assert!(first[0].chars().any(char::is_alphabetic), "{words:?}: {told}");
    let last = told.lines().last().unwrap_or_default();
    assert!(last.starts_with("next: hydrosysid "), "{words:?}: {told}");
    // one screen
    assert!(told.lines().count() <= 45, "{words:?}: {} lines\n{told}", told.lines().count());
    assert!(told.matches("───").count() > 0 && tables(told) <= 1, "{words:?}: {} tables\n{told}", tables(told));
}

fn tables(told: &str) -> usize {
    told.lines().filter(|line| !line.is_empty() && line.chars().all(|c| c == '─' || c == ' ')).count()
}

#[test]
fn every_verb_answers_in_a_verdict_a_table_and_the_next_command() {
    let folder = Folder::new("form");
    let fitted = folder.told(&["fit", ".", "--model", "model.toml"]);
    holds_the_form(&["fit"], &fitted);
    assert!(fitted.contains("written: model.toml"), "{fitted}");
    // warnings are on standard error only
    assert!(!fitted.contains("warning: "), "{fitted}");
    let mut other = folder.read("model.toml");
    other = other.replacen("value = ", "value = 1", 1);
    folder.write("other.toml", &other);
    let limits = ["--limit", "surge=20", "--limit", "sway=20", "--limit", "yaw=2"];
    let plan = [&["plan", "model.toml", "--want", "0.1%"], &limits[..]].concat();
    let verbs: [&[&str]; 12] = [
        &["check", "."],
        &["check", "run00.csv"],
        &["simulate", ".", "--model", "model.toml"],
        &["compare", ".", "--model", "model.toml"],
        &["compare", ".", "--cross"],
        &["compare", "model.toml", "other.toml"],
        &["discover", "."],
        &plan,
        &["monitor", "model.toml", "run05.csv"],
        &["effects", "--search", "drag"],
        &["vehicles"],
        &["export"],
    ];
    for words in verbs {
        holds_the_form(words, &folder.told(words));
    }
    // each answer names the measure by which it chooses a run
    let told = |verb: &str| folder.told(&[verb, ".", "--model", "model.toml"]);
    // independent of line breaks
    let [simulated, compared] =
        ["simulate", "compare"].map(|verb| told(verb).split_whitespace().collect::<Vec<_>>().join(" "));
    assert!(simulated.contains("relative to the motion"), "{simulated}");
    assert!(["the predicted error", "the noise of its sensor"].iter().any(|m| compared.contains(m)), "{compared}");
    // without a table: the page is the answer
    let told = folder.told(&["report", ".", "-o", "page.html"]);
    assert!(told.lines().all(|line| line.chars().count() <= COLUMNS), "{told}");
    assert!(
        told.contains("written: page.html") && told.lines().last().is_some_and(|l| l.starts_with("next: hydrosysid"))
    );
    // a verb that makes a file says so and names the next command
    let made: [&[&str]; 4] = [
        &["init", "run00.csv", "run01.csv", "--name", "own", "-o", "own"],
        &["convert", "run00.csv", "-o", "plain.csv"],
        &["export", "model.toml", "--to", "csv", "-o", "parameters.csv"],
        &["effects", "coriolis_yaw"],
    ];
    for words in made {
        let told = folder.told(words);
        assert!(told.lines().all(|line| line.chars().count() <= COLUMNS), "{words:?}: {told}");
        assert!(told.lines().last().is_some_and(|line| line.starts_with("next: hydrosysid ")), "{words:?}: {told}");
        assert_eq!(told.matches("hydrosysid").count(), 1, "{words:?}: {told}");
    }
    // on standard output there is only the data
    for words in [&["export", "model.toml", "--to", "csv"][..], &["export", "model.toml", "--to", "csv", "-o", "-"]] {
        assert_eq!(folder.told(words), folder.read("parameters.csv"), "{words:?}");
    }
    assert_eq!(folder.told(&["convert", "run00.csv", "-o", "-"]), folder.read("plain.csv"));
    // the meaning of a code is not a table either
    let told = folder.told(&["explain", "M144"]);
    assert!(told.lines().count() > 3 && told.lines().all(|line| line.chars().count() <= COLUMNS), "{told}");
    // -v shows the long tables
    for words in [&["fit", "."][..], &["compare", ".", "--model", "model.toml"], &["check", "."], &["discover", "."]] {
        let long = folder.told(&[words, &["-v"]].concat());
        assert!(tables(&long) > 1, "{words:?} -v: {long}");
    }
}

#[test]
fn a_clean_check_is_one_line_a_log_and_one_in_all() {
    // long enough that every run excites the degrees of freedom that it moves
    let folder = Folder::of_runs("clean", CraftKind::Large, 90.0);
    let told = folder.told(&["check", "."]);
    let lines: Vec<&str> = told.lines().collect();
    assert!(lines[0].starts_with("green: nothing in 9 logs"), "{told}");
    // verdict, headers, rule, nine logs, next
    assert_eq!(lines.len(), 13, "{told}");
    assert!(lines[3..12].iter().all(|line| line.contains("green")), "{told}");
    assert_eq!(lines[12], "next: hydrosysid fit .");
    let errors = told.matches("error").count();
    assert_eq!(errors, 0, "{told}");
}

#[test]
fn thrusters_without_tables_are_one_message() {
    let folder = Folder::new("thrusters");
    // the same runs with voltages instead of forces
    for k in 0..9 {
        let name = format!("run0{k}.csv");
        let mut log = folder.read(&name);
        for (force, voltage) in [("tau_u [N]", "V1 [V]"), ("tau_v [N]", "V2 [V]"), ("tau_r [N*m]", "V3 [V]")] {
            assert!(log.contains(force), "{}", log.lines().next().unwrap_or_default());
            log = log.replacen(force, voltage, 1);
        }
        folder.write(&name, &log);
    }
    let output = folder.run(&["fit", "."]);
    assert_eq!(output.status.code(), Some(1));
    let message = text(&output.stderr);
    assert!(message.contains("V1, V2, V3 have no [[thruster]] table") && message.contains("M003"), "{message}");
    assert!(!message.contains("L010") && message.matches("error").count() == 1, "{message}");
    // a further error of a unit does not hide this one: the likely cause comes first
    for k in 0..9 {
        let name = format!("run0{k}.csv");
        let rows = folder.read(&name);
        let wider =
            rows.lines().enumerate().map(|(i, row)| row.to_string() + if i == 0 { ",tau_p [V]\n" } else { ",0\n" });
        folder.write(&name, &wider.collect::<String>());
    }
    let message = text(&folder.run(&["fit", "."]).stderr);
    let at = |what: &str| message.find(what).unwrap_or_else(|| panic!("{what}: {message}"));
    assert!(at("V1, V2, V3 have no [[thruster]] table") < at("tau_p") && !message.contains("L010"), "{message}");
}

#[test]
fn models_that_differ_beyond_all_chance_have_no_probability_of_nothing() {
    let folder = Folder::new("chance");
    folder.told(&["fit", ".", "--model", "a.toml"]);
    let text = folder.read("a.toml").replacen("value = ", "value = 9", 1);
    folder.write("b.toml", &text);
    let told = folder.told(&["compare", "a.toml", "b.toml", "-v"]);
    assert!(told.starts_with("The models differ: 9 common parameters") && told.contains("p < 1e-15"), "{told}");
    assert!(told.contains("<1e-15") && !told.contains("0.0e0") && !told.contains("p = 0"), "{told}");
}

#[test]
fn pieces_of_a_run_are_marked() {
    let folder = Folder::new("pieces");
    folder.told(&["fit", ".", "--model", "model.toml"]);
    let whole = folder.told(&["compare", ".", "--model", "model.toml"]);
    assert!(!whole.contains('*'), "{whole}");
    // ten seconds without a row
    let log = folder.read("run08.csv");
    let kept = |line: &&str| {
        line.split(',').next().and_then(|t| t.parse::<f64>().ok()).is_none_or(|t| !(15.0..25.0).contains(&t))
    };
    folder.write("run08.csv", &(log.lines().filter(kept).collect::<Vec<_>>().join("\n") + "\n"));
    let told = folder.told(&["compare", ".", "--model", "model.toml", "--json", "c.json"]);
    assert!(told.contains("run08.csv *") && told.contains("* simulated in up to 2 pieces"), "{told}");
    let json: serde_json::Value = serde_json::from_str(&folder.read("c.json")).expect("JSON");
    let pieces = |run: &str| {
        json["runs"].as_array().into_iter().flatten().find(|r| r["run"] == run).map(|r| r["pieces"].clone())
    };
    assert_eq!((pieces("run08.csv"), pieces("run00.csv")), (Some(2.into()), Some(1.into())));
    assert!(json["runs"][0]["piece_length"].is_null());
}

#[test]
fn a_plan_counts_the_data_at_hand_unless_told_not_to() {
    let folder = Folder::new("plan");
    folder.told(&["fit", ".", "--model", "model.toml"]);
    let limits = ["--limit", "surge=20", "--limit", "sway=20", "--limit", "yaw=2"];
    let known = folder.told(&[&["plan", "model.toml", "--want", "50%"], &limits[..]].concat());
    assert!(known.starts_with("Enough already"), "{known}");
    let words = [&["plan", "model.toml", "--want", "50%", "--without-known", "-o", "next"], &limits[..]].concat();
    let alone = folder.told(&words);
    assert!(alone.contains("worst std/wanted"), "{alone}");
    assert!(alone.contains("command histor") && !alone.contains("1 command histories"), "{alone}");
}

/// Each row of `simulate` shows the motion of its own run: not all rows of sway have the same.
#[test]
fn the_motion_beside_an_error_is_that_of_the_run() {
    let folder = Folder::new("motion");
    let told = folder.told(&["simulate", "."]);
    let cells = |row: &str| row.split_whitespace().map(str::to_string).collect::<Vec<String>>();
    let rows: Vec<Vec<String>> = told.lines().map(cells).filter(|c| c[0].starts_with("run0") && c.len() == 7).collect();
    assert_eq!(rows.len(), 9, "{told}");
    let of_sway: std::collections::BTreeSet<&String> = rows.iter().filter(|c| c[3] == "sway").map(|c| &c[5]).collect();
    let sways = rows.iter().filter(|c| c[3] == "sway").count();
    assert!(sways > 1 && of_sway.len() > 1, "{told}");
}

#[test]
fn what_is_not_there_is_told_in_the_same_words() {
    let folder = Folder::new("absent");
    for words in
        [&["plan", "nowhere"][..], &["fit", "nowhere"], &["monitor", "nowhere", "run00.csv"], &["check", "nowhere"]]
    {
        let output = folder.run(words);
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{words:?}: {message}");
        assert!(message.contains("there is no such file") && !message.contains("os error"), "{words:?}: {message}");
    }
    let message = text(&folder.run(&["effects", "nosucheffect"]).stderr);
    assert!(message.contains("the nearest are") && message.contains("hydrosysid effects --search"), "{message}");
}
