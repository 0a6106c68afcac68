//! A model monitored along new logs, compared with another model, and published parameters compared
//! with a log.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use hydrosysid::campaign::file::{CampaignFile, ReadOptions};
use hydrosysid::campaign::{self, Campaign, FitOptions, LoadOptions, ModelFile, Published};
use hydrosysid::chain::Available;
use hydrosysid::dynamics::Dynamics;
use hydrosysid::effects::Coriolis;
use hydrosysid::estimate::output_error::OutputErrorOptions;
use hydrosysid::frame::Dof;
use hydrosysid::model::Model;
use hydrosysid::monitor::{MonitorOptions, Watch, watch};
use hydrosysid::run::{Role, Run, Signal};
use hydrosysid::simulate::{Track, free_run};
use hydrosysid_plant as plant;

const PLANAR: [Dof; 3] = [Dof::Surge, Dof::Sway, Dof::Yaw];
const STEP: f64 = 0.1;

/// Noise of the sensors, m/s and rad/s.
const NOISE: [f64; 3] = [0.004, 0.004, 0.003];

fn craft(changed: &[(&str, f64)]) -> Model {
    let effects = ["inertia", "linear_drag", "quadratic_drag", "coriolis_surge", "coriolis_sway", "coriolis_yaw"];
    let mut model = Model::with_effects(&PLANAR, Coriolis::Tied, &effects).expect("a planar craft");
    let values = [
        ("inertia@surge", 250.0),
        ("inertia@sway", 320.0),
        ("inertia@yaw", 60.0),
        ("linear_drag@surge", 20.0),
        ("linear_drag@sway", 35.0),
        ("linear_drag@yaw", 15.0),
        ("quadratic_drag@surge", 120.0),
        ("quadratic_drag@sway", 260.0),
        ("quadratic_drag@yaw", 40.0),
    ];
    for (name, value) in values.iter().chain(changed) {
        assert!(model.set(name, *value), "{name} is in the model");
    }
    model
}

/// Nearly normal numbers: sums of twelve uniform ones from a congruential generator.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        let mut sum = -6.0;
        for _ in 0..12 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            sum += (self.0 >> 11) as f64 / (1_u64 << 53) as f64;
        }
        sum
    }
}

/// A log of `seconds` in which the vehicle is that of `models[k]` from `models[k].0` seconds on;
/// from then on, thrust in surge is `models[k].2` times the command.
fn sail(models: &[(f64, Model, f64)], seconds: f64, seed: u64) -> Run {
    let count = (seconds / STEP) as usize;
    let time: Arc<[f64]> = (0..=count).map(|k| STEP * k as f64).collect();
    let command = |i: usize, t: f64| {
        let size = [90.0, 70.0, 12.0][i];
        size * ((0.5 + 0.17 * i as f64) * t + (seed + i as u64) as f64).sin() + [40.0, 0.0, 2.0][i]
    };
    let mut state = vec![0.0; 4];
    let mut measured: Vec<Vec<f64>> = vec![Vec::new(); 3];
    for (k, (from, model, share)) in models.iter().enumerate() {
        let first = (from / STEP) as usize;
        let last = models.get(k + 1).map_or(count, |(next, ..)| (next / STEP) as usize);
        let mut run = Run { name: "truth".into(), ..Run::default() };
        for (i, dof) in PLANAR.iter().enumerate() {
            let acting = |t: &f64| command(i, *t) * if i == 0 { *share } else { 1.0 };
            let forces: Vec<f64> = time.iter().map(acting).collect();
            run.signals.insert(dof.force().into(), Signal::new(time.clone(), forces));
            run.signals.insert(dof.velocity().into(), Signal::new(time.clone(), vec![0.0; count + 1]));
        }
        let observed: BTreeSet<String> = ["u", "v", "r"].map(String::from).into();
        let channels = PLANAR.iter().map(|d| d.force().to_string()).collect();
        let dynamics = Dynamics::compile(model, &Available { channels, ..Available::default() }, &observed, &[]);
        let track = Track::new(&run, 0, &dynamics, &model.values(), model.input, 0.05).expect("a complete run");
        let path = free_run(&dynamics, &track, &model.values(), &state, first, last);
        state = path.states[path.states.len() - dynamics.states.len()..].to_vec();
        let width = dynamics.outputs.len();
        let kept = if last == count { path.time.len() } else { path.time.len() - 1 };
        for (i, list) in measured.iter_mut().enumerate() {
            let column = dynamics.outputs.iter().position(|o| *o == PLANAR[i].velocity()).expect("it is observed");
            list.extend(path.outputs.iter().skip(column).step_by(width).take(kept));
        }
    }
    let mut noise = Noise(seed + 1);
    let mut log = Run { name: format!("dive {seed}"), ..Run::default() };
    for (i, dof) in PLANAR.iter().enumerate() {
        let noisy: Vec<f64> = measured[i].iter().map(|x| x + NOISE[i] * noise.next()).collect();
        log.signals.insert(dof.velocity().into(), Signal::new(time.clone(), noisy));
        log.signals.insert(
            dof.force().into(),
            Signal::new(time.clone(), time.iter().map(|t| command(i, *t)).collect::<Vec<f64>>()),
        );
    }
    log
}

