//! What only held-out runs could tell, on the plant: a loss of thrust astern, a Munk moment where each motion is moved alone.

use std::path::Path;

use hydrosysid::campaign::{self, Campaign, FitOptions, LoadOptions};
use hydrosysid::discover::{Discovery, Verdict};
use hydrosysid::report::Origin;
use hydrosysid::report_content::page_of;
use hydrosysid::run::Role;
use hydrosysid_plant::{Campaign as Sea, Dof as Axis, Hidden, Manoeuvre, RandomForce, Vehicle};

/// What is found where the last run alone goes astern, with this role.
fn found(role: &str) -> Discovery {
    let mut sea = Sea::new(Vehicle::named("small").expect("it exists"), &[Axis::Surge]);
    (sea.runs, sea.duration, sea.seed) = (6, 60.0, 611);
    sea.force = RandomForce { share: 0.02, correlation: 1.0 };
    sea.hidden = vec![Hidden::new("thrust_reverse_loss@surge")];
    let ahead = |mean| Manoeuvre::Alone(Axis::Surge, 0.25, mean);
    sea.manoeuvres = vec![ahead(0.5), ahead(0.4), ahead(0.6), ahead(0.3), ahead(0.5), ahead(-0.5)];
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("beyond_the_fit_{role}"));
    let _ = std::fs::remove_dir_all(&folder);
    sea.sail().expect("it sails").write(&folder).expect("the folder can be written");
    let file = folder.join("campaign.toml");
    let text = std::fs::read_to_string(&file).expect("it was written");
    let (others, last) = text.split_at(text.find("run05.csv").expect("six runs"));
    let text = others.to_string() + &last.replacen("\"validate\"", &format!("\"{role}\""), 1);
    std::fs::write(&file, text).expect("it can be written");
    campaign::discover(&Campaign::load(&file, LoadOptions::default()).expect("a campaign")).expect("it can be searched")
}

#[test]
fn what_only_a_held_out_run_shows_is_not_said_to_be_in_no_catalogue() {
    let found = found("validate");
    assert_eq!(found.verdict, Verdict::Unexplained, "{}", found.sentence);
    assert!(found.sentence.contains("do not show: it is in `run05.csv`, which goes beyond"), "{}", found.sentence);
    let codes: Vec<&str> = found.warnings.iter().map(|w| w.code).collect();
    assert!(codes.contains(&"D108") && codes.contains(&"E101") && !codes.contains(&"D107"), "{codes:?}");
    let next = found.next_experiment.expect("something is to be done");
    assert!(next.starts_with("Let run05.csv take part in the fit"), "{next}");
}

/// What the next experiment advises: the run takes part, and the loss has its name.
#[test]
fn with_the_run_in_the_fit_the_loss_is_named() {
    let found = found("train");
    let names: Vec<&str> = found.effects.iter().map(|e| e.id.as_str()).collect();
    assert_eq!(names, ["thrust_reverse_loss@surge"], "{}", found.sentence);
    assert_eq!(found.verdict, Verdict::Explained, "{}", found.sentence);
}

/// Two runs of the fit go astern and none of those that judge does: they say neither yes nor no to a drag that differs there, and the
/// answer says that beside its "nothing is missing". A constant force, which gains less and which they bear out by chance, is not named in its
/// stead.
#[test]
fn what_no_run_that_judges_shows_is_told_beside_the_verdict() {
    let mut sea = Sea::new(Vehicle::named("small").expect("it exists"), &[Axis::Surge]);
    (sea.runs, sea.duration, sea.seed) = (6, 60.0, 614);
    sea.force = RandomForce { share: 0.05, correlation: 1.0 };
    sea.hidden = vec![Hidden { size: 0.3, ..Hidden::new("drag_asymmetry@surge") }];
    let sine = |share, mean| Manoeuvre::Alone(Axis::Surge, share, mean);
    sea.manoeuvres =
        vec![sine(0.25, 0.5), sine(0.25, 0.4), sine(0.5, 0.0), sine(0.4, 0.0), sine(0.25, 0.5), sine(0.25, 0.6)];
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("beyond_the_fit_asymmetry");
    let _ = std::fs::remove_dir_all(&folder);
    sea.sail().expect("it sails").write(&folder).expect("the folder can be written");
    let campaign = Campaign::load(&folder.join("campaign.toml"), LoadOptions::default()).expect("a campaign");
    let found = campaign::discover(&campaign).expect("it can be searched");
    assert_eq!(found.verdict, Verdict::NothingMissing, "{}", found.sentence);
    assert!(
        found.sentence.contains("(drag_asymmetry@surge), but no run that took no part shows it"),
        "{}",
        found.sentence
    );
    assert!(found.resemblances().all(|like| like.id != "drag_asymmetry@surge"), "once is enough");
}

/// Four runs of the fit that move one degree of freedom each, and a zig-zag and a free run that judge: of the Munk moment only
/// these know. The worse one takes part, the other one bears the name out, and the user is told.
#[test]
fn a_moment_that_only_the_runs_that_judge_show_is_named_with_one_of_them() {
    let mut sea = Sea::new(Vehicle::named("laurs").expect("it exists"), &Axis::PLANE);
    (sea.runs, sea.duration, sea.seed) = (6, 60.0, 5503);
    sea.force = RandomForce { share: 0.0, correlation: 1.0 };
    sea.hidden = vec![Hidden::new("coriolis_yaw")];
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("beyond_the_fit_munk");
    let _ = std::fs::remove_dir_all(&folder);
    sea.sail().expect("it sails").write(&folder).expect("the folder can be written");
    let campaign = Campaign::load(&folder.join("campaign.toml"), LoadOptions::default()).expect("a campaign");
    let found = campaign::discover(&campaign).expect("it can be searched");
    let names: Vec<&str> = found.effects.iter().map(|e| e.id.as_str()).collect();
    assert_eq!((names, found.verdict), (vec!["coriolis_yaw"], Verdict::Explained), "{}", found.sentence);
    let told = found.warnings.iter().find(|w| w.code == "D110").expect("who took part is told");
    assert!(told.message.starts_with("run04.csv took part in the fit of this search"), "{}", told.message);
    // the gap is that of the run that was left to judge
    let judges: Vec<&str> = found.gap.iter().flat_map(|step| &step.runs).map(|run| run.run.as_str()).collect();
    assert!(!judges.is_empty() && judges.iter().all(|run| *run == "run05.csv"), "{judges:?}");
    assert_eq!(found.took_part, ["run04.csv"]);
    // the report is of a fit with that run, and shows the one that is left to judge
    let page = page_of(&campaign, Some(&found), None, Origin::default()).expect("a report");
    assert!(page.contains("The worst run: run05.csv"), "{}", &page[..2000]);
    // and with it the campaign is fitted from then on
    campaign::adopt(&folder, None, &found.adopt, &found.took_part).expect("a campaign");
    let adopted = Campaign::load(&folder.join("campaign.toml"), LoadOptions::default()).expect("a campaign");
    assert_eq!(adopted.runs.iter().filter(|run| run.role == Role::Validate).count(), 1);
    let fit = campaign::fit(&adopted, FitOptions::default()).expect("a fit");
    assert!(fit.sentence.contains("predictions 8 s ahead err as much as expected"), "{}", fit.sentence);
}
