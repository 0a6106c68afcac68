//! Degrees of freedom that no run excites, and commands with steps: the errors and warnings on such
//! campaigns.

use std::path::Path;
use std::process::Command;
use std::sync::Arc;

use hydrosysid::campaign::file::{CampaignFile, ReadOptions};
use hydrosysid::campaign::{self, Campaign, Error, Estimator, FitOptions, LoadOptions};
use hydrosysid::discover::Verdict;
use hydrosysid::noise::Noise;
use hydrosysid::run::{Run, Signal};
use hydrosysid_plant::{Campaign as Sea, Dof as Axis, Hidden, Manoeuvre, RandomForce, Suite, Vehicle};

const MASS: f64 = 300.0;
const DRAG: f64 = 90.0;

/// A run that drives surge only, by a sine or by steps of 4 s; the other sensors log their noise.
fn run(steps: bool) -> Run {
    let (step, count) = (0.1, 900);
    let mut draw = Noise::new(2, 0);
    let force = |t: f64| match steps {
        true => 60.0 * [1.0, -0.5, 0.7, -1.0, 0.2][(t / 4.0) as usize % 5],
        false => 60.0 * (0.7 * t).sin(),
    };
    let time: Arc<[f64]> = (0..count).map(|k| step * f64::from(k)).collect();
    let mut u = 0.0;
    let mut speeds = Vec::new();
    for t in time.iter() {
        speeds.push(u + 0.002 * draw.normal());
        for sub in 0..20 {
            let h = step / 20.0;
            u += h * (force(t + h * (f64::from(sub) + 0.5)) - DRAG * u) / MASS;
        }
    }
    let quiet = |size: f64, draw: &mut Noise| (0..count).map(|_| size * draw.normal()).collect::<Vec<f64>>();
    let mut run = Run { name: "surge.csv".into(), ..Run::default() };
    let channels = [
        ("u", speeds),
        ("v", quiet(0.002, &mut draw)),
        ("r", quiet(0.001, &mut draw)),
        ("tau_u", time.iter().map(|t| force(*t)).collect()),
        ("tau_v", vec![0.0; count as usize]),
        ("tau_r", vec![0.0; count as usize]),
    ];
    for (name, values) in channels {
        run.signals.insert(name.into(), Signal::new(time.clone(), values));
    }
    run
}

fn campaign(dofs: &str, more: &str, run: Run) -> Campaign {
    campaign_of("'inertia', 'linear_drag'", dofs, more, run)
}

fn campaign_of(effects: &str, dofs: &str, more: &str, run: Run) -> Campaign {
    let text =
        format!("format = 1\n[model]\ndofs = [{dofs}]\neffects = [{effects}]\n{more}\n[[run]]\nfile = 'surge.csv'\n");
    let options = ReadOptions { look_for_files: false, ..ReadOptions::default() };
    let file = CampaignFile::from_bytes(text.as_bytes(), Path::new("rest.toml"), &options);
    Campaign::from_runs(file.unwrap_or_else(|e| panic!("{e}")), vec![run]).unwrap_or_else(|e| panic!("{e}"))
}

const ESTIMATORS: [Estimator; 3] = [Estimator::Integral, Estimator::OutputError, Estimator::FilterError];

#[test]
fn surge_alone_is_no_campaign_of_three_degrees_of_freedom() {
    let three = campaign("'surge', 'sway', 'yaw'", "", run(false));
    for estimator in ESTIMATORS {
        let error = campaign::fit(&three, FitOptions { estimator: Some(estimator) }).expect_err("two are at rest");
        let Error::Refused { findings } = error else { panic!("{error}") };
        assert_eq!((findings.len(), findings[0].code), (1, campaign::codes::NOT_EXCITED.code));
        let text = &findings[0].message;
        assert!(text.starts_with("sway, yaw: ") && text.contains("dofs = [\"surge\"]"), "{text}");
    }
    let one = campaign("'surge'", "", run(false));
    let fit = campaign::fit(&one, FitOptions { estimator: Some(Estimator::OutputError) }).expect("the line to write");
    let mass = &fit.parameters[0];
    assert!((mass.value - MASS).abs() < 5.0, "{}", mass.value);
}