fn watched(run: Run) -> Watch {
    watch(&craft(&[]), None, &[run], &OutputErrorOptions::default(), &MonitorOptions::default())
        .expect("it can be watched")
}

#[test]
fn a_model_that_fits_is_left_in_peace() {
    for seed in 0..6 {
        let found = watched(sail(&[(0.0, craft(&[]), 1.0)], 96.0, seed));
        assert!(found.fits && found.reasons.is_empty() && found.warnings.is_empty(), "{:?}", found.warnings);
        assert_eq!(found.windows.len(), 3 * 12);
        assert!(found.windows.iter().all(|w| !w.off));
    }
}

#[test]
fn a_payload_is_seen_dated_and_named() {
    let heavy = craft(&[("inertia@surge", 340.0), ("inertia@sway", 410.0)]);
    let found = watched(sail(&[(0.0, craft(&[]), 1.0), (48.0, heavy, 1.0)], 96.0, 1));
    assert!(!found.fits);
    let surge = found.changes.iter().find(|c| c.dof == Dof::Surge).expect("surge has changed");
    // dated to within one window of 8 s
    assert!((surge.from - 48.0).abs() < 8.5, "{surge:?}");
    assert!(found.windows.iter().filter(|w| w.to < 47.0).all(|w| !w.off), "nothing before it");
    let first = &found.reasons[0];
    assert!(first.id.contains("inertia@surge") && first.known, "{:?}", found.reasons);
    assert!(first.meaning.contains("payload") && first.explained > 0.9, "{first:?}");
    // 250 + 90; the estimate is of first order, and the change is not small
    assert!((first.after.expect("a value") - 340.0).abs() < 35.0, "{first:?}");
    assert_eq!(found.warnings[0].code, "W001");
}

#[test]
fn a_failing_thruster_is_told_from_a_payload() {
    let found = watched(sail(&[(0.0, craft(&[]), 1.0), (40.0, craft(&[]), 0.6)], 96.0, 2));
    let change = found.changes.iter().find(|c| c.dof == Dof::Surge).expect("surge has changed");
    assert!((change.from - 40.0).abs() < 8.5, "{change:?}");
    // the others change less, by the Coriolis forces
    assert!(found.changes.iter().all(|c| c.times_noise <= change.times_noise), "{:?}", found.changes);
    assert!(found.reasons[0].id.starts_with("thrust"), "{:?}", found.reasons);
    assert!(found.reasons[0].meaning.contains("thrust"));
}

#[test]
fn a_touch_that_passes_is_a_note() {
    let slow = craft(&[("quadratic_drag@surge", 500.0)]);
    let parts = [(0.0, craft(&[]), 1.0), (40.0, slow, 1.0), (44.0, craft(&[]), 1.0)];
    let found = watched(sail(&parts, 96.0, 3));
    assert!(found.fits, "{:?}", found.changes);
    assert!(found.warnings.iter().any(|w| w.code == "W002"), "{:?}", found.warnings);
}

