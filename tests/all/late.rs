//! Discovery on campaigns of the independent plant in which something comes late: thrust, a sensor, a clock.

use std::path::PathBuf;

use hydrosysid::campaign::{self, Campaign, FitOptions, LoadOptions};
use hydrosysid::discover::Verdict;
use hydrosysid_plant::{Campaign as Sea, Dof, Hidden, Suite};

use crate::changed_logs::{change_logs, without_velocities};
use crate::discovery::{answer, names, sea};

/// A DVL that is 0.2 s late under a random force is named, its latency within five deviations (two of them are Padé's), and the
/// log is no fault of anything else.
#[test]
fn blind_a_late_dvl_is_named() {
    let found = answer("late_dvl", &sea("laurs", 0.02, &["sensor_dvl_delay"], 204));
    assert_eq!((names(&found), found.verdict), (vec!["sensor_dvl_delay"], Verdict::Explained), "{}", found.sentence);
    let delay = &found.effects[0].parameters[0];
    assert!((delay.value - 0.2).abs() < 5.0 * delay.std && delay.std < 0.02, "{delay:?}");
}

/// Held commands that take effect 0.4 s late are named as that, and as nothing else: not as a lag, nor as a memory of the
/// water.
#[test]
fn blind_a_late_thrust_of_held_commands_is_named() {
    let sea = sea("laurs", 0.02, &["thrust_delay"], 208);
    let found = answer("late_thrust", &sea);
    assert_eq!((names(&found), found.verdict), (vec!["thrust_delay"], Verdict::Explained), "{}", found.sentence);
    let truth = sea.sail().expect("the plant sails").truth.value("thrust_delay").expect("it is hidden");
    let delay = &found.effects[0].parameters[0];
    assert!((delay.value - truth).abs() < 4.0 * delay.std, "{delay:?}, true {truth}");
}

/// Positions that come 0.3 s late are named as that where no log has a velocity: what a candidate remembers follows the slopes
/// of the poses. A lift moment of the hull was named for it.
#[test]
fn blind_a_late_position_is_named_in_logs_of_poses() {
    let mut late = sea("laurs", 0.02, &[], 210);
    late.hidden = vec![Hidden { size: 0.3, ..Hidden::new("sensor_position_delay") }];
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("discovery_late_poses");
    late.sail().expect("the plant sails").write(&folder).expect("the folder is written");
    change_logs(&folder, without_velocities);
    let loaded = Campaign::load(&folder.join("campaign.toml"), LoadOptions::default()).expect("a campaign");
    let found = campaign::discover(&loaded).expect("a fit");
    assert_eq!(
        (names(&found), found.verdict),
        (vec!["sensor_position_delay"], Verdict::Explained),
        "{}",
        found.sentence
    );
    let delay = &found.effects[0].parameters[0];
    assert!((delay.value - 0.3).abs() < 4.0 * delay.std && delay.std < 0.02, "{delay:?}");
}

/// A clock of the sensors that gains 4 ms a second on that of the commands is named with its rate, and as nothing else: not
/// as a delay of the thrust, nor as scales of gyro and DVL, which it is in part.
#[test]
fn blind_a_drifting_clock_is_named() {
    let found = answer("drifting_clock", &sea("laurs", 0.02, &["sensor_clock_drift"], 209));
    assert_eq!((names(&found), found.verdict), (vec!["sensor_clock_drift"], Verdict::Explained), "{}", found.sentence);
    let drift = &found.effects[0].parameters[0];
    assert!((drift.value - 4e-3).abs() < 4.0 * drift.std && drift.std < 4e-4, "{drift:?}");
}

/// A gyro behind a low pass is named, its time constant within five deviations; the fit of such a log says that it
/// contradicts itself.
#[test]
fn blind_a_smoothed_gyro_is_named() {
    let sea = sea("laurs", 0.02, &["sensor_gyro_lag"], 206);
    let found = answer("smoothed_gyro", &sea);
    assert_eq!((names(&found), found.verdict), (vec!["sensor_gyro_lag"], Verdict::Explained), "{}", found.sentence);
    assert_eq!(found.log_findings, vec![]);
    let lag = &found.effects[0].parameters[0];
    assert!((lag.value - 0.3).abs() < 5.0 * lag.std && lag.std < 0.02, "{lag:?}");
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("discovery_smoothed_gyro");
    let loaded = Campaign::load(&folder.join("campaign.toml"), LoadOptions::default()).expect("a campaign");
    let fit = campaign::fit(&loaded, FitOptions::default()).expect("a fit");
    assert!(
        fit.sentence.starts_with("Do not use these numbers: the log contradicts itself: r lags"),
        "{}",
        fit.sentence
    );
    assert!(fit.warnings.iter().any(|w| w.code == "M142") && fit.may_lack());
    // once it is in the model the log contradicts nothing, and is mended no more
    let file = folder.join("campaign.toml");
    let text = std::fs::read_to_string(&file).expect("it was written");
    std::fs::write(&file, text.replace("\"coriolis_yaw\"]", "\"coriolis_yaw\", \"sensor_gyro_lag\"]"))
        .expect("it is changed");
    let with = Campaign::load(&file, LoadOptions::default()).expect("a campaign");
    let fit = campaign::fit(&with, FitOptions::default()).expect("a fit");
    assert!(fit.sentence.starts_with("The fit converged"), "{}", fit.sentence);
    let found = campaign::discover(&with).expect("a fit");
    assert_eq!((names(&found), found.verdict), (vec![], Verdict::NothingMissing), "{}", found.sentence);
    assert_eq!(found.log_findings, vec![]);
}

/// A gyro whose samples are stamped late is no effect: the log is told to be late, and nothing else is missing.
#[test]
fn blind_a_late_gyro_is_a_fault_of_the_log() {
    let instruments = Suite { rate: 5.0, gyro_latency: 0.3, ..Suite::default() }.instruments(&Dof::PLANE);
    let found = answer("late_gyro", &Sea { instruments, ..sea("laurs", 0.02, &[], 207) });
    assert_eq!((names(&found), found.verdict), (vec![], Verdict::NothingMissing), "{}", found.sentence);
    let [late] = &found.log_findings[..] else { panic!("{:?}", found.log_findings) };
    assert!(late.channel == "r" && (late.factor - 0.3).abs() < 0.02, "{late:?}");
}
