//! The book in `docs/` agrees with the program: its lists are those of the program, its links lead
//! to existing pages, and the commands of the tutorial run as printed.
//!
//! `HYDROSYSID_WRITE_BOOK=1 cargo test --test all book` rewrites the lists.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use hydrosysid::campaign::codes;
use hydrosysid::effects::{Coriolis, Effect, Place, Scope, catalogue, common_name};
use hydrosysid::export::{self, Target};
use hydrosysid::finding::Severity;
use hydrosysid::frame::Dof;
use hydrosysid::model::places_of;

use crate::answers;

fn book() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("docs")
}

/// Compares a page that the program generates with the one in the book, or writes it when asked for.
fn is_in_step(page: &str, written: &str) {
    let path = book().join(page);
    if std::env::var_os("HYDROSYSID_WRITE_BOOK").is_some() {
        std::fs::write(&path, written).expect("the book can be written");
    }
    let there = std::fs::read_to_string(&path).expect("a page of the book");
    assert!(there == written, "{page} is out of step: HYDROSYSID_WRITE_BOOK=1 cargo test --test all book");
}

fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}

fn places(scope: Scope) -> String {
    let names = |list: &[Dof]| list.iter().map(|d| d.name()).collect::<Vec<_>>().join(", ");
    match scope {
        Scope::Each(list) if list.len() == Dof::ALL.len() => "`@dof`, each".into(),
        Scope::Each(list) => format!("`@dof`: {}", names(list)),
        Scope::Pairs => "`@dof:other`".into(),
        Scope::Couples(list) => list.iter().map(|(i, j)| format!("`@{i}:{j}`")).collect::<Vec<_>>().join(", "),
        Scope::Vehicle(list) => format!("the vehicle, with {}", names(list)),
        Scope::VehicleAny(sets) => {
            format!("the vehicle, with {}", sets.iter().map(|set| names(set)).collect::<Vec<_>>().join(" or "))
        }
        Scope::Everywhere => "the vehicle".into(),
        Scope::Thrusters => "thrusters that a campaign describes: `@T6` one, `@T2:T5` two of one curve, or all".into(),
    }
}

fn symbols(effect: &dyn Effect) -> String {
    let first = places_of(effect, &Dof::ALL).first().copied().unwrap_or(Place::VEHICLE);
    let told = effect.parameters(first).into_iter().map(|p| {
        let shape = if p.is_linear() { "" } else { ", shape" };
        format!("`{}` [{}{shape}]", p.name, p.dimension)
    });
    told.collect::<Vec<_>>().join(", ")
}

#[test]
fn the_catalogue_is_that_of_the_program() {
    let mut page = String::from(
        "# The catalogue of effects\n\nAn effect is named `id@dof`, or `id@dof:other` where it couples two; those of the whole \
         vehicle have no dof, and\nthose of single thrusters have their names: `thruster_loss@T6`. A *shape* parameter enters non-linearly. Symbols are those of the first place where the effect can \
         stand.\n",
    );
    let all = catalogue(Coriolis::Free);
    let mut family = "";
    for effect in &all {
        let about = effect.about();
        if about.family.name() != family {
            family = about.family.name();
            write!(page, "\n## {}{}\n", family[..1].to_uppercase(), &family[1..]).unwrap();
        }
        write!(
            page,
            "\n### `{}`, {}\n\n`{}`\n\n{} Parameters: {}. Where: {}. Shown by {}.\nSource: {}.\n",
            about.id,
            common_name(about.id),
            about.formula,
            about.meaning,
            symbols(effect.as_ref()),
            places(about.scope),
            about.shown_by,
            about.source
        )
        .unwrap();
    }
    is_in_step("effects.md", &page);
}

#[test]
fn the_warnings_are_those_of_the_program() {
    let mut page = String::from(
        "# Every warning and what to do\n\nA code stands in every finding, in tables and in JSON; `hydrosysid explain CODE` \
         tells one of them. An *error* means that\nthe work was not done; a *warning* that the result may not mean what it seems \
         to; a *note* is worth knowing.\n\n| code | kind | severity | meaning |\n|---|---|---|---|\n",
    );
    let mut all: Vec<_> = codes::everywhere().chain(export::codes::ALL).collect();
    all.sort_by_key(|c| c.code);
    for code in all {
        let severity = match code.severity {
            Severity::Error => "error",
            Severity::Warning => "warning",
            Severity::Note => "note",
        };
        writeln!(page, "| {} | {} | {severity} | {} |", code.code, code.kind, cell(code.meaning)).unwrap();
    }
    is_in_step("warnings.md", &page);
}

