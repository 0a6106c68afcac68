//! Discovery on campaigns of the independent plant in which an effect is hidden under a random force, and on campaigns in
//! which nothing is. A few cases each; the statistics over many seeds are in `docs/blind.md`.

use std::path::PathBuf;

use hydrosysid::campaign::{self, Adoption, Campaign, FitOptions, LoadOptions, ModelFile, PlanRequest, PlanSource};
use hydrosysid::discover::{Discovery, Verdict};
use hydrosysid_plant::{Campaign as Sea, Commands, Dof, Hidden, Input, Manoeuvre, Pilots, RandomForce, Suite, Vehicle};

use crate::shared;

/// A planar campaign of the plant under a random force of this share of the commanded one, correlation 1 s.
pub fn sea(vehicle: &str, force: f64, hidden: &[&str], seed: u64) -> Sea {
    let vehicle = Vehicle::named(vehicle).expect("the plant has this vehicle");
    let force = RandomForce { share: force, correlation: 1.0 };
    let hidden = hidden.iter().map(|name| Hidden::new(name)).collect();
    // the speed of a test without optimisation: short runs, half of the usual rate
    let instruments = Suite { rate: 5.0, ..Suite::default() }.instruments(&Dof::PLANE);
    Sea { force, hidden, instruments, seed, duration: 40.0, ..Sea::new(vehicle, &Dof::PLANE) }
}

/// The answer of the search on a campaign of the plant that is written to the folder `name`.
pub fn answer(name: &str, sea: &Sea) -> Discovery {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("discovery_{name}"));
    sea.sail().expect("the plant sails").write(&folder).expect("the folder is written");
    let loaded = Campaign::load(&folder.join("campaign.toml"), LoadOptions::default()).expect("a campaign");
    campaign::discover(&loaded).expect("a fit")
}

/// The names of the effects that were found.
pub fn names(found: &Discovery) -> Vec<&str> {
    found.effects.iter().map(|e| e.id.as_str()).collect()
}

#[test]
fn blind_nothing_hidden_is_nothing_missing_beyond_a_random_force() {
    let found = answer("null", &sea("laurs", 0.05, &[], 201));
    assert_eq!((names(&found), found.verdict), (vec![], Verdict::NothingMissing), "{}", found.sentence);
    assert!(found.sentence.starts_with("Nothing is missing beyond a random force of"), "{}", found.sentence);
    assert_eq!(found.gap[0].force.len(), 3, "{:?}", found.gap[0].force);
    assert!(!found.smallest_visible.is_empty(), "a null says what it could have shown");
}

/// One wrong sample in a hundred and no random force: innovations are held back, and held-out runs that are predicted no better
/// with a friction say so, with the noise of either model estimated on them, too.
#[test]
fn blind_outliers_are_no_friction() {
    let mut sea = sea("small", 0.0, &["cross_drag@yaw:sway"], 9_103);
    sea.instruments = Suite { rate: 10.0, noise: 3.0, dvl_rate: Some(4.0), outliers: 0.01, ..Suite::default() }
        .instruments(&Dof::PLANE);
    sea.runs = 10;
    let found = answer("outliers", &sea);
    assert_eq!((names(&found), found.verdict), (vec!["cross_drag@yaw:sway"], Verdict::Explained), "{}", found.sentence);
}

/// Without a random force a filter that takes its parameters for exact is lost on one run of nine, which would speak against
/// the truth: elsewhere than where it was fitted it expects a little.
#[test]
fn blind_a_name_under_no_force_is_borne_out_by_unstable_runs() {
    let mut sea = sea("small", 0.0, &["thruster_fault@yaw"], 7_112);
    sea.instruments = Suite { rate: 10.0, noise: 3.0, position: false, ..Suite::default() }.instruments(&Dof::PLANE);
    (sea.runs, sea.duration, sea.lead_in) = (9, 90.0, 5.0);
    (sea.pilots, sea.input) = (Pilots::Closed, Input::Linear);
    let found = answer("lost", &sea);
    assert_eq!((names(&found), found.verdict), (vec!["thruster_fault@yaw"], Verdict::Explained), "{}", found.sentence);
}

