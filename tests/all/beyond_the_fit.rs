//! Effects that only held-out runs show, on the plant: a loss of thrust astern, and a Munk moment
//! while the training runs move one degree of freedom each.

use std::path::Path;

use hydrosysid::campaign::{self, Adoption, Campaign, FitOptions, LoadOptions};
use hydrosysid::discover::{Discovery, Verdict};
use hydrosysid::report::Origin;
use hydrosysid::report_content::page_of;
use hydrosysid::run::Role;
use hydrosysid_plant::{Campaign as Sea, Dof as Axis, Hidden, Manoeuvre, RandomForce, Vehicle};

/// The discovery if only the last run goes astern; `role` is the role of that run.
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
    assert!(next.starts_with("Include run05.csv in the fit"), "{next}");
}

/// With that run in the fit, as the next experiment advises, the loss is named.
#[test]
fn with_the_run_in_the_fit_the_loss_is_named() {
    let found = found("train");
    let names: Vec<&str> = found.effects.iter().map(|e| e.id.as_str()).collect();
    assert_eq!(names, ["thrust_reverse_loss@surge"], "{}", found.sentence);
    assert_eq!(found.verdict, Verdict::Explained, "{}", found.sentence);
}

/// Two training runs go astern and no held-out run does, so that the held-out runs cannot confirm
/// or reject a drag that differs astern. The sentence says so in addition to "nothing is missing".
/// A constant force, which gains less and which the held-out runs confirm by chance, is not named
/// instead.
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
    assert!(found.sentence.contains("(drag_asymmetry@surge), but no held-out run shows it"), "{}", found.sentence);
    assert!(found.resemblances().all(|like| like.id != "drag_asymmetry@surge"), "once is enough");
}

/// Four training runs move one degree of freedom each; only the held-out runs, a zig-zag and a free
/// run, show the Munk moment. The one with the larger error takes part in the fit, the other one
/// confirms the name, and a warning says so.
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
    // the gap is that of the remaining held-out run
    let judges: Vec<&str> = found.gap.iter().flat_map(|step| &step.runs).map(|run| run.run.as_str()).collect();
    assert!(!judges.is_empty() && judges.iter().all(|run| *run == "run05.csv"), "{judges:?}");
    assert_eq!(found.took_part, ["run04.csv"]);
    // the report is of a fit with that run, and shows the remaining held-out run
    let page = page_of(&campaign, Some(&found), None, Origin::default()).expect("a report");
    assert!(page.contains("The worst run: run05.csv"), "{}", &page[..2000]);
    // after adoption that run takes part in the fit of the campaign
    campaign::adopt(&folder, None, &Adoption::from(&found)).expect("a campaign");
    let adopted = Campaign::load(&folder.join("campaign.toml"), LoadOptions::default()).expect("a campaign");
    assert_eq!(adopted.runs.iter().filter(|run| run.role == Role::Validate).count(), 1);
    let fit = campaign::fit(&adopted, FitOptions::default()).expect("a fit");
    assert!(fit.sentence.contains("predictions 8 s ahead err as much as expected"), "{}", fit.sentence);
}