/// If pitch is neither modelled nor logged, a fit refuses a coupling with it; a search fixes the
/// coupling, continues and warns of it.
#[test]
fn a_search_holds_what_no_run_shows() {
    let coupled = campaign_of("'inertia', 'linear_drag', 'added_mass_coupling@surge:pitch'", "'surge'", "", run(false));
    let refused = campaign::fit(&coupled, FitOptions { estimator: Some(Estimator::FilterError) });
    assert!(refused.is_err_and(|e| e.to_string().contains("m_uq of added_mass_coupling@surge:pitch")));
    let found = campaign::discover(&coupled).expect("the coupling is held");
    let told: Vec<_> = found.warnings.iter().filter(|w| w.code == campaign::codes::UNSEEN.code).collect();
    assert_eq!(told.len(), 1, "{:?}", found.warnings);
    assert!(told[0].message.contains("held m_uq of `added_mass_coupling@surge:pitch` at "), "{}", told[0].message);
    let model = found.model().expect("a baseline");
    let mass = model.value("inertia@surge").expect("it is fitted");
    assert!((mass - MASS).abs() < 5.0, "{mass}");
}

/// Nothing commands the yaw; a Munk moment that the model lacks turns the vehicle. A fit refuses
/// the inertia in yaw. A search gives it a prior with a standard deviation as large as its value,
/// warns of it, and names the Munk moment or lists it as similar.
#[test]
fn a_search_goes_on_without_the_scale_of_a_moment() {
    let mut sea = Sea::new(Vehicle::named("small").expect("it exists"), &Axis::PLANE);
    (sea.runs, sea.duration, sea.seed) = (4, 30.0, 61_301);
    sea.force = RandomForce { share: 0.02, correlation: 1.0 };
    sea.manoeuvres = vec![Manoeuvre::Alone(Axis::Surge, 0.6, 0.3), Manoeuvre::Alone(Axis::Sway, 0.6, 0.0)];
    sea.hidden = vec![Hidden::new("coriolis_yaw")];
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("no_moment");
    sea.sail().expect("it sails").write(&folder).expect("the folder can be written");
    let campaign = Campaign::load(&folder.join("campaign.toml"), LoadOptions::default()).expect("it is a campaign");
    let refused = campaign::fit(&campaign, FitOptions::default());
    assert!(refused.is_err_and(|e| e.to_string().contains("I_r")));
    let found = campaign::discover(&campaign).expect("the inertia is taken to be of its own size");
    let said = found.warnings.iter().find(|w| w.code == campaign::codes::UNSEEN.code).expect("it is said");
    assert!(said.message.contains("held I_r of `inertia@yaw` near "), "{}", said.message);
    let told = found.effects.iter().map(|e| &e.id).chain(found.behaves_like.iter().map(|b| &b.id));
    assert!(told.clone().any(|id| id == "coriolis_yaw"), "{:?}", told.collect::<Vec<_>>());
}

/// If the vehicle turns only in the held-out zig-zags, a fit is refused and names the runs that
/// would excite the yaw. In a search the first of them takes part in the fit, and the other remains
/// held out.
#[test]
fn a_search_takes_in_a_held_out_run_that_moves_what_none_of_the_fit_does() {
    let mut sea = Sea::new(Vehicle::named("small").expect("it exists"), &Axis::PLANE);
    (sea.runs, sea.duration, sea.seed) = (6, 30.0, 61_302);
    let alone = |dof| Manoeuvre::Alone(dof, 0.6, 0.0);
    sea.manoeuvres = [alone(Axis::Surge), alone(Axis::Sway)].repeat(2);
    sea.manoeuvres.extend([Manoeuvre::Zigzag(0.6); 2]);
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("no_turn");
    sea.sail().expect("it sails").write(&folder).expect("the folder can be written");
    let campaign = Campaign::load(&folder.join("campaign.toml"), LoadOptions::default()).expect("it is a campaign");
    let refused = campaign::fit(&campaign, FitOptions::default()).expect_err("the yaw is at rest").to_string();
    assert!(refused.contains("yaw: ") && refused.contains("run04.csv, run05.csv, which are held out"), "{refused}");
    let found = campaign::discover(&campaign).expect("a zig-zag takes part");
    assert_eq!(found.took_part, ["run04.csv"]);
    assert_eq!(found.verdict, Verdict::NothingMissing, "{}", found.sentence);
    let said = found.warnings.iter().find(|w| w.message.contains("took part in the fit")).expect("it is said");
    assert!(said.message.contains("no run of the fit moves yaw"), "{}", said.message);
    // there is no effect to adopt, but the role of a run is changed
    let command = |verb: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_hydrosysid"));
        command.arg(verb).arg(&folder);
        command
    };
    let adopted = command("discover").arg("--adopt").output().expect("it starts");
    let told = String::from_utf8_lossy(&adopted.stdout).into_owned();
    assert!(told.contains("has role = \"train\" for run04.csv now"), "{told}");
    assert!(command("fit").output().expect("it starts").status.success());
}