/// Where a random force is a hundred times what is commanded nothing is named, and it is said what to do about it.
#[test]
fn blind_a_vehicle_that_its_commands_do_not_move_has_no_names() {
    let found = answer("adrift", &sea("laurs", 100.0, &[], 209));
    assert_eq!((names(&found), found.verdict), (vec![], Verdict::Unexplained), "{}", found.sentence);
    assert!(
        found.sentence.starts_with("Nothing can be named: the commands do not dominate the motion"),
        "{}",
        found.sentence
    );
    let next = found.next_experiment.as_deref().unwrap_or_default();
    assert!(next.starts_with("Drive ") && !found.moved_otherwise.is_empty(), "{next}");
    assert!(found.warnings.iter().all(|w| w.code != "D107") && found.changed_parameter.is_none());
}

/// A Munk moment under a random force of 2 %, on the vehicle that it makes unstable: named, within four deviations of the
/// truth, and the random force falls once it is known.
#[test]
fn blind_an_effect_under_a_random_force_is_named() {
    let sea = sea("small", 0.02, &["coriolis_yaw"], 202);
    let found = answer("munk", &sea);
    assert_eq!((names(&found), found.verdict), (vec!["coriolis_yaw"], Verdict::Explained), "{}", found.sentence);
    assert!(found.sentence.contains("the Munk moment"), "{}", found.sentence);
    let truth = sea.sail().expect("the plant sails").truth.value("coriolis_yaw");
    let found_one = &found.effects[0].parameters[0];
    if let Some(truth) = truth {
        assert!((found_one.value - truth).abs() < 4.0 * found_one.std, "{found_one:?}, true {truth}");
    }
    let force = |k: usize| found.gap[k].force.iter().find(|f| f.dof.name() == "yaw").map_or(0.0, |f| f.rms);
    assert!(force(1) < 0.7 * force(0), "{} N m, then {}", force(0), force(1));
}

/// What no run of the fit moves has no model that could lack anything: it is refused as a fit refuses it.
#[test]
fn blind_what_no_run_moves_is_refused() {
    let manoeuvres = vec![Manoeuvre::Alone(Dof::Surge, 0.4, 0.0), Manoeuvre::Alone(Dof::Sway, 0.4, 0.0)];
    let sea = Sea { manoeuvres, ..sea("laurs", 0.0, &[], 210) };
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("discovery_at_rest");
    sea.sail().expect("the plant sails").write(&folder).expect("the folder is written");
    let loaded = Campaign::load(&folder.join("campaign.toml"), LoadOptions::default()).expect("a campaign");
    let refused = campaign::discover(&loaded).map(|found| found.sentence).expect_err("yaw rests").to_string();
    assert!(refused.contains("in no run of the fit") && refused.contains("dofs = [\"surge\", \"sway\"]"), "{refused}");
    let of_fit = campaign::fit(&loaded, FitOptions::default()).map(|fit| fit.sentence).expect_err("yaw rests");
    assert_eq!(of_fit.to_string(), refused);
}

/// A wave leaves the small vehicle without a random force, and its phase in the second half of a held-out run is known from the
/// first: it is named, though what little that is off is a force where the fit has left none. Each run shows its own part of it.
#[test]
fn blind_a_wave_is_named_where_it_is_all_that_pushes() {
    let instruments = Suite { rate: 5.0, position: false, ..Suite::default() }.instruments(&Dof::PLANE);
    let found = answer("wave", &Sea { instruments, runs: 4, ..sea("small", 0.0, &["wave@sway"], 94101) });
    assert_eq!((names(&found), found.verdict), (vec!["wave@sway"], Verdict::Explained), "{}", found.sentence);
    let [a, b, period] = found.effects[0].parameters.as_slice() else { panic!("{:?}", found.effects[0]) };
    // what the plant hides: 1.8 N every 5 s, of another phase in every run
    assert!((period.value - 5.0).abs() < 4.0 * period.std && period.range().is_none(), "{period:?}");
    for (a, b) in a.per_run.iter().zip(&b.per_run) {
        assert!((a.hypot(*b) - 1.8).abs() < 0.1, "{a} {b}");
    }
    let (least, most) = a.range().expect("each run has its own");
    assert!(least < a.value && a.value < most && a.per_run.len() > 1, "{a:?}");
}

