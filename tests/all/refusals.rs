//! Impossible values in files and arguments are refused with their place.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use hydrosysid::campaign::file::{CampaignFile, ReadOptions};
use hydrosysid::campaign::{ModelFile, ModelFileError, ModelForce, ModelNoise, ModelSensor};
use hydrosysid::effects::Coriolis;
use hydrosysid::frame::Dof;
use hydrosysid::plan::Instrument;

use crate::exported;

struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Folder {
        let path = std::env::temp_dir().join(format!("hydrosysid-refusals-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).expect("the temporary folder can be made");
        let row = |k: i32| format!("{0},{0},1,1,{0},1,1\n", 0.1 * f64::from(k));
        let log = "t,u,v,r,tau_u,tau_v,tau_r\n".to_string() + &(0..60).map(row).collect::<String>();
        fs::write(path.join("log.csv"), log).expect("the temporary folder can be written");
        Folder(path)
    }

    fn run(&self, arguments: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_hydrosysid"));
        command.args(arguments).current_dir(&self.0).env("NO_COLOR", "1").output().expect("the command starts")
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn told(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Place and message of the error in the text of a model file.
fn refused(text: &str) -> (Option<(usize, usize)>, String) {
    match ModelFile::from_text(text, Path::new("model.toml")) {
        Err(ModelFileError::Value { place, key, message, .. }) => (place, format!("{key}: {message}")),
        other => panic!("{other:?}\n{text}"),
    }
}

/// Number of the line that begins with `start`, from 1.
fn line_of(text: &str, start: &str) -> usize {
    1 + text.lines().position(|line| line.starts_with(start)).unwrap_or_else(|| panic!("{start} in\n{text}"))
}

#[test]
fn a_model_file_with_impossible_numbers_is_refused_with_its_line() {
    let terms = [("inertia@surge", 250.0), ("linear_drag@surge", 20.0)];
    let file = exported::file(&[Dof::Surge], &terms, Coriolis::Tied);
    let text = file.to_text(Path::new("model.toml")).expect("it is TOML");
    assert_eq!(ModelFile::from_text(&text, Path::new("model.toml")).expect("it reads back"), file);

    for (value, said) in [("nan", "NaN is not a finite number"), ("inf", "inf is not a finite number")] {
        let wrong = text.replace("value = 250.0", &format!("value = {value}"));
        let (place, message) = refused(&wrong);
        assert_eq!(place.map(|p| p.0), Some(line_of(&wrong, &format!("value = {value}"))));
        assert!(message.contains("parameter[0].value") && message.contains(said), "{message}");
    }
    let wrong = text.replace("std = 2.5", "std = -2.5");
    let (place, message) = refused(&wrong);
    assert_eq!(place.map(|p| p.0), Some(line_of(&wrong, "std = -2.5")));
    assert!(message.contains("parameter[0].std"), "{message}");

    let covariance = line_of(&text, "covariance = ");
    let of = |matrix: &str| {
        let line = text.lines().nth(covariance - 1).expect("it is there");
        refused(&text.replace(line, &format!("covariance = {matrix}")))
    };
    for (matrix, said) in [
        (
            "[[1.0, 0.1], [0.2, 1.0]]",
            "covariance[1][0]: 0.2, but covariance[0][1] is 0.1: a covariance must be symmetric",
        ),
        ("[[1.0, 7.0], [7.0, 1.0]]", "covariance[1][0]: 7.0 implies a correlation beyond 1"),
        ("[[-1.0, 0.0], [0.0, 1.0]]", "covariance[0][0]: -1.0: a variance must not be negative"),
        ("[[1.0, nan], [0.0, 1.0]]", "covariance[0][1]: NaN is not a finite number"),
        ("[[1.0]]", "number of rows is 1, but there are 2 parameters"),
        ("[[1.0, 0.0], [0.0]]", "covariance[1]: its number of columns is 1"),
    ] {
        let (place, message) = of(matrix);
        assert!(message.contains(said), "{message}");
        assert_eq!(place.map(|p| p.0), Some(covariance), "{message}");
    }

    let first = text.split("[[parameter]]").nth(1).expect("there is one");
    let second = text.split("[[parameter]]").nth(2).expect("there are two");
    let twice = text.replacen(second, first, 1);
    let (place, message) = refused(&twice);
    assert!(
        message.contains("parameter[1].effect") && message.contains("occurs here for the second time"),
        "{message}"
    );
    assert!(place.is_some());
    let tie = |a: &str, b: &str| format!("\n[[tied]]\neffect = '{a}'\ntie = '{b}'\n");
    let circle =
        format!("{text}{}{}", tie("inertia@surge", "linear_drag@surge"), tie("linear_drag@surge", "inertia@surge"));
    let (place, message) = refused(&circle);
    assert!(message.contains("leads back to its own parameter"), "{message}");
    assert_eq!(place.map(|p| p.0), Some(line_of(&circle, "tie = 'linear_drag@surge'")));
}

#[test]
fn a_model_file_with_impossible_noise_is_refused() {
    let mut file = exported::file(&[Dof::Surge], &[("inertia@surge", 250.0)], Coriolis::Tied);
    file.noise = Some(ModelNoise {
        innovations_white: true,
        force: vec![ModelForce {
            dof: Dof::Surge,
            rms: 1.25,
            std: 0.1,
            correlation_time: 0.75,
            correlation_time_std: 0.1,
            share_of_thrust: None,
        }],
        sensor: vec![ModelSensor {
            channel: "u".into(),
            std: 0.005,
            coloured_std: None,
            correlation_time: None,
            restlessness: 1.0,
        }],
    });
    file.sensors = [("u".to_string(), Instrument { noise: 0.0625, rate: 12.5 })].into();
    let text = file.to_text(Path::new("model.toml")).expect("it is TOML");
    assert_eq!(ModelFile::from_text(&text, Path::new("model.toml")).expect("it reads back"), file);
    for (good, bad, said) in [
        (
            "rms = 1.25",
            "rms = -1.25",
            "noise.force[0].rms: -1.25: a standard deviation must be a number that is not negative",
        ),
        ("rms = 1.25", "rms = nan", "noise.force[0].rms: NaN"),
        (
            "correlation_time = 0.75",
            "correlation_time = 0.0",
            "noise.force[0].correlation_time: 0.0: a correlation time",
        ),
        ("std = 0.005", "std = -0.005", "noise.sensor[0].std: -0.005"),
        ("noise = 0.0625", "noise = inf", "sensors.u.noise: inf"),
        ("rate = 12.5", "rate = 0.0", "sensors.u.rate: 0.0: a rate must be a positive number"),
    ] {
        assert!(text.contains(good), "{good} in {text}");
        let (_, message) = refused(&text.replacen(good, bad, 1));
        assert!(message.contains(said), "{message}");
    }
}

#[test]
fn ties_in_a_circle_are_refused_in_a_campaign() {
    let text = "format = 1\n[model]\ndofs = ['surge', 'sway']\neffects = ['inertia', 'linear_drag']\n\
                [[parameter]]\neffect = 'linear_drag@surge'\ntie = 'linear_drag@sway'\n\
                [[parameter]]\neffect = 'linear_drag@sway'\ntie = 'linear_drag@surge'\n[[run]]\nfile = 'a.csv'\n";
    let options = ReadOptions { look_for_files: false, ..ReadOptions::default() };
    let error = CampaignFile::from_bytes(text.as_bytes(), Path::new("c.toml"), &options).expect_err("it is a circle");
    assert!(error.to_string().contains("c.toml:7:7: parameter[0].tie: this tie leads back"), "{error}");
}

#[test]
fn init_writes_toml_for_any_name_and_refuses_masses_that_are_none() {
    let folder = Folder::new("init");
    let name = "a \"b\" \\ c\n[run]\u{1}\u{7f}'''\"\"\"\t\u{2028}=";
    let output = folder.run(&["init", "log.csv", "--name", name, "--mass", "12.5", "-o", "campaign.toml"]);
    assert_eq!(output.status.code(), Some(0), "{}", told(&output));
    let text = fs::read_to_string(folder.0.join("campaign.toml")).expect("it is written");
    let table: toml::Table = text.parse().unwrap_or_else(|e| panic!("{e}\n{text}"));
    assert_eq!(table["vehicle"]["name"].as_str(), Some(name));
    assert_eq!(table["vehicle"]["mass"].as_float(), Some(12.5));
    let output =
        folder.run(&["init", "log.csv", "--log", "columns.u = 'v'", "--log", "columns.v = 'u'", "-o", "b.toml"]);
    assert_eq!(output.status.code(), Some(0), "{}", told(&output));
    let options = ReadOptions::default();
    CampaignFile::read(&folder.0.join("b.toml"), &options).unwrap_or_else(|e| panic!("{e}"));
    for figure in ["--mass", "--volume", "--weight", "--buoyancy", "--length"] {
        for value in ["nan", "inf", "-1", "0", "1e999", "twelve"] {
            let output = folder.run(&["init", "log.csv", &format!("{figure}={value}"), "-o", "c.toml"]);
            assert_eq!(output.status.code(), Some(2), "{figure} {value}");
            assert!(told(&output).contains("finite number above 0"), "{figure} {value}: {}", told(&output));
        }
    }
    assert!(!folder.0.join("c.toml").exists());
}

#[cfg(target_os = "linux")]
#[test]
fn no_more_threads_than_cores() {
    let folder = Folder::new("jobs");
    let pipe = folder.0.join("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().expect("it starts").success());
    // it waits at the pipe after it has created its threads
    let mut command = Command::new(env!("CARGO_BIN_EXE_hydrosysid"));
    let mut child = command.arg("check").arg(&pipe).args(["-j", "100000"]).spawn().expect("the command starts");
    let writer = fs::OpenOptions::new().write(true).open(&pipe).expect("the command reads");
    let status = fs::read_to_string(format!("/proc/{}/status", child.id())).expect("it runs");
    drop(writer);
    child.wait().expect("it ends");
    let threads: usize = status
        .lines()
        .find_map(|line| line.strip_prefix("Threads:"))
        .and_then(|n| n.trim().parse().ok())
        .expect("Linux tells the number of threads");
    let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    // the threads of the pool, the main thread, and the one that shows the progress
    assert!(threads <= cores + 2, "{threads} threads on {cores} cores");
}