#[test]
fn parameters_that_are_held_need_no_motion() {
    let held = ["inertia@sway", "inertia@yaw", "linear_drag@sway", "linear_drag@yaw"]
        .map(|name| format!("[[parameter]]\neffect = '{name}'\nvalue = 400.0\nfixed = true\n"));
    let three = campaign("'surge', 'sway', 'yaw'", &held.concat(), run(false));
    campaign::fit(&three, FitOptions { estimator: Some(Estimator::OutputError) }).expect("nothing is asked of them");
}

/// If all parameters are fixed, the fit only estimates the noise.
#[test]
fn a_model_of_which_all_is_held_has_its_noise_estimated() {
    let held = [("inertia@surge", MASS), ("linear_drag@surge", DRAG)]
        .map(|(name, value)| format!("[[parameter]]\neffect = '{name}'\nvalue = {value}\nfixed = true\n"));
    let all = campaign("'surge'", &held.concat(), run(false));
    for estimator in [Estimator::FilterError, Estimator::OutputError] {
        let fit = campaign::fit(&all, FitOptions { estimator: Some(estimator) }).expect("there is nothing to find");
        assert!(fit.parameters.iter().all(|p| p.fixed && p.std.is_none_or(|std| std == 0.0)), "{:?}", fit.parameters);
    }
}

#[test]
fn steps_that_are_read_as_lines_are_told() {
    let told = |more: &str, steps: bool| {
        let campaign = campaign("'surge'", more, run(steps));
        let found = campaign.findings.iter().find(|f| f.code == campaign::codes::STEPS_AS_LINES.code);
        found.map(|f| f.message.clone())
    };
    let text = told("", true).expect("steps under input = \"linear\"");
    assert!(text.contains("tau_u") && text.contains("input = \"hold\""), "{text}");
    assert_eq!(told("input = 'hold'", true), None);
    assert_eq!(told("", false), None, "a sine");
}

/// If the scale of the thrust is free like all other parameters, every estimator reports that, and
/// does not advise to add a run.
#[test]
fn no_known_force_is_told_by_every_estimator() {
    let campaign = campaign_of("'inertia', 'linear_drag', 'thrust_interaction_loss'", "'surge'", "", run(false));
    for estimator in ESTIMATORS {
        let error = campaign::fit(&campaign, FitOptions { estimator: Some(estimator) }).expect_err("nothing is known");
        assert_eq!(error.findings()[0].code, campaign::codes::NO_SCALE.code, "{estimator:?}: {error}");
    }
}

/// Third differences take coloured noise for motion. The inertias that the data do not determine
/// are named first in the verdict of the fit.
#[test]
fn an_inertia_that_the_data_does_not_tell_comes_first() {
    let mut sea = Sea::new(Vehicle::named("laurs").expect("it exists"), &Axis::PLANE);
    (sea.runs, sea.duration, sea.seed) = (6, 40.0, 3);
    sea.manoeuvres = vec![Manoeuvre::Alone(Axis::Surge, 0.6, 0.0)];
    sea.instruments = Suite { colour: 0.8, ..Suite::default() }.instruments(&Axis::PLANE);
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("coloured");
    sea.sail().expect("it sails").write(&folder).expect("the folder can be written");
    let campaign = Campaign::load(&folder.join("campaign.toml"), LoadOptions::default()).expect("it is a campaign");
    let fit = campaign::fit(&campaign, FitOptions::default()).expect("it can be fitted");
    let sentence = &fit.sentence;
    assert!(
        sentence.starts_with("Do not use these numbers for sway and yaw: this data does not determine m_v"),
        "{sentence}"
    );
}