/// What has a value of its own in every run is asked last, and a memory of the wake may come before it: beside the wave nothing is left
/// of that, and it goes.
#[test]
fn blind_a_wave_is_named_though_a_memory_came_before_it() {
    let instruments = Suite::default().instruments(&Dof::PLANE);
    let sea = Sea { instruments, duration: 60.0, ..sea("small", 0.02, &["wave@sway"], 2_940_001) };
    let found = answer("wave_last", &sea);
    assert_eq!((names(&found), found.verdict), (vec!["wave@sway"], Verdict::Explained), "{}", found.sentence);
}

/// A vehicle that turns by itself, four runs of the fit and no random force: the fit with the name, begun at the values of the model
/// that lacked it, ends on a hill below the top, and what is left there is no second name but a better start.
#[test]
fn blind_a_misaligned_dvl_is_named_from_few_runs() {
    let found = answer("few_runs", &Sea { runs: 6, ..sea("small", 0.0, &["sensor_dvl_misalignment"], 7_702) });
    let named = (names(&found), found.verdict);
    assert_eq!(named, (vec!["sensor_dvl_misalignment"], Verdict::Explained), "{}", found.sentence);
    let angle = &found.effects[0].parameters[0];
    assert!((angle.value - 5f64.to_radians()).abs() < 4.0 * angle.std, "{angle:?}");
}

/// The deviation of a compass holds its offset, and by what its other parameters are off it came first on a held-out run: what
/// fewer parameters tell as well they tell.
#[test]
fn blind_an_offset_of_the_compass_is_no_deviation() {
    let found = answer("offset", &Sea { runs: 6, ..sea("laurs", 0.0, &["sensor_heading_offset"], 8_813) });
    let named = (names(&found), found.verdict);
    assert_eq!(named, (vec!["sensor_heading_offset"], Verdict::Explained), "{}", found.sentence);
}

/// A thruster that fails in the middle of a run is named, with its instant and how much of it is lost.
#[test]
fn blind_a_thruster_that_fails_is_found_with_its_instant() {
    // of the second the model without it puts the instant 6 s off, on a hill of its own
    for (vehicle, seed) in [("laurs", 205), ("small", 71_001)] {
        let sea = sea(vehicle, 0.02, &["thruster_fault@surge"], seed);
        let found = answer(&format!("fault-{vehicle}"), &sea);
        assert_eq!(
            (names(&found), found.verdict),
            (vec!["thruster_fault@surge"], Verdict::Explained),
            "{}",
            found.sentence
        );
        let [loss, instant] = found.effects[0].parameters.as_slice() else { panic!("{:?}", found.effects[0]) };
        // what the plant hides: 0.4 of the thrust from 0.45 of the run on
        assert!((loss.value - 0.4).abs() < 4.0 * loss.std, "{loss:?}");
        assert!((instant.value - 0.45 * sea.duration).abs() < (4.0 * instant.std).max(0.1), "{instant:?}");
        // a fit of the campaign with the name in it comes to the same instant
        let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("discovery_fault-{vehicle}"));
        let file = campaign::adopt(&folder, None, &Adoption::from(&found)).expect("the name goes in");
        let complete = Campaign::load(&file, LoadOptions::default()).expect("a campaign");
        let fit = campaign::fit(&complete, FitOptions::default()).expect("a fit");
        let again = fit.model.parameters.iter().find(|p| p.spec.name == "t_faultu").expect("it is in the model");
        assert!((again.value - instant.value).abs() < instant.std, "{again:?} {instant:?}");
    }
}

