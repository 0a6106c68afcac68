//! The command as a user runs it: successful calls, JSON, exit codes, and messages that name the
//! place of an error.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use hydrosysid::log;
use hydrosysid::run::Run;
use hydrosysid::tank::{BlindOptions, blind};
use serde_json::Value;

use crate::shared;

/// A folder for one test, which is removed when it is dropped.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Folder {
        let path = std::env::temp_dir().join(format!("hydrosysid-cli-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).expect("the temporary folder can be made");
        Folder(path)
    }

    fn path(&self, name: &str) -> String {
        self.0.join(name).display().to_string()
    }

    fn write(&self, name: &str, text: &str) -> String {
        fs::write(self.0.join(name), text).expect("the temporary folder can be written");
        self.path(name)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn run(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hydrosysid"));
    command.args(arguments).env("NO_COLOR", "1").output().expect("the command starts")
}

fn code(output: &Output) -> i32 {
    output.status.code().expect("the command ends by itself")
}

fn stdout(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn json(path: impl AsRef<Path>) -> Value {
    serde_json::from_str(&fs::read_to_string(path).expect("the JSON is there")).expect("it is JSON")
}

/// A small planar campaign of the virtual tank: four runs, the last for validation.
fn campaign(folder: &Folder) -> String {
    let made = blind(&BlindOptions { duration: 40.0, ..BlindOptions::default() }).expect("the tank sails");
    let mut text = "format = 1\n[vehicle]\nname = 'tank'\nmass = 100.0\nlength = 0.6\n[model]\ndofs = ['surge', 'sway', 'yaw']\neffects = ['inertia', 'linear_drag', 'quadratic_drag', 'coriolis_surge', 'coriolis_sway', 'coriolis_yaw']\n[log]\nposition_source = 'independent'\nmissing = 'no_sample'\n".to_string();
    for (k, role) in [(0, "train"), (2, "train"), (4, "train"), (6, "validate")] {
        let run: &Run = &made.runs[k];
        log::write(run, folder.0.join(format!("run{k}.csv"))).expect("the log is written");
        text += &format!("[[run]]\nfile = 'run{k}.csv'\nrole = '{role}'\n");
    }
    folder.write("campaign.toml", &text)
}

#[test]
fn fit_simulate_and_compare_work_on_a_campaign_and_its_model() {
    let folder = Folder::new("fit");
    let file = campaign(&folder);
    let (fit, model) = (folder.path("fit.json"), folder.path("model.toml"));
    let output = run(&["fit", &file, "--json", &fit, "--model", &model]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert!(stdout(&output).contains("k_u|u|"), "{}", stdout(&output));
    let fit = json(&fit);
    assert_eq!((fit["format"].as_u64(), fit["estimator"].as_str()), (Some(1), Some("filter_error")));
    let parameters = fit["parameters"].as_array().expect("parameters");
    assert_eq!(parameters.len(), 9);
    for key in ["effect", "dof", "name", "value", "std", "std_paper", "unit", "sname", "sname_value", "fixed"] {
        assert!(parameters[0].get(key).is_some(), "{key}");
    }
    let inertia = &parameters[0];
    assert_eq!(inertia["sname"], "X_udot");
    let (value, sname) = (inertia["value"].as_f64().unwrap(), inertia["sname_value"].as_f64().unwrap());
    assert!((sname + (value - 100.0)).abs() < 1e-9);
    let covariance = fit["covariance"].as_array().expect("covariance");
    assert_eq!((covariance.len(), covariance[0].as_array().map(Vec::len)), (9, Some(9)));
    let variance = covariance[3][3].as_f64().unwrap();
    assert!((variance.sqrt() / parameters[3]["std"].as_f64().unwrap() - 1.0).abs() < 1e-9);
    for key in ["name", "dof", "rows", "residual_std", "condition_number", "condition_number_scaled"] {
        assert!(fit["stages"][0].get(key).is_some(), "{key}");
    }
    assert_eq!(fit["converged"], true);
    let sentence = fit["sentence"].as_str().expect("a sentence");
    let told = stdout(&output);
    assert!(told.starts_with(sentence), "the verdict comes first: {told}");
    assert!(told.contains(&format!("next: hydrosysid compare {file}")), "{told}");
    // lines with a path may be longer
    let mut tables = told.lines().skip(1).filter(|line| !line.starts_with("next") && !line.starts_with("written"));
    assert!(!told.contains("cond scaled") && tables.all(|line| line.chars().count() <= 80), "{told}");
    assert!(fit["noise"]["sensors"].as_array().is_some_and(|sensors| sensors.iter().any(|s| s["channel"] == "u")));

    let compare = folder.path("compare.json");
    let output = run(&["compare", &file, "--model", &model, "--json", &compare]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let compare = json(&compare);
    let rows = compare["runs"].as_array().expect("runs");
    assert_eq!(rows.len(), 12);
    for key in ["run", "role", "dof", "mean_abs", "std_abs", "rms", "noise_floor", "fit_percent", "unit"] {
        assert!(rows[0].get(key).is_some(), "{key}");
    }
    assert!(rows.iter().any(|r| r["role"] == "validate"));
    let ahead = compare["noise"]["prediction"].as_array().expect("predictions");
    assert_eq!(ahead.len(), 4 * rows.len(), "one sample, 2 s, 8 s and a free run");
    assert!(ahead.iter().all(|p| p["expected"].as_f64().is_some_and(|x| x > 0.0)));

    let output = run(&["simulate", &file, "--model", &model, "--output", &folder.path("simulated"), "--json", "-"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let simulated: Value = serde_json::from_str(&stdout(&output)).expect("standard output is JSON alone");
    assert_eq!(simulated["runs"].as_array().map(Vec::len), Some(4));
    assert!(folder.0.join("simulated").join("run0.csv").exists());

    // an existing model file is not replaced, and nothing else is written either
    let output = run(&["fit", &file, "--model", &model, "--json", &folder.path("again.json")]);
    assert_eq!(code(&output), 2);
    assert!(stderr(&output).contains("--force") && !folder.0.join("again.json").exists());
    let output = run(&["fit", &file, "--model", &model, "--force", "--estimator", "integral", "--quiet"]);
    assert_eq!((code(&output), stdout(&output).as_str()), (0, ""), "{}", stderr(&output));
}

#[test]
fn check_says_green_amber_or_red() {
    let folder = Folder::new("check");
    let mut text = "t,u,v,r,tau_u,tau_v,tau_r\n".to_string();
    for k in 0..200 {
        let t = 0.1 * f64::from(k);
        text += &format!(
            "{t:.1},{:.4},{:.4},{:.4},{:.3},{:.3},{:.3}\n",
            t.sin(),
            t.cos(),
            (2.0 * t).sin(),
            10.0 * t.cos(),
            -9.0 * t.sin(),
            5.0 * (2.0 * t).cos()
        );
    }
    let good = folder.write("good.csv", &text);
    let found = folder.path("check.json");
    let output = run(&["check", &good, "--json", &found]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert!(["green", "amber"].contains(&json(&found)["verdict"].as_str().expect("a verdict")));
    let bad = folder.write("bad.csv", &text.replacen("0.3,", "0.3,abc", 1));
    let found = folder.path("bad.json");
    let output = run(&["check", &bad, "--json", &found]);
    assert_eq!(code(&output), 1);
    let message = stderr(&output);
    assert!(
        message.contains("line 5, column u") && message.contains("5 | 0.3,abc") && message.contains("^^^"),
        "{message}"
    );
    let found = json(&found);
    let error = &found["errors"][0];
    assert_eq!(
        (error["line"].as_u64(), error["column"].as_str(), error["severity"].as_str()),
        (Some(5), Some("u"), Some("error"))
    );
    let gap = folder.write(
        "gap.csv",
        &text
            .replace("\n15.", "\n95.")
            .replace("\n16.", "\n96.")
            .replace("\n17.", "\n97.")
            .replace("\n18.", "\n98.")
            .replace("\n19.", "\n99."),
    );
    let output = run(&["check", &gap]);
    assert!(code(&output) == 0 && stderr(&output).contains("gap"), "{}", stderr(&output));
    assert_eq!(code(&run(&["check", &gap, "--strict"])), 1);
    assert_eq!(code(&run(&["check", &folder.path("none.csv")])), 2);
}

#[test]
fn what_is_wrong_with_a_campaign_is_shown_with_a_caret() {
    let folder = Folder::new("caret");
    let file = campaign(&folder);
    let text = fs::read_to_string(&file).expect("the campaign was written");
    let wrong = folder.write("wrong.toml", &text.replace("mass = 100.0", "mas = 100.0"));
    let output = run(&["fit", &wrong]);
    assert_eq!(code(&output), 2);
    let message = stderr(&output);
    assert!(message.contains("wrong.toml:4:1") && message.contains("mass") && message.contains("^^^"), "{message}");
    assert_eq!(code(&run(&["fit", &folder.path("none.toml")])), 2);
    assert_eq!(code(&run(&["fit"])), 2);
    assert_eq!(code(&run(&["fti", &file])), 2);
    assert_eq!(code(&run(&["fit", &file, "--jobs", "0"])), 2);
    // a file of another kind is named in one message instead of being parsed
    let log = folder.path("run0.csv");
    for (words, told) in [
        (vec!["fit", &log], "hydrosysid init"),
        (vec!["monitor", &file, &log], "hydrosysid fit"),
        (vec!["compare", &file, "--model", &file], "this is a campaign file"),
    ] {
        let output = run(&words);
        let message = stderr(&output);
        assert_eq!(code(&output), 2, "{message}");
        assert!(message.contains(told) && message.lines().count() <= 4, "{message}");
    }
    let model = folder.path("model.toml");
    assert_eq!(code(&run(&["fit", &file, "--model", &model])), 0);
    let message = stderr(&run(&["check", &model]));
    assert!(message.contains("this is a model file") && message.lines().count() <= 4, "{message}");
    assert!(stderr(&run(&["fit", &folder.path("none.toml")])).contains("there is no such file"));
    // a log without a channel that the model needs is refused
    let narrow = folder.write("narrow.csv", "t,u,v,r,tau_u,tau_v\n0,0,0,0,1,1\n1,1,1,1,1,1\n");
    assert!(Path::new(&narrow).exists());
    let start = text.find("[[run]]").expect("there are runs");
    let refused = folder.write("refused.toml", &format!("{}[[run]]\nfile = 'narrow.csv'\n", &text[..start]));
    let output = run(&["fit", &refused]);
    assert_eq!(code(&output), 1, "{}", stderr(&output));
    assert!(stderr(&output).contains("tau_r"), "{}", stderr(&output));
}

#[test]
fn init_writes_a_campaign_that_checks() {
    let folder = Folder::new("init");
    campaign(&folder);
    let (log, file) = (folder.path("run0.csv"), folder.path("new.toml"));
    let arguments =
        ["init", &log, "--mass", "100", "--name", "tank", "--output", &file, "--log", "missing = \"no_sample\""];
    let output = run(&arguments);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let output = run(&["check", &file]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert_eq!(code(&run(&arguments)), 2);
}

#[test]
fn convert_writes_plain_csv() {
    let folder = Folder::new("convert");
    let log = folder.write("odd.csv", "t [ms];u [cm/s]\n0;10,5\n100;20\n200;30\n300;10\n400;20\n");
    let plain = folder.path("plain.csv");
    let options = ["--log", "delimiter = ';'", "--log", "decimal = ','"];
    let output = run(&[&["convert", log.as_str(), plain.as_str()], &options[..]].concat());
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert!(fs::read_to_string(&plain).expect("it was written").contains("0.1,0.2"));
    let output = run(&["convert", &log, &folder.path("other.csv"), "--log", "delimter = ';'"]);
    assert!(code(&output) == 2 && stderr(&output).contains("delimter"), "{}", stderr(&output));
}

#[test]
fn convert_takes_a_map_and_says_who_reads_other_formats() {
    let folder = Folder::new("map");
    let log = folder.write("odd.csv", "time,speed,side\n0,10.5,1\n100,20,2\n200,30,3\n300,10,4\n");
    let columns =
        "[columns]\nt = { name = \"time\", unit = \"ms\" }\nu = \"speed\"\nv = { name = \"side\", sign = -1 }\n";
    let (map, plain) = (folder.write("map.toml", columns), folder.path("plain.csv"));
    let output = run(&["convert", &log, "-o", &plain, "--map", &map, "--log", "body_frame = 'flu'"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    // −1 from the map and −1 from the axes
    assert!(fs::read_to_string(&plain).expect("it was written").contains("0.1,20.0,2.0"));
    for (name, word) in [("a.mcap", "hydrosysid[ros]"), ("a.BIN", "hydrosysid[ardupilot]"), ("a.npz", "'hydrosysid'")] {
        let output = run(&["convert", &folder.path(name), "-o", &folder.path("b.csv")]);
        assert!(code(&output) == 2 && stderr(&output).contains(word), "{}", stderr(&output));
    }
    assert_eq!(code(&run(&["convert", &log])), 2);
}

#[test]
fn series_stand_side_by_side() {
    let folder = Folder::new("series");
    let file = campaign(&folder);
    let (simulated, compared) = (folder.path("s.csv"), folder.path("c.csv"));
    assert_eq!(code(&run(&["simulate", &file, "--series", &simulated])), 0);
    assert_eq!(code(&run(&["compare", &file, "--series", &compared])), 0);
    let text = fs::read_to_string(&simulated).expect("it was written");
    assert!(text == fs::read_to_string(&compared).expect("it was written"));
    let header = text.lines().next().unwrap_or_default();
    for kind in ["measured", "simulated", "residual", "std"] {
        assert!(header.contains(&format!("run0.csv/u/{kind}")), "{header}");
    }
    let output = run(&["simulate", &file, "--series", &folder.path("s.mcap")]);
    assert!(code(&output) == 2 && stderr(&output).contains("hydrosysid[mcap]"), "{}", stderr(&output));
    let output = run(&["simulate", &file, "--series", &simulated]);
    assert!(code(&output) == 2 && stderr(&output).contains("exists"), "{}", stderr(&output));
}

#[test]
fn catalogue_codes_and_shell_are_told() {
    let output = run(&["effects", "--json", "-"]);
    let effects: Value = serde_json::from_str(&stdout(&output)).expect("JSON");
    assert!(effects.as_array().expect("a list").iter().any(|e| e["id"] == "quadratic_drag"));
    assert!(stdout(&run(&["effects", "coriolis_yaw"])).contains("k_uv"));
    let near = run(&["effects", "quadratic_drg"]);
    assert!(code(&near) == 2 && stderr(&near).contains("quadratic_drag"));
    let munk = stdout(&run(&["effects", "--search", "MUNK"]));
    assert!(munk.contains("coriolis_yaw") && munk.contains("the Munk moment in pitch"), "{munk}");
    assert!(!munk.contains("quadratic_drag"), "{munk}");
    let found: Value =
        serde_json::from_str(&stdout(&run(&["effects", "--search", "rotor lag", "--json", "-"]))).unwrap();
    assert_eq!((found[0]["id"].as_str(), found[0]["common_name"].as_str()), (Some("thrust_lag"), Some("rotor lag")));
    let none = run(&["effects", "--search", "munc moment"]);
    assert_eq!(code(&none), 0);
    assert!(stdout(&none).contains("did you mean `munk moment`?"), "{}", stdout(&none));
    assert_eq!(stdout(&run(&["effects", "--search", "warp drive", "--json", "-"])).trim(), "[]");
    assert_eq!(code(&run(&["effects", "thrust_lag", "--search", "lag"])), 2);
    assert!(stdout(&run(&["explain", "L105"])).contains("gap"));
    assert_eq!(code(&run(&["explain", "L999"])), 2);
    assert!(stdout(&run(&["completions", "bash"])).contains("hydrosysid"));
    assert!(stdout(&run(&["man"])).contains(".TH"));
    assert!(stdout(&run(&["--version"])).contains(env!("CARGO_PKG_VERSION")));
}

#[test]
fn discover_gives_a_verdict() {
    let folder = Folder::new("discover");
    let file = campaign(&folder);
    let output = run(&["discover", &file, "--json", "-"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let found: Value = serde_json::from_str(&stdout(&output)).expect("JSON");
    for key in [
        "format",
        "verdict",
        "effects",
        "where",
        "gap",
        "removed",
        "log_findings",
        "smallest_visible",
        "next_experiment",
        "seed",
        "warnings",
    ] {
        assert!(found.get(key).is_some(), "{key}");
    }
}

#[test]
fn example_campaigns_are_fitted_near_their_truth() {
    let Some(examples) = shared::path("example_campaigns") else { return };
    let folder = Folder::new("examples");
    for name in ["nothing_hidden", "munk_hidden"] {
        let file = examples.join(name).join("campaign.toml").display().to_string();
        let fit = folder.path(&format!("{name}.json"));
        let model = folder.path(&format!("{name}.toml"));
        let output = run(&["fit", &file, "--json", &fit, "--model", &model]);
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        let compare = folder.path(&format!("{name}-compare.json"));
        let output = run(&["compare", &file, "--model", &model, "--json", &compare]);
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        assert_eq!(json(&compare)["runs"].as_array().map(Vec::len), Some(27));
        if name == "nothing_hidden" {
            let truth = json(examples.join(name).join("truth.json"));
            let parameters = json(&fit);
            for p in parameters["parameters"].as_array().expect("parameters") {
                let index = ["surge", "sway", "heave", "roll", "pitch", "yaw"].iter().position(|d| p["dof"] == *d);
                let key = match p["effect"].as_str() {
                    Some("inertia") => "M_diagonal",
                    Some("linear_drag") => "linear_drag",
                    _ => "quadratic_drag",
                };
                let Some(true_value) = index.and_then(|k| truth[key][k].as_f64()) else { continue };
                let (value, std) = (p["value"].as_f64().unwrap(), p["std"].as_f64().unwrap());
                // nine estimates within 4 standard deviations: by chance this fails once in two
                // thousand cases
                assert!((value - true_value).abs() < 4.0 * std, "{p} {true_value}");
            }
        }
    }
}

#[test]
fn a_model_is_exported_compared_and_watched() {
    let folder = Folder::new("export");
    let file = campaign(&folder);
    let model = folder.path("model.toml");
    assert_eq!(code(&run(&["fit", &file, "--model", &model, "--quiet"])), 0);

    let (vehicle, told) = (folder.path("vehicle.sdf"), folder.path("export.json"));
    let output = run(&["export", &model, "--to", "gazebo-added-mass", "-o", &vehicle, "--json", &told]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert!(fs::read_to_string(&vehicle).expect("it was written").contains("<fluid_added_mass>"));
    let told = json(&told);
    assert_eq!((told["format"].as_u64(), told["target"].as_str()), (Some(1), Some("gazebo-added-mass")));
    // the model has three degrees of freedom, the simulator six
    let warned = told["warnings"].as_array().expect("warnings");
    assert!(warned.iter().any(|w| w["code"] == "X004" && w["message"].as_str().is_some_and(|m| m.contains("heave"))));
    assert_eq!(code(&run(&["export", &model, "--to", "gazebo-added-mass", "-o", &vehicle])), 2, "it exists");
    let output = run(&["export", &model, "--to", "gazebp"]);
    assert!(code(&output) == 2 && stderr(&output).contains("did you mean `gazebo`"), "{}", stderr(&output));
    let output = run(&["export", &model, "--to", "Stonefish"]);
    let told = stderr(&output);
    assert!(code(&output) == 2 && told.contains("cannot represent") && told.contains("c-header"), "{told}");
    let output = run(&["export", &file, "--to", "uuv"]);
    assert!(code(&output) == 2 && stderr(&output).contains("fit the campaign"), "{}", stderr(&output));
    let output = run(&["export", &model, "--to", "ardusub"]);
    assert!(code(&output) == 2 && stderr(&output).contains("[[thruster]]"), "{}", stderr(&output));
    let output = run(&["export", &model, "--to", "linear-python", "--at", "u=0.3,w=1"]);
    assert!(code(&output) == 2 && stderr(&output).contains("no `w`"), "{}", stderr(&output));
    let output = run(&["export", &model, "--to", "linear-python", "--at", "u=0.3"]);
    assert!(stdout(&output).contains("def system():"), "{}", stderr(&output));
    assert_eq!(code(&run(&["export", &model, "--to", "linear-mat"])), 2, "bytes need a file");
    assert!(stdout(&run(&["export"])).contains("fossen-matlab"));
    assert!(stdout(&run(&["explain", "X008"])).contains("blows up"));

    let difference = folder.path("difference.json");
    let output = run(&["compare", &model, &model, "--json", &difference]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let difference = json(&difference);
    assert_eq!(difference["parameters"].as_array().map(Vec::len), Some(9));
    assert_eq!(difference["joint"]["chi_squared"].as_f64(), Some(0.0));
    let params = folder.write("params.toml", "format = 1\nconvention = 'sname'\n[parameters]\n'X_u|u|' = -60.0\n");
    let held = folder.path("held.json");
    let output = run(&["compare", &file, "--model", &model, "--params", &params, "--json", &held]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let drag =
        json(&held)["parameters"].as_array().expect("parameters").iter().find(|p| p["sname"] == "X_u|u|").cloned();
    assert_eq!(drag.expect("it is there")["published"].as_f64(), Some(60.0));

    let watched = folder.path("watch.json");
    let arguments =
        ["monitor", &model, &folder.path("run6.csv"), "--log", "missing = \"no_sample\"", "--json", &watched];
    let output = run(&arguments);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let watched = json(&watched);
    assert_eq!((watched["format"].as_u64(), watched["fits"].as_bool()), (Some(1), Some(true)));
    for key in ["run", "dof", "from", "to", "rms", "noise", "chi_squared", "p_value", "cusum", "off"] {
        assert!(watched["windows"][0].get(key).is_some(), "{key}");
    }
    assert_eq!(code(&run(&["monitor", &model, &folder.path("none.csv")])), 2);
    assert_eq!(code(&run(&["monitor", &model, &folder.path("run6.csv"), "--window", "0"])), 2);
}

#[test]
fn thrusters_are_exported_from_the_campaign() {
    let folder = Folder::new("thrusters");
    let thruster = "[[thruster]]\nname = 'bow'\nposition = [0.2, -0.1, 0.05]\naxis = [1, 0, 0]\nforward = { a = 40.0, b = 10.0 }\nreverse = { a = 30.0, b = 10.0 }\nmax = 1.0\nneutral = 1500\nspan = 400\n";
    let stern = thruster.replace("bow", "stern").replace("span = 400", "span = -400");
    let head =
        "format = 1\n[vehicle]\nname = 'boat'\n[model]\ndofs = ['surge']\neffects = ['inertia', 'linear_drag']\n";
    let file = folder.write("campaign.toml", &format!("{head}{thruster}{stern}[[run]]\nfile = 'none.csv'\n"));
    let output = run(&["export", &file, "--to", "gazebo-thrusters"]);
    let text = stdout(&output);
    let document = roxmltree::Document::parse(&text).expect("it is XML");
    let plugins: Vec<_> = document.descendants().filter(|n| n.has_tag_name("plugin")).collect();
    assert_eq!(plugins.len(), 2, "{}", stderr(&output));
    let value = |name: &str| -> f64 {
        let node = plugins[0].children().find(|n| n.has_tag_name(name)).expect("the element is there");
        node.text().expect("a text").parse().expect("a number")
    };
    // a + b at full command
    assert_eq!((value("max_thrust_cmd"), value("min_thrust_cmd")), (50.0, -40.0));
    assert!(text.contains("at 0.2 0.1 -0.05"), "forward-port-up: {text}");

    let output = run(&["export", &file, "--to", "ardusub"]);
    let text = stdout(&output);
    let parameters: Vec<&str> = text.lines().filter(|l| !l.starts_with('#')).collect();
    assert_eq!(parameters, ["MOT_PWM_MIN,1100", "MOT_PWM_MAX,1900", "MOT_1_DIRECTION,1", "MOT_2_DIRECTION,-1"]);
    // half of the command forward gives 40/4 + 10/2 N, not half of 50 N; the same for both thrusters
    assert_eq!(text.matches("0.5, 1700, 15.00, 25.00").count(), 1, "{text}");
    assert_eq!(text.matches("0.5, 1300, 15.00, 25.00").count(), 1, "{text}");
    assert!(stderr(&output).contains("X011") && stderr(&output).contains("20 %"), "{}", stderr(&output));
}
