//! Options mean what they say: each one at its documented default, written out, changes nothing, and at another value
//! changes what comes out.

use std::collections::BTreeSet;
use std::path::PathBuf;

use hydrosysid::campaign::{Campaign, FitOptions, LoadOptions, fit};
use hydrosysid::log::{self, LogOptions};
use hydrosysid::procedure::StagedOptions;
use hydrosysid::run::RunKind;
use hydrosysid::tank::{BlindOptions, blind, paper_campaign};

use crate::table;

/// An option: its key, its default and another value as TOML, and what else has to be said for it to matter.
struct Case {
    key: &'static str,
    default: &'static str,
    other: String,
    beside: &'static str,
}

fn case(key: &'static str, default: &'static str, other: impl Into<String>) -> Case {
    Case { key, default, other: other.into(), beside: "" }
}

impl Case {
    fn beside(self, text: &'static str) -> Case {
        Case { beside: text, ..self }
    }

    /// Holds the outcome of the default to that of silence, and that of the other value away from it.
    fn holds(&self, outcome: impl Fn(&str) -> String) {
        let Case { key, default, other, beside } = self;
        let with = |value: &str| outcome(&format!("{beside}\n{key} = {value}"));
        let silent = outcome(beside);
        if !default.is_empty() {
            assert_eq!(with(default), silent, "{key} = {default} is the default");
        }
        assert_ne!(with(other), silent, "{key} = {other} says something else");
    }
}

/// Keys of a table, those in tables of it with their path.
fn keys(table: &toml::Table, path: &str, found: &mut BTreeSet<String>) {
    for (key, value) in table {
        let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
        match value {
            toml::Value::Table(inner) if !["filter", "rates", "columns"].contains(&key.as_str()) => {
                keys(inner, &path, found);
            }
            _ => drop(found.insert(path)),
        }
    }
}

#[test]
fn reading_options_mean_what_they_say() {
    // one log in which every option finds something: a gap in it, a code, a repeated stamp, a short last row, a comment
    const LOG: &str =
        "t,u,v,psi,V1\n#1\n0,1,1,0.1,1\n0.1,,2,0.2,2\n0.2,3,-99,0.3,3\n0.2,3,-99,0.3,3\n0.1,1,1,0.1,1\n0.4,4,4";
    // w is written twice for each of its samples
    let row = |k: i32| {
        let x = 0.1 * f64::from(k);
        format!("{k},{:.6},{:.6},{:.6},{:.6}\n", x.sin(), x.cos(), 0.1 * x, (0.2 * f64::from(k / 2)).sin())
    };
    let plain = "t,u,v,psi,w\n".to_string() + &(0..60).map(row).collect::<String>();
    let cases = [
        case("delimiter", "','", "';'"),
        case("decimal", "'.'", "','").beside("delimiter = ';'"),
        case("comment", "", "'#'"),
        case("columns", "{}", "{ u = 'v', v = 'u' }"),
        case("time_unit", "'s'", "'ms'"),
        case("time_format", "", "'iso8601'"),
        case("missing", "'error'", "'no_sample'"),
        case("missing_values", "[]", "['2']").beside("missing = 'no_sample'"),
        case("repeated", "'sample'", "'no_sample'"),
        case("duplicates", "'error'", "'first'"),
        case("sort", "false", "true"),
        case("truncated", "'error'", "'drop'"),
        case("body_frame", "'frd'", "'flu'"),
        case("earth_frame", "'ned'", "'enu'"),
        case("max_line_bytes", "1048576", "5"),
        case("max_columns", "10000", "2"),
    ];
    for case in &cases {
        case.holds(|options| {
            let options: LogOptions = toml::from_str(options).expect("they are options");
            let outcome = |text: &str| format!("{:?}", log::read_from(text.as_bytes(), "log", &options, &["t", "u"]));
            [LOG, &plain, &plain.replace(',', ";")].map(outcome).join("\n")
        });
    }
    // the two that say what a channel is measured against are a campaign's business
    let of_campaigns = ["position_source", "velocity_reference"];
    let full = "comment = '#'\ntime_unit = 's'\ntime_format = 'iso8601'\nmissing_values = ['x']\nposition_source = 'independent'\n\
                velocity_reference = 'water'\ncolumns.u = 'v'";
    let mut all = BTreeSet::new();
    let options: LogOptions = toml::from_str(full).expect("they are options");
    keys(&toml::Table::try_from(options).expect("they are TOML"), "", &mut all);
    let held: BTreeSet<String> = cases.iter().map(|c| c.key).chain(of_campaigns).map(str::to_string).collect();
    assert_eq!(held, all);
}