/// A campaign of these runs, and its fit as a model file.
fn fitted(runs: Vec<Run>) -> (Campaign, ModelFile, Model) {
    let text = "format = 1\n[vehicle]\nmass = 200.0\n[model]\ndofs = ['surge', 'sway', 'yaw']\neffects = ['inertia', 'linear_drag', 'quadratic_drag', 'coriolis_surge', 'coriolis_sway', 'coriolis_yaw']\n[[run]]\nfile = 'a.csv'\n";
    let read = ReadOptions { look_for_files: false, ..ReadOptions::default() };
    let file = CampaignFile::from_bytes(text.as_bytes(), Path::new("campaign.toml"), &read).expect("a campaign");
    let campaign = Campaign::from_runs(file, runs).expect("it can be worked with");
    let fit = campaign::fit(&campaign, FitOptions::default()).expect("it can be fitted");
    let model = ModelFile { campaign: String::new(), ..ModelFile::of(&campaign, &fit) };
    (campaign, model, fit.model)
}

fn dives(model: &Model, seeds: &[u64]) -> Vec<Run> {
    let run = |seed: &u64| Run { role: Role::Train, ..sail(&[(0.0, model.clone(), 1.0)], 60.0, *seed) };
    seeds.iter().map(run).collect()
}

#[test]
fn two_models_of_one_vehicle_agree_and_a_changed_vehicle_is_told_apart() {
    let (_, spring, _) = fitted(dives(&craft(&[]), &[11, 12]));
    let (_, again, _) = fitted(dives(&craft(&[]), &[13, 14]));
    let (_, fouled, _) = fitted(dives(&craft(&[("quadratic_drag@surge", 150.0)]), &[15, 16]));
    let names = || ["spring".to_string(), "autumn".to_string()];
    let same = campaign::difference(&spring, &again, names());
    let joint = same.joint.expect("both were estimated");
    assert_eq!(joint.degrees_of_freedom, 9);
    // by chance this fails in 1 of 1000 cases; the seeds are fixed
    assert!(joint.p_value > 1e-3, "{joint:?}");
    let other = campaign::difference(&spring, &fouled, names());
    assert!(other.joint.expect("both were estimated").p_value < 1e-6, "{:?}", other.joint);
    let drag = other.parameters.iter().find(|p| p.effect == "quadratic_drag@surge").expect("both have it");
    let [low, high] = drag.interval.expect("an interval");
    assert!(low < 30.0 && 30.0 < high && low > 0.0, "{drag:?}");
    assert!(other.warnings.iter().any(|w| w.code == "M117" && w.message.contains("quadratic_drag@surge")));
}