/// Thrusters are named one by one where a campaign describes them: which is dead, which two are exchanged. The names go into
/// the campaign, and from there into a model file that stands for itself.
#[test]
fn blind_single_thrusters_are_named() {
    for (name, hidden) in [("dead", "thruster_loss@T3"), ("exchanged", "thruster_swap@T2:T3")] {
        let sea = Sea { commands: Commands::Thrusters, ..sea("small", 0.02, &[hidden], 206) };
        let found = answer(name, &sea);
        assert_eq!((names(&found), found.verdict), (vec![hidden], Verdict::Explained), "{}", found.sentence);
        let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("discovery_{name}"));
        let file = campaign::adopt(&folder, None, &Adoption::from(&found)).expect("the names go in");
        let complete = Campaign::load(&file, LoadOptions::default()).expect("a campaign");
        let fit = campaign::fit(&complete, FitOptions::default()).expect("a fit");
        let source = PlanSource::of_fit(&complete, &fit);
        let refused = campaign::plan(&source, &PlanRequest::default(), &|| {}).expect_err("a plan drives no thrusters");
        assert!(refused.to_string().contains("single thrusters"), "{refused}");
        for path in ["model.toml", "model.json"].map(PathBuf::from) {
            let text = ModelFile::of(&complete, &fit).to_text(&path).expect("a text");
            let read = ModelFile::from_text(&text, &path).expect("its own text").model(&complete.runs, &path);
            let read = read.expect("a model that needs no campaign");
            assert_eq!(read.values(), fit.model.values());
            assert!(read.term(hidden).is_some(), "{text}");
        }
    }
}

/// What begins at an instant, or acts in one run alone, is no name for all runs: a thruster that loses 0.7 of its thrust in the
/// middle of a run, and one whose wires are exchanged in the last run of the fit, which is reversed.
#[test]
fn blind_a_thruster_that_changes_is_told_with_run_and_instant() {
    for (vehicle, hidden, share) in [("laurs", "thruster_failure@T2", 0.7), ("small", "swapped_wire", 2.0)] {
        let sea = Sea { commands: Commands::Thrusters, duration: 60.0, ..sea(vehicle, 0.02, &[hidden], 211) };
        let found = answer(&format!("changes-{hidden}"), &sea);
        assert_eq!((names(&found), found.verdict), (vec![], Verdict::Unexplained), "{}", found.sentence);
        let changed = found.changed_parameter.as_ref().expect("it is told");
        assert!(changed.absent && changed.parameter == "thruster_loss@T2 k_loss", "{changed:?}");
        // forces astern are others than those ahead, of which the reversed one has the opposite
        let allowed = if hidden == "swapped_wire" { 0.3 } else { 4.0 * changed.std };
        assert!((changed.change - share).abs() < allowed, "{changed:?}");
        assert_eq!(changed.from.is_none(), hidden == "swapped_wire", "{changed:?}");
        assert!(found.sentence.starts_with("Something has changed: "), "{}", found.sentence);
    }
}

/// What changes the whole vehicle at an instant is told as one change with its instant: weed, a weak battery, a payload. Three
/// standard deviations of it, and a second: the plant changes between two samples, of 0.2 s each.
#[test]
fn blind_a_property_that_changes_is_told_with_its_instant() {
    for (hidden, property, share) in
        [("drag_step", "drag", Some(0.4)), ("thrust_step", "thrust", Some(-0.25)), ("mass_step", "mass", None)]
    {
        let sea = Sea { commands: Commands::Thrusters, ..sea("laurs", 0.02, &[hidden], 215) };
        let found = answer(&format!("property-{property}"), &sea);
        assert_eq!((names(&found), found.verdict), (vec![], Verdict::Unexplained), "{}", found.sentence);
        let changed = found.changed_parameter.as_ref().expect("it is told");
        assert!(changed.alone && changed.parameter == property && changed.relative == share.is_some(), "{changed:?}");
        let truth = sea.sail().expect("the plant sails").truth;
        // a payload of 0.15 times the inertia in surge
        let expected = share.or(truth.value("inertia@surge").map(|m| 0.15 * m)).expect("it has a mass");
        assert!((changed.change - expected).abs() < 3.0 * changed.std, "{changed:?}, {expected}");
        assert!(changed.std < 0.1 * expected.abs(), "{changed:?}");
        let words = format!(" on, the {property} is ");
        assert!(found.sentence.starts_with("Something has changed: from "), "{}", found.sentence);
        assert!(found.sentence.contains(&words), "{}", found.sentence);
        let codes: Vec<&str> = found.warnings.iter().map(|w| w.code).collect();
        assert!(codes.contains(&"D111") && !codes.contains(&"D107"), "{codes:?}");
    }
}

