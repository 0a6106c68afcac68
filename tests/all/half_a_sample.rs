//! Held commands that are read as straight lines act half a row late, lines that are read as held up to a row: the
//! search finds out which, and goes on with the other interpolation.

use std::path::{Path, PathBuf};

use crate::discovery::{names, sea};
use crate::surge::surge;
use hydrosysid::campaign::file::{CampaignFile, ReadOptions};
use hydrosysid::campaign::{self, Campaign, LoadOptions};
use hydrosysid::discover::{Discovery, Verdict};
use hydrosysid::model::Interpolation;
use hydrosysid::run::{Role, Run, Signal};
use hydrosysid::tank::Noise;
use hydrosysid_plant::{Campaign as Sea, Input};

/// Log of 100 u̇ = τ − 80 u|u| at 10 Hz under random commands. The log has τ at the rows; between
/// rows it is held or linear. At a step itself τ is the mean of both sides, because the integrator
/// evaluates it equally often from each.
fn run(name: &str, role: Role, seed: u64, is_held: bool) -> Run {
    let samples = 600;
    let wanders = Noise::new(seed, 5).coloured(samples + 2, 0.9);
    let logged = |row: usize| 30.0 * wanders[row.min(samples + 1)];
    let tau = |t: f64| {
        let rows = 10.0 * t;
        let row = (rows + 1e-6).floor() as usize;
        let on = (rows - row as f64).max(0.0);
        match is_held {
            true if on < 1e-5 && row > 0 => 0.5 * (logged(row - 1) + logged(row)),
            true => logged(row),
            false => logged(row) + (logged(row + 1) - logged(row)) * on,
        }
    };
    let (time, speed) = surge(samples, |t, u| (tau(t) - 80.0 * u * u.abs()) / 100.0);
    let white = Noise::new(seed, 3).coloured(samples, 0.0);
    let clock: std::sync::Arc<[f64]> = time.clone().into();
    let of = |f: &dyn Fn(usize) -> f64| Signal::new(clock.clone(), (0..samples).map(f).collect::<Vec<_>>());
    let mut run = Run { name: name.into(), role, ..Run::default() };
    run.signals.insert("tau_u".into(), of(&|k| logged(k)));
    run.signals.insert("u".into(), of(&|k| speed[k] + 0.002 * white[k]));
    run
}

/// The discovery in six runs with held or linear commands, read with this `input`.
fn found(is_held: bool, input: &str) -> Discovery {
    let text = format!(
        "format = 1\n[model]\ndofs = ['surge']\neffects = ['inertia', 'quadratic_drag']\ninput = '{input}'\n[[run]]\nfile = 'a.csv'\n"
    );
    let options = ReadOptions { look_for_files: false, ..ReadOptions::default() };
    let file = CampaignFile::from_bytes(text.as_bytes(), Path::new("surge.toml"), &options);
    let role = |n: u64| if n < 5 { Role::Train } else { Role::Validate };
    let runs = (1..=6).map(|n| run(&format!("run{n}"), role(n), n, is_held)).collect();
    let campaign = Campaign::from_runs(file.unwrap_or_else(|e| panic!("{e}")), runs).unwrap_or_else(|e| panic!("{e}"));
    campaign::discover(&campaign).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn held_commands_that_are_read_as_lines_are_said_to_be_held() {
    let found = found(true, "linear");
    assert!(found.sentence.starts_with("Held commands were interpolated linearly"), "{}", found.sentence);
    assert!(found.sentence.contains("input = \"hold\""), "{}", found.sentence);
    assert!(found.warnings.iter().any(|w| w.code == "D106"), "{:?}", found.warnings);
    // the remedy is another option of the model, not an effect
    assert!(found.adopt.is_empty(), "{:?}", found.adopt);
    assert_eq!(found.input, Some(Interpolation::Hold));
    assert!(found.sentence.contains("Nothing is missing"), "{}", found.sentence);
}

/// On the independent plant: lines that are read as held act late, and the missing Munk moment is named with them as lines.
#[test]
fn blind_commands_that_change_between_the_rows_are_said_to() {
    let lines = Sea { input: Input::Linear, ..sea("laurs", 0.02, &["coriolis_yaw"], 8301) };
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("lines_as_held");
    lines.sail().expect("the plant sails").write(&folder).expect("the folder is written");
    let path = folder.join("campaign.toml");
    let text = std::fs::read_to_string(&path).expect("it was written");
    std::fs::write(&path, text.replace("input = \"linear\"", "input = \"hold\"")).expect("it can be written");
    let loaded = Campaign::load(&path, LoadOptions::default()).expect("a campaign");
    let found = campaign::discover(&loaded).expect("a fit");
    assert!(found.sentence.starts_with("The commands change between the logged rows"), "{}", found.sentence);
    assert!(found.sentence.contains("input = \"linear\""), "{}", found.sentence);
    assert_eq!((names(&found), found.verdict), (vec!["coriolis_yaw"], Verdict::Explained), "{}", found.sentence);
    assert!(found.warnings.iter().any(|w| w.code == "D112"), "{:?}", found.warnings);
    assert_eq!(found.input, Some(Interpolation::Linear));
}

#[test]
fn commands_that_are_read_as_they_are_lack_nothing() {
    for (is_held, input) in [(true, "hold"), (false, "linear")] {
        let found = found(is_held, input);
        assert!(found.sentence.starts_with("Nothing is missing"), "{input}: {}", found.sentence);
        assert_eq!(found.input, None, "{input}");
    }
}
