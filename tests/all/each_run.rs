//! Effects with a value of their own in each run, such as a current, are found, adopted and fitted,
//! on the independent plant.

use hydrosysid::campaign::{self, Campaign, FitOptions, LoadOptions, with_effects};
use hydrosysid::discover::Verdict;
use hydrosysid_plant as plant;

/// A planar campaign of one vehicle with the hidden effect `hidden`: 9 runs of 30 s.
fn sailed(hidden: &str, seed: u64) -> (std::path::PathBuf, plant::Truth) {
    let vehicle = plant::Vehicle::named("laurs").expect("the plant has it");
    let asked = plant::Campaign {
        force: plant::RandomForce { share: 0.02, correlation: 1.0 },
        hidden: vec![plant::Hidden::new(hidden)],
        duration: 30.0,
        seed,
        ..plant::Campaign::new(vehicle, &[plant::Dof::Surge, plant::Dof::Sway, plant::Dof::Yaw])
    };
    let folder = std::env::temp_dir().join(format!("hydrosysid_{hidden}_{}_{seed}", std::process::id()));
    let sailed = asked.sail().expect("it sails");
    sailed.write(&folder).expect("it is written");
    (folder, sailed.truth)
}

/// A current that differs from run to run is found although the model has a current that is the
/// same in all runs. After adoption it replaces that one, and its values are within four standard
/// deviations of the truth.
#[test]
fn a_current_of_the_day_is_named_in_the_stead_of_one_current() {
    let (folder, truth) = sailed("current_each_run", 302);
    let file = folder.join("campaign.toml");
    let load = || Campaign::load(&file, LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    let adopt = |names: &[&str]| {
        let text = std::fs::read_to_string(&file).expect("it is there");
        let names: Vec<String> = names.iter().map(ToString::to_string).collect();
        std::fs::write(&file, with_effects(&text, &names).expect("it is a campaign")).expect("it is written");
    };
    adopt(&["current"]);
    let found = campaign::discover(&load()).expect("it is searched");
    assert_eq!(found.verdict, Verdict::Explained, "{}", found.sentence);
    assert_eq!(found.adopt, ["current_each_run"], "{}", found.sentence);
    assert!(found.behaves_like.iter().all(|like| like.id != "current"), "{:?}", found.behaves_like);
    adopt(&["current_each_run"]);
    let fit = campaign::fit(&load(), FitOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    assert!(fit.parameters.iter().all(|p| p.effect != "current"), "it stands beside what took its stead");
    let mut asked = 0;
    for p in fit.parameters.iter().filter(|p| p.effect == "current_each_run") {
        for (run, value) in &p.per_run {
            let name = format!("{} of {run}", p.name);
            let Some(true_value) = truth.values.iter().find(|v| v.name == name) else { continue };
            // twelve values within four standard deviations; the reported one is the largest of all runs
            let std = p.std.expect("it was estimated");
            assert!((value - true_value.value).abs() < 4.0 * std, "{name}: {value} ± {std}, {}", true_value.value);
            asked += 1;
        }
    }
    assert!(asked >= 12, "six runs take part: {asked}");
    let _ = std::fs::remove_dir_all(&folder);
}

/// A tide also turns within the runs, so that a current for each run does not explain it, and the
/// verdict says so.
#[test]
fn a_current_that_turns_within_the_runs_is_not_explained_by_one_of_each() {
    let (folder, _) = sailed("tidal_current", 302);
    let campaign = Campaign::load(&folder.join("campaign.toml"), LoadOptions::default());
    let found = campaign::discover(&campaign.unwrap_or_else(|e| panic!("{e}"))).expect("it is searched");
    let _ = std::fs::remove_dir_all(&folder);
    assert_ne!(found.verdict, Verdict::Explained, "{}", found.sentence);
    assert_ne!(found.verdict, Verdict::NothingMissing, "{}", found.sentence);
}