/// An effect that is missing all along is named, and a drag that steps besides is told beside the name.
#[test]
fn blind_a_drag_that_steps_is_told_beside_a_name() {
    let sea = Sea { commands: Commands::Thrusters, ..sea("laurs", 0.02, &["coriolis_yaw", "drag_step"], 216) };
    let found = answer("name-and-step", &sea);
    assert_eq!((names(&found), found.verdict), (vec!["coriolis_yaw"], Verdict::PartlyExplained), "{}", found.sentence);
    let changed = found.changed_parameter.as_ref().expect("it is told");
    assert!(changed.parameter == "drag" && (changed.change - 0.4).abs() < 3.0 * changed.std, "{changed:?}");
    assert!(found.sentence.contains("; besides, something has changed: from "), "{}", found.sentence);
}

/// A force of the opposite sign in one log is a fault of that log, and is mended there alone.
#[test]
fn blind_a_force_that_is_turned_in_one_log_is_told() {
    let found = answer("turned", &sea("laurs", 0.02, &["swapped_wire"], 213));
    assert_eq!((names(&found), found.verdict), (vec![], Verdict::NothingMissing), "{}", found.sentence);
    assert!(
        found.sentence.starts_with("The log is wrong: in run05.csv tau_r acts the wrong way"),
        "{}",
        found.sentence
    );
    assert_eq!((found.log_findings[0].kind.as_str(), found.log_findings[0].channel.as_str()), ("sign", "tau_r"));
}

/// Every thruster loses thrust with its own speed: what turns the vehicle is weaker ahead, too, which no loss in a degree of
/// freedom says.
#[test]
fn blind_a_loss_of_each_thruster_with_its_speed_is_named() {
    let hidden = "thruster_advance_loss";
    let sea = Sea { commands: Commands::Thrusters, ..sea("laurs", 0.02, &[hidden], 212) };
    let found = answer("advance", &sea);
    assert_eq!((names(&found), found.verdict), (vec![hidden], Verdict::Explained), "{}", found.sentence);
    let truth = sea.sail().expect("the plant sails").truth.value(hidden).expect("it is hidden");
    let k = &found.effects[0].parameters[0];
    assert!((k.value - truth).abs() < 4.0 * k.std, "{k:?}, {truth}");
}

/// In the vertical plane −m_w w q stands in surge as + m_v v r does in the horizontal one: a baseline without it lacks
/// something that has a name, and one with it lacks nothing, however much more than those of the fit a run pitches.
#[test]
fn blind_the_vertical_plane_has_its_coriolis_force_too() {
    let plane = [Dof::Surge, Dof::Heave, Dof::Pitch];
    let instruments = Suite { rate: 5.0, ..Suite::default() }.instruments(&plane);
    let vehicle = Vehicle::named("heavy").expect("the plant has this vehicle");
    let sea = Sea { instruments, seed: 204, duration: 30.0, ..Sea::new(vehicle, &plane) };
    let found = answer("vertical", &sea);
    assert_eq!((names(&found), found.verdict), (vec![], Verdict::NothingMissing), "{}", found.sentence);
    let hidden = sea.sail().expect("the plant sails");
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("discovery_vertical");
    hidden.write(&folder).expect("the folder is written");
    let file = folder.join("campaign.toml");
    let text = std::fs::read_to_string(&file).expect("it was written");
    assert!(text.contains("\"coriolis_surge\", "), "{text}");
    std::fs::write(&file, text.replace("\"coriolis_surge\", ", "")).expect("it can be written");
    let lame = Campaign::load(&file, LoadOptions::default()).expect("a campaign");
    let found = campaign::discover(&lame).expect("a fit");
    assert_eq!((names(&found), found.verdict), (vec!["coriolis_surge"], Verdict::Explained), "{}", found.sentence);
}

/// A baseline without the righting moment makes no use of its commands, and its inertia runs away: no start for the moment
/// that is missing, which is named all the same (204), and alone (209: what its own hill left was named a wake memory).
#[test]
fn blind_a_righting_moment_is_named_beside_an_inertia_that_runs_away() {
    let plane = [Dof::Surge, Dof::Heave, Dof::Pitch];
    for seed in [204, 209] {
        let instruments = Suite { rate: 5.0, ..Suite::default() }.instruments(&plane);
        let vehicle = Vehicle::named("heavy").expect("the plant has this vehicle");
        let force = RandomForce { share: 0.02, correlation: 1.0 };
        let hidden = vec![Hidden::new("restoring_pitch")];
        let sea = Sea { force, hidden, instruments, seed, duration: 30.0, ..Sea::new(vehicle, &plane) };
        let found = answer(&format!("righting-{seed}"), &sea);
        assert_eq!((names(&found), found.verdict), (vec!["restoring_pitch"], Verdict::Explained), "{}", found.sentence);
        let moment = &found.effects[0].parameters[0];
        assert!((moment.value - 5.3374).abs() < 4.0 * moment.std, "{moment:?}");
    }
}

