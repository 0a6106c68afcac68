//! A vehicle under a random force, on the independent plant: the estimated force goes with the
//! model into every other verb, prediction bands have their stated coverage, and the monitor has
//! its stated rate of false alarms.

use std::path::{Path, PathBuf};

use hydrosysid::campaign::{self, Campaign, Fit, FitOptions, LoadOptions, ModelFile, PlanRequest, PlanSource, Want};
use hydrosysid::envelope::Envelope;
use hydrosysid::export::{ExportOptions, Target, export_model};
use hydrosysid::frame::Dof;
use hydrosysid::monitor::MonitorOptions;
use hydrosysid::run::Role;
use hydrosysid_plant as plant;

/// Root mean square of the random force, as a share of that of the thrust.
const SHARE: f64 = 0.05;

/// A folder that is removed with its test.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Folder {
        Folder(std::env::temp_dir().join(format!("hydrosysid_pushed_{}_{name}", std::process::id())))
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// A planar campaign of 9 runs of 60 s, always of the same vehicle; only runs and noise depend on the seed.
fn sailed(seed: u64, share: f64, hidden: &[&str]) -> Campaign {
    let vehicle = plant::Vehicle::named("small").expect("the plant has it");
    let asked = plant::Campaign {
        spread: 0.0,
        force: plant::RandomForce { share, correlation: 0.5 },
        hidden: hidden.iter().map(|name| plant::Hidden::new(name)).collect(),
        seed,
        ..plant::Campaign::new(vehicle, &[plant::Dof::Surge, plant::Dof::Sway, plant::Dof::Yaw])
    };
    let folder = Folder::new(&format!("{seed}_{share}_{}", hidden.concat()));
    asked.sail().expect("it sails").write(&folder.0).expect("it is written");
    Campaign::load(&folder.0.join("campaign.toml"), LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

fn fitted(campaign: &Campaign) -> (Fit, ModelFile) {
    let fit = campaign::fit(campaign, FitOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    let file = ModelFile { campaign: String::new(), ..ModelFile::of(campaign, &fit) };
    (fit, file)
}

/// Asserts that every estimate of a fit of the campaign `asked` is within `deviations` standard
/// deviations of the truth.
fn within(name: &str, deviations: f64, asked: &plant::Campaign) {
    let folder = Folder::new(name);
    let sailed = asked.sail().expect("it sails");
    sailed.write(&folder.0).expect("it is written");
    let loaded = Campaign::load(&folder.0.join("campaign.toml"), LoadOptions::default());
    let (fit, _) = fitted(&loaded.unwrap_or_else(|e| panic!("{e}")));
    assert!(fit.converged, "{name}: {}", fit.sentence);
    for p in &fit.parameters {
        let term = p.dof.map_or(p.effect.clone(), |dof| format!("{}@{dof}", p.effect));
        let truth = sailed.truth.value(&term).unwrap_or_else(|| panic!("{name}: the plant knows no {term}"));
        let std = p.std.expect("it has a deviation");
        assert!((p.value - truth).abs() < deviations * std, "{name}: {term} = {} ± {std}, true {truth}", p.value);
    }
}

fn of_small(seed: u64) -> plant::Campaign {
    let vehicle = plant::Vehicle::named("small").expect("the plant has it");
    let force = plant::RandomForce { share: 0.02, correlation: 1.0 };
    plant::Campaign { force, seed, ..plant::Campaign::new(vehicle, &plant::Dof::PLANE) }
}

/// If no moment is commanded, a vehicle that is unstable in yaw turns by its Munk moment only, and
/// its parameters are found all the same. The allocation of thrusters leaves a moment of 1e-17 N m,
/// which must not be used as the scale of a random force or for the start of the inertia. By chance
/// one of these 36 values is beyond 4.5 standard deviations in 0.02 % of all cases.
#[test]
fn what_no_moment_is_commanded_is_found_by_what_turns_it() {
    for seed in [401, 408, 413, 417] {
        let asked = plant::Campaign { runs: 4, commands: plant::Commands::Thrusters, ..of_small(seed) };
        within(&format!("munk_alone_{seed}"), 4.5, &asked);
    }
}

/// Each sample of a DVL at 5 Hz is used once, though a log of 20 Hz repeats it.
#[test]
fn held_samples_count_once() {
    let suite = plant::Suite { rate: 20.0, dvl_rate: Some(5.0), held: true, ..plant::Suite::default() };
    let instruments = suite.instruments(&plant::Dof::PLANE);
    within("held", 4.5, &plant::Campaign { instruments, duration: 30.0, ..of_small(5000) });
}

#[test]
fn the_force_is_found_told_and_carried_by_the_model_file() {
    let (fit, file) = fitted(&sailed(1, SHARE, &[]));
    assert!(fit.converged && fit.sentence.contains("random force of"), "{}", fit.sentence);
    let noise = fit.noise.as_ref().expect("filter error knows of noise");
    let surge = noise.force.iter().find(|f| f.dof == Dof::Surge).expect("surge is pushed");
    // the median error is below 15 %; a single one is allowed three times that
    assert!((surge.share_of_thrust.expect("there is thrust") / SHARE - 1.0).abs() < 0.45, "{surge:?}");
    for path in ["model.toml", "model.json"] {
        let text = file.to_text(Path::new(path)).expect("it can be written");
        let read: ModelFile = match path.ends_with("json") {
            true => serde_json::from_str(&text).expect("it can be read"),
            false => toml::from_str(&text).expect("it can be read"),
        };
        let [read, written] = [&read, &file].map(|f| f.noise.clone().expect("it carries the noise"));
        assert_eq!((read.force.len(), read.sensor.len()), (written.force.len(), written.sensor.len()));
        // numbers in JSON are read to the last digit but one
        let close = |a: f64, b: f64| (a - b).abs() <= 1e-14 * b.abs();
        assert!(read.force.iter().zip(&written.force).all(|(a, b)| a.dof == b.dof && close(a.rms, b.rms)));
        assert!(read.sensor.iter().zip(&written.sensor).all(|(a, b)| a.channel == b.channel && close(a.std, b.std)));
    }
    let made = export_model(&file, Path::new("m"), Target::Kalman, &ExportOptions::default()).expect("it has noise");
    let made: serde_json::Value = serde_json::from_slice(&made.bytes).expect("JSON");
    let states: Vec<&str> = made["states"].as_array().expect("a list").iter().filter_map(|s| s.as_str()).collect();
    let at = states.iter().position(|s| *s == "random_force_u").expect("a state of the filter");
    let forgets = made["A"][at][at].as_f64().expect("a number");
    assert!((forgets + 1.0 / surge.correlation_time).abs() < 1e-9, "{forgets}");
    let bare = ModelFile { noise: None, ..file };
    let refused = export_model(&bare, Path::new("m"), Target::Kalman, &ExportOptions::default()).expect_err("no noise");
    assert!(refused.to_string().contains("filter_error"), "{refused}");
}

/// 95 % of the samples of held-out runs lie in the 95 % band of a free run. The errors are
/// correlated over seconds: with about 300 independent ones per seed, 900 in all, the share has a
/// standard error of 0.7 %. The errors of the parameters, which the band does not include, reduce
/// it by up to five percentage points.
#[test]
fn bands_of_free_runs_cover_what_they_say() {
    let (mut inside, mut all) = (0.0, 0.0);
    let mut ratios = Vec::new();
    for seed in [11, 12, 13] {
        let campaign = sailed(seed, SHARE, &[]);
        let (fit, file) = fitted(&campaign);
        let campaign = campaign.with_noise(file.noise.clone());
        let compared = campaign::compare(&campaign, &fit.model, &fit.envelope).expect("it compares");
        let held: Vec<&str> =
            campaign.runs.iter().filter(|r| r.role == Role::Validate).map(|r| r.name.as_str()).collect();
        let noise = compared.noise.expect("a filter follows");
        ratios.extend(
            noise
                .prediction
                .iter()
                .filter(|p| p.ahead == Some(8.0) && held.contains(&p.run.as_str()))
                .map(|p| (p.rms / p.expected).powi(2)),
        );
        let simulation = campaign::simulate(&campaign, &fit.model, &fit.envelope).expect("it simulates");
        for run in simulation.runs.iter().filter(|run| held.contains(&run.run.as_str())) {
            for dof in [Dof::Surge, Dof::Sway, Dof::Yaw] {
                let (x, y, std) =
                    (&run.simulated[dof.velocity()], &run.measured[dof.velocity()], &run.std[dof.velocity()]);
                for ((x, y), std) in x.iter().zip(y).zip(std) {
                    if let (Some(y), Some(std)) = (y, std) {
                        inside += f64::from(u8::from((x - y).abs() < 1.96 * std));
                        all += 1.0;
                    }
                }
            }
        }
    }
    assert!(all > 10_000.0);
    let share = inside / all;
    assert!((0.88..0.98).contains(&share), "{share}");
    let ratio = (ratios.iter().sum::<f64>() / ratios.len() as f64).sqrt();
    // a dozen predictions for each of 27 pairs of run and degree of freedom: 1/√(2·324) = 0.04,
    // plus the errors of the parameters
    assert!((0.85..1.2).contains(&ratio), "{ratio}");
}

/// A model is monitored along the logs of ten later campaigns. At a level of 5 % per log, at most
/// nine of the ninety logs give a false alarm (a binomial variable exceeds that once in fifty
/// cases), and a drag that grows by 40 % at some instant is seen in at least a third of the logs.
#[test]
fn false_alarms_of_the_monitor_keep_their_rate() {
    let (fit, file) = fitted(&sailed(1, SHARE, &[]));
    let options = MonitorOptions { level: 0.05, ..MonitorOptions::default() };
    let alarms = |seed: u64, hidden: &[&str]| {
        let campaign = sailed(seed, SHARE, hidden).with_noise(file.noise.clone());
        let found = campaign::monitor(&campaign, &fit.model, &Envelope::new(), &options).expect("it can be watched");
        assert!(found.noise.is_some());
        let runs = found.watch.changes.iter().map(|c| c.run.as_str()).collect::<std::collections::BTreeSet<&str>>();
        (runs.len(), campaign.runs.len())
    };
    let (alarmed, logs) = (21..31).map(|s| alarms(s, &[])).fold((0, 0), |(a, n), (x, y)| (a + x, n + y));
    assert_eq!(logs, 90);
    assert!(alarmed <= 9, "{alarmed} of {logs}");
    let (seen, logs) = alarms(41, &["drag_step"]);
    assert!(3 * seen >= logs, "{seen} of {logs}");
}

/// A random force hides the effect of the parameters, so the plan predicts larger standard
/// deviations with it.
#[test]
fn a_plan_counts_the_random_force_in() {
    let campaign = sailed(1, SHARE, &[]);
    let (fit, file) = fitted(&campaign);
    let source = |file: &ModelFile| PlanSource::of_file(file, Path::new("model.toml")).expect("it is a model");
    let request = |amount: f64| PlanRequest {
        wants: vec![Want { parameter: Some("quadratic_drag@surge".into()), amount, relative: true }],
        most: 1,
        ..PlanRequest::default()
    };
    let deviation = |file: &ModelFile| {
        let made = campaign::plan(&source(file), &request(1e-3), &|| ()).expect("it can be planned");
        let p = made.parameters.iter().find(|p| p.effect == "quadratic_drag" && p.dof == Some(Dof::Surge));
        (p.and_then(|p| p.std).expect("it is shown"), made.sentence)
    };
    let (pushed, sentence) = deviation(&file);
    assert!(sentence.contains("random force is included"), "{sentence}");
    let (calm, _) = deviation(&ModelFile { noise: None, ..file.clone() });
    assert!(pushed > 1.5 * calm, "{pushed} {calm}");
    assert!(fit.converged);
    let made = campaign::plan(&source(&file), &request(10.0), &|| ()).expect("it can be planned");
    assert!(made.sentence.starts_with("Enough already"), "{}", made.sentence);
}