#[test]
fn options_of_the_stages_mean_what_they_say() {
    let campaign = paper_campaign(1000, 1.0).expect("the tank sails");
    let steady = campaign.runs.iter().find(|r| r.kind == RunKind::ConstantVelocity).expect("there is one");
    let window = format!("[{{ run = {:?}, from = 20.0, to = 30.0 }}]", steady.name);
    let filter = "{ window = { samples = 9 }, degree = 2 }";
    let cases = [
        case("bollard.skip", "false", "true"),
        case("bollard.least_force", "0.0", "40.0"),
        case("bollard.steady_part", "0.5", "0.2"),
        case("steady.skip", "false", "true"),
        case("steady.steady_part", "0.5", "0.3"),
        case("steady.drift", "0.04", "0.01"),
        case("steady.scatter", "0.08", "0.02"),
        case("steady.length", "6.0", "12.0"),
        case("steady.windows", "[]", window),
        case("steady.per_direction", "true", "false"),
        case("steady.pitch", "'logged'", "'moments'"),
        case("steady.drag_height", "0.0", "0.1").beside("steady.pitch = 'moments'"),
        case("oscillatory.skip", "false", "true"),
        case("oscillatory.filter", "", filter),
        case("oscillatory.window", "1", "4"),
        case("oscillatory.hold_drag", "true", "false"),
        case("oscillatory.per_run", "true", "false"),
        case("zigzag.skip", "false", "true"),
        case("zigzag.filter", "", filter),
        case("zigzag.window", "1", "4"),
        case("zigzag.hold_drag", "true", "false"),
        case("zigzag.per_run", "true", "false"),
        case("zigzag.align", "'linear'", "'previous'"),
        case("direct.skip", "true", "false"),
        case("direct.filter", "{ window = { samples = 7 }, degree = 2 }", filter).beside("direct.skip = false"),
        case("std", "'hac'", "'paper'"),
    ];
    for case in &cases {
        case.holds(|options| {
            let options: StagedOptions = toml::from_str(options).expect("they are options");
            format!("{:?}", table::fit(&campaign, &options).stages)
        });
    }
    let full = format!(
        "std = 'paper'\nrates = {filter}\n[bollard]\nskip = true\n[steady]\nwindows = [{{ run = 'a', from = 0.0, to = 1.0 }}]\n\
         [oscillatory]\nfilter = {filter}\n[zigzag]\nfilter = {filter}\n[direct]\nskip = false"
    );
    let mut all = BTreeSet::new();
    let options: StagedOptions = toml::from_str(&full).expect("they are options");
    keys(&toml::Table::try_from(options).expect("they are TOML"), "", &mut all);
    // the paper's sensors log every rate: where one is made of its angle, the tests of the stages hold
    let held: BTreeSet<String> = cases.iter().map(|c| c.key).chain(["rates"]).map(str::to_string).collect();
    assert_eq!(held, all);
}

/// A folder with two short runs of the tank.
fn folder() -> PathBuf {
    let folder = std::env::temp_dir().join(format!("hydrosysid-options-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("the temporary folder can be made");
    let made = blind(&BlindOptions { duration: 20.0, ..BlindOptions::default() }).expect("the tank sails");
    for k in 0..2 {
        log::write(&made.runs[k], folder.join(format!("run{k}.csv"))).expect("the log is written");
    }
    folder
}

#[test]
fn options_of_a_campaign_mean_what_they_say() {
    let folder = folder();
    let file = folder.join("campaign.toml");
    let load = |text: &str| {
        std::fs::write(&file, text).expect("the temporary folder can be written");
        Campaign::load(&file, LoadOptions::default()).unwrap_or_else(|e| panic!("{e}\n{text}"))
    };
    let head = "format = 1\n[vehicle]\nmass = 100.0\n";
    let model = "[model]\ndofs = ['surge', 'sway', 'yaw']\neffects = ['inertia', 'linear_drag', 'coriolis_yaw']\n";
    let run = "[[run]]\nfile = 'run0.csv'\n";
    let log = "[log]\nmissing = 'no_sample'\n";
    // what a campaign is once it is read: runs to the bit, model, water, findings
    let read = |campaign: &Campaign| {
        let Campaign { water, model, runs, findings, options, .. } = campaign;
        format!("{water:?} {model:?} {runs:?} {findings:?} {options:?}")
    };
    for case in [
        case("seed", "1", "2"),
        case("water.density", "1000.0", "1025.0"),
        case("water.kinematic_viscosity", "1.004e-6", "1.3e-6"),
        case("noise", "{}", "{ u = 0.5 }"),
    ] {
        case.holds(|option| read(&load(&format!("{option}\n{head}{model}{log}{run}"))));
    }
    for case in [case("coriolis", "'tied'", "'free'"), case("input", "'linear'", "'hold'")] {
        case.holds(|option| read(&load(&format!("{head}{model}{option}\n{log}{run}"))));
    }
    for case in
        [case("position_source", "'dead_reckoned'", "'independent'"), case("velocity_reference", "'ground'", "'water'")]
    {
        case.holds(|option| read(&load(&format!("{head}{model}{log}{option}\n{run}"))));
    }
    for case in [
        case("kind", "'free'", "'zigzag'"),
        case("role", "'train'", "'validate'"),
        case("from", "", "5.0"),
        case("to", "", "10.0"),
        case("where", "", "'u > 0.1'"),
        case("resample", "", "2.0"),
        case("input", "'linear'", "'hold'"),
        case("log", "{}", "{ body_frame = 'flu' }"),
    ] {
        case.holds(|option| read(&load(&format!("{head}{model}{log}{run}{option}\n[[run]]\nfile = 'run1.csv'\n"))));
    }
    let offset = |file: &str| read(&load(&format!("{head}{model}{log}[[run]]\nfile = {file}\n")));
    assert_eq!(offset("{ file = 'run0.csv', clock_offset = 0.0 }"), offset("'run0.csv'"));
    assert_ne!(offset("['run0.csv', { file = 'run1.csv', clock_offset = 1.0 }]"), offset("['run0.csv', 'run1.csv']"));
    // how output error works, on one degree of freedom
    let small = "[model]\ndofs = ['surge']\neffects = ['inertia', 'linear_drag']\n";
    for case in [
        case("segment", "8.0", "3.0").beside("join = false"),
        case("longest_step", "0.1", "0.4"),
        case("loss", "'squares'", "'huber'"),
        case("join", "true", "false"),
    ] {
        case.holds(|option| {
            let text = format!("{head}{small}{log}[fit]\nestimator = 'output_error'\n{option}\n{run}");
            let fitted = fit(&load(&text), FitOptions::default()).unwrap_or_else(|e| panic!("{e}\n{text}"));
            format!("{:?}", fitted.parameters)
        });
    }
    std::fs::remove_dir_all(&folder).expect("the temporary folder can be removed");
}