/// The page of commands is the help of every verb, with the shared options given once.
#[test]
fn the_commands_are_those_of_the_program() {
    const SHARED: &str = "Options of every verb:";
    let help = |words: &[&str]| {
        let run = Command::new(env!("CARGO_BIN_EXE_hydrosysid")).args(words).arg("--help").output().unwrap();
        String::from_utf8(run.stdout).unwrap()
    };
    let whole = help(&[]);
    let listed = whole.split("Commands:\n").nth(1).and_then(|rest| rest.split("\n\n").next()).unwrap();
    let verbs = listed.lines().filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    let verbs: Vec<&str> =
        verbs.filter_map(|line| line.split_whitespace().next()).filter(|verb| *verb != "help").collect();
    assert!(verbs.len() > 14, "{verbs:?}");
    let mut page = format!(
        "# The command\n\nWritten from the program's own help. What each verb writes with `--json` stands in [Results](results.md).\n\n\
         ```text\n{}\n```\n",
        whole.trim_end()
    );
    for verb in verbs {
        let told = help(&[verb]);
        // all paragraphs except those of the shared options
        let mut kept: Vec<&str> = Vec::new();
        let mut shared = false;
        for part in told.trim_end().split("\n\n") {
            let heading = !part.starts_with(' ');
            shared = if heading { part.starts_with(SHARED) } else { shared };
            if !shared {
                kept.push(part);
            }
        }
        write!(page, "\n## `{verb}`\n\n```text\n{}\n```\n", kept.join("\n\n")).unwrap();
    }
    assert_eq!(page.matches(SHARED).count(), 1, "the shared options stand once");
    is_in_step("commands.md", &page);
}

/// The table of exports has every target and no other. The differences that it quotes are checked elsewhere
/// (`exported/quoted.rs`, `test_consumers.py`).
#[test]
fn the_table_of_exports_is_that_of_the_program() {
    let rows = crate::exported::quoted::rows();
    let named: Vec<&str> = rows.iter().flat_map(|(names, _)| names.iter().map(String::as_str)).collect();
    for target in Target::ALL {
        assert_eq!(named.iter().filter(|name| **name == target.name()).count(), 1, "{}", target.name());
    }
    for (names, cells) in &rows {
        assert!(names.iter().all(|name| Target::from_name(name).is_some()), "{names:?}");
        assert!(cells.len() == 3 && cells.iter().all(|cell| !cell.is_empty()), "{names:?}: {cells:?}");
    }
}

#[test]
fn every_link_of_the_book_leads_to_a_page() {
    for entry in std::fs::read_dir(book()).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|e| e != "md") {
            continue;
        }
        let text = std::fs::read_to_string(&path).unwrap();
        for target in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            if !target.contains("://") && !target.starts_with('#') {
                let page = target.split('#').next().unwrap_or(target);
                assert!(book().join(page).exists(), "{}: {target}", path.display());
            }
        }
    }
}

/// The shell blocks of the tutorial run in order in one folder, print what the tutorial shows, and
/// make the files that it names.
#[test]
fn the_commands_of_the_tutorial_run_as_they_stand() {
    let text = std::fs::read_to_string(book().join("tutorial.md")).unwrap();
    let blocks: Vec<&str> = text.split("```sh\n").skip(1).filter_map(|rest| rest.split("```").next()).collect();
    assert!(blocks.len() > 5, "the tutorial has commands");
    let folder = std::env::temp_dir().join(format!("hydrosysid-tutorial-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let command = Path::new(env!("CARGO_BIN_EXE_hydrosysid")).parent().unwrap();
    let path = format!("{}:{}", command.display(), std::env::var("PATH").unwrap_or_default());
    let shell = |script: &str, columns: Option<usize>| {
        let mut shell = Command::new("sh");
        shell.args(["-e", "-c", script]).current_dir(&folder).env("PATH", &path).env("NO_COLOR", "1");
        let run = shell.envs(columns.map(|columns| ("COLUMNS", columns.to_string()))).output().unwrap();
        assert!(
            run.status.success(),
            "{}\n{}",
            String::from_utf8_lossy(&run.stderr),
            String::from_utf8_lossy(&run.stdout)
        );
        run
    };
    let commands = blocks.concat();
    let (demo, rest) = commands.split_once('\n').unwrap();
    assert!(demo.starts_with("hydrosysid demo "), "{demo}");
    let shown = shell(demo, Some(answers::COLUMNS)).stdout;
    let shown = String::from_utf8_lossy(&shown);
    answers::holds_the_form(&["demo"], &shown);
    assert!(shown.starts_with("Hidden and found again: the Munk moment (coriolis_yaw)."), "{shown}");
    for row in ["random  yaw    rms", "steady  surge  k_u|u|"] {
        assert!(shown.contains(row), "{row}: {shown}");
    }
    let run = shell(rest, None);
    let told = String::from_utf8_lossy(&run.stderr).into_owned();
    let words = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    let printed = words(&(String::from_utf8_lossy(&run.stdout).into_owned() + &told));
    for shown in text.split("```text\n").skip(1).filter_map(|rest| rest.split("```").next()).flat_map(str::lines) {
        assert!(printed.contains(&words(shown)), "the tutorial shows what is not printed: {shown}");
    }
    let found = std::fs::read_to_string(folder.join("discovery.json")).unwrap();
    assert!(found.contains("\"verdict\": \"explained\"") && found.contains("coriolis_yaw"), "what the tutorial tells");
    for file in ["report.html", "better.toml", "next/plan.toml", "vehicle.sdf", "own/campaign.toml"] {
        assert!(folder.join(file).exists(), "{file}");
    }
    std::fs::remove_dir_all(&folder).unwrap();
}