/// What no catalogue holds may look like a neighbour, but is not explained by a stranger.
#[test]
fn blind_an_effect_outside_the_catalogue_is_not_explained_by_a_stranger() {
    let found = answer("outside", &sea("laurs", 0.02, &["power_drag@surge"], 203));
    let neighbours = ["cubic_drag@surge", "linear_drag@surge", "coulomb_friction@surge"];
    let strangers = names(&found).iter().any(|name| !neighbours.contains(name));
    assert!(!(strangers && found.verdict == Verdict::Explained), "{}", found.sentence);
}

/// A drag that grows near the bed is nobody's name, and the model that is told holds what is named and nothing more: no stand-in is
/// left in its gap, among its terms, or in what is to be adopted.
#[test]
fn blind_stand_ins_are_not_in_the_model_that_is_told() {
    let sea = sea("laurs", 0.02, &["ground_effect"], 207);
    let found = answer("stand-ins", &sea);
    assert!(matches!(found.verdict, Verdict::Unexplained | Verdict::PartlyExplained), "{}", found.sentence);
    assert!(!found.behaves_like.is_empty(), "{}", found.sentence);
    let added: Vec<&str> = found.gap.iter().filter_map(|step| step.added.as_deref()).collect();
    assert_eq!(added, names(&found), "{}", found.sentence);
    let terms = |model: &hydrosysid::model::Model| model.terms.len();
    let more = terms(found.model().expect("a model")) - terms(&found.steps[0].fit.model);
    assert_eq!((more, found.adopt.len()), (found.effects.len(), found.effects.len()), "{:?}", found.adopt);
}

#[test]
fn example_campaigns_have_their_verdicts() {
    let Some(folder) = shared::path("example_campaigns") else { return };
    let verdict = |name: &str| {
        let loaded = Campaign::load(&folder.join(name).join("campaign.toml"), LoadOptions::default()).unwrap();
        campaign::discover(&loaded).unwrap()
    };
    let munk = verdict("munk_hidden");
    assert_eq!((names(&munk), munk.verdict), (vec!["coriolis_yaw"], Verdict::Explained), "{}", munk.sentence);
    // k_uv of the truth: 19.2734 − 17.0003 kg
    let k = &munk.effects[0].parameters[0];
    assert!((k.value - 2.2731).abs() < 4.0 * k.std, "{} ± {}", k.value, k.std);
    assert_eq!(verdict("nothing_hidden").verdict, Verdict::NothingMissing);
}

/// A yaw rate in degrees is a wrong unit and no physics: it is said, and nothing else is found.
#[test]
fn a_wrong_unit_is_recognised_before_physics_is_blamed() {
    let Some(folder) = shared::path("example_campaigns") else { return };
    let mut loaded =
        Campaign::load(&folder.join("nothing_hidden").join("campaign.toml"), LoadOptions::default()).unwrap();
    for run in &mut loaded.runs {
        let r = &run.signals["r"];
        let degrees: Vec<f64> = r.values().iter().map(|x| x.to_degrees()).collect();
        let signal = hydrosysid::run::Signal::new(r.shared_time().clone(), degrees);
        run.signals.insert("r".into(), signal);
    }
    let found = campaign::discover(&loaded).unwrap();
    let [fault] = found.log_findings.as_slice() else { panic!("{:?}", found.log_findings) };
    assert_eq!((fault.kind.as_str(), fault.channel.as_str()), ("unit", "r"));
    // the factor is estimated from the heading, whose noise leaves some tenths of a percent
    assert!((fault.factor / 57.2958 - 1.0).abs() < 0.02, "{}", fault.factor);
    assert!(found.effects.iter().all(|e| e.id == "sensor_gyro_scale"), "{:?}", found.effects);
}