/// A new log with commands of thrusters and with renamed columns is read as in the fit, by the
/// model file alone, without the campaign.
#[test]
fn a_new_log_is_read_as_those_of_the_fit_were() {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("monitor_alone");
    let sea = plant::Campaign {
        commands: plant::Commands::Thrusters,
        force: plant::RandomForce { share: 0.02, correlation: 1.0 },
        duration: 40.0,
        seed: 307,
        ..plant::Campaign::new(plant::Vehicle::named("small").expect("the plant has it"), &plant::Dof::PLANE)
    };
    sea.sail().expect("it sails").write(&folder).expect("it is written");
    let file = folder.join("campaign.toml");
    let text = std::fs::read_to_string(&file).expect("it was written");
    std::fs::write(&file, text.replace("[log]\n", "[log]\ncolumns = { u = \"surge_vel\" }\n")).expect("it is changed");
    for k in 0..sea.runs {
        let log = folder.join(format!("run{k:02}.csv"));
        let text = std::fs::read_to_string(&log).expect("it was written");
        assert!(text.lines().next().is_some_and(|header| header.contains("V1") && header.contains(",u [m/s]")));
        std::fs::write(&log, text.replacen(",u [m/s]", ",surge_vel [m/s]", 1)).expect("it is changed");
    }
    let campaign = Campaign::load(&file, LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    let fit = campaign::fit(&campaign, FitOptions::default()).expect("it can be fitted");
    let path = Path::new("model.toml");
    let told = ModelFile::of(&campaign, &fit).to_text(path).expect("a text");
    let known = ModelFile::from_text(&told, path).expect("its own text");
    let dive = folder.join("run08.csv");
    let alone = campaign::new_logs(&known, &[&dive], None, None).unwrap_or_else(|e| panic!("{e}"));
    let model = known.model(&alone.runs, path).expect("a model that needs no campaign");
    let found = campaign::monitor(&alone, &model, &known.envelope, &MonitorOptions::default()).expect("it is watched");
    assert!(found.watch.fits && !found.watch.windows.is_empty(), "{:?}", found.watch.warnings);
    // the commands of the thrusters become the same force as in the fit
    let [there, here] = [&campaign.runs[8], &alone.runs[0]].map(|run| run.signal("tau_u").expect("thrusters make it"));
    assert_eq!(there.values(), here.values());
}

#[test]
fn published_parameters_stand_beside_the_own_ones() {
    let (campaign, _, own) = fitted(dives(&craft(&[]), &[21, 22]));
    let path = Path::new("literature.toml");
    let sname = "format = 1\nconvention = 'sname'\nsource = 'a paper'\n[parameters]\n'X_udot' = -50.0\n'X_u|u|' = { value = -180.0, std = 5.0 }\n'X_u' = -20.0\n'N_r|r|' = -40.0\n";
    let published = Published::parse(sname, path, &campaign).expect("it can be read");
    let found = campaign::compare_published(&campaign, &own, &BTreeMap::new(), &published, path).expect("it compares");
    let of = |term: &str| found.parameters.iter().find(|p| p.effect == term).expect("it is listed").clone();
    // 200 kg dry mass and 50 kg added mass
    assert_eq!(of("inertia@surge").published, Some(250.0));
    let drag = of("quadratic_drag@surge");
    assert_eq!((drag.published, drag.published_std, drag.sname.as_deref()), (Some(180.0), Some(5.0), Some("X_u|u|")));
    assert!(drag.z.expect("both are known") > 4.0 && drag.p_value.expect("it follows") < 1e-4, "{drag:?}");
    assert!(of("inertia@surge").z.expect("both are known").abs() < 4.0);
    assert_eq!(of("quadratic_drag@sway").published, None);
    assert!(found.warnings.iter().any(|w| w.code == "M115"));
    let rms = |rows: &[hydrosysid::compare::Disagreement]| {
        rows.iter().filter(|r| r.dof == Dof::Surge).map(|r| r.rms).fold(0.0, f64::max)
    };
    assert!(rms(&found.runs) > 3.0 * rms(&found.own_runs), "the wrong drag shows in surge");

    let fossen = "format = 1\nconvention = 'fossen'\nM_A = [50, 120, 0, 0, 0, 10]\nM_RB = [200, 200, 200, 40, 45, 50]\nD = [20, 35, 0, 0, 0, 15]\nD_n = [120, 260, 0, 0, 0, 40]\n";
    let published = Published::parse(fossen, path, &campaign).expect("it can be read");
    let found = campaign::compare_published(&campaign, &own, &BTreeMap::new(), &published, path).expect("it compares");
    let truth = craft(&[]);
    for p in &found.parameters {
        let expected = truth.value(&p.effect).expect("the craft has it");
        assert!((p.published.expect("all are given") - expected).abs() < 1e-9, "{p:?}");
    }
}

#[test]
fn what_a_file_of_parameters_gets_wrong_is_named() {
    let (campaign, ..) = fitted(dives(&craft(&[]), &[31]));
    let refused = |text: &str| {
        let text = format!("format = 1\n{text}");
        Published::parse(&text, Path::new("p.toml"), &campaign).expect_err("it is wrong").to_string()
    };
    assert!(refused("convention = 'sname'\n[parameters]\n'X_u|v|' = -1").contains("X_u|v|"));
    assert!(refused("convention = 'sname'\n[parameters]\n'N_rdot' = -1").contains("dry `inertia`"));
    assert!(refused("convention = 'fossen'\n").contains("M_A"));
    assert!(refused("convention = 'sname'\nD = [1,1,1,1,1,1]\n").contains("fossen"));
    assert!(refused("convention = 'ship'\n").contains("p.toml"));
    assert!(refused("convention = 'sname'\n[parameters]\n'X_u' = nan").contains("finite"));
}

#[test]
fn a_log_without_a_heading_is_searched_for_what_needs_none() {
    let runs: Vec<Run> = dives(&craft(&[("linear_drag@surge", 20.0)]), &[41, 42]);
    let mut baseline = craft(&[]);
    let drag = baseline.term("quadratic_drag@surge").expect("it is there");
    baseline.remove(drag);
    let found = hydrosysid::discover::discover(
        &baseline,
        &runs,
        &[],
        &hydrosysid::estimate::filter_error::FilterErrorOptions::default(),
        &hydrosysid::discover::SearchOptions::default(),
    )
    .expect("a current needs the heading, and is left out");
    assert_eq!(found.effects[0].id, "quadratic_drag@surge");
}
