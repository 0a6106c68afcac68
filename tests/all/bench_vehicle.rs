//! `fit … --vehicle` on the command line: a log of a thruster on a test stand becomes a vehicle
//! file, which `init` reads.

use std::path::Path;
use std::process::{Command, Output};

use hydrosysid::noise::Noise;

fn hydrosysid(arguments: &[&str], folder: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hydrosysid")).args(arguments).current_dir(folder).output().expect("it runs")
}

fn text(output: &Output) -> String {
    format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr))
}

/// Log of a thruster with F = 45 s|s| + 8 s and a rotor lag of 0.12 s: steps of the pulse width,
/// 60 s at 100 Hz.
fn bench() -> String {
    let mut noise = Noise::new(7, 1);
    let (mut rotor, mut command, mut next, mut step) = (0.0_f64, 0.0_f64, 0.0, 0);
    let mut csv = "time (s),input (us),force (N)\n".to_string();
    for k in 0..6000 {
        let t = 0.01 * f64::from(k);
        if t >= next {
            // all pulse widths 1100, 1150, …, 1900 us, never neighbours one after the other
            step += 1;
            command = f64::from(step * 7 % 17 - 8) / 8.0;
            next = t + 0.4 + 0.05 * f64::from(step % 9);
        }
        let force = 45.0 * rotor * rotor.abs() + 8.0 * rotor + 0.3 * noise.normal();
        csv += &format!("{t:.2},{:.0},{force:.3}\n", 1500.0 + 400.0 * command);
        rotor += (command - rotor) * (1.0 - (-0.01_f64 / 0.12).exp());
    }
    csv
}

#[test]
fn a_bench_log_becomes_a_vehicle_file_that_init_takes() {
    let folder = std::env::temp_dir().join(format!("hydrosysid-bench-vehicle-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("stand.csv"), bench()).unwrap();
    let made = hydrosysid(&["init", "stand.csv", "-o", "stand"], &folder);
    assert!(made.status.success(), "{}", text(&made));
    // no vehicle is given, so there is none to extend
    let refused = hydrosysid(&["fit", "stand", "--model", "ours.toml"], &folder);
    assert_eq!(refused.status.code(), Some(2), "{}", text(&refused));
    assert!(text(&refused).contains("--vehicle") && !folder.join("ours.toml").exists(), "{}", text(&refused));
    // and the table of the fit is not printed
    assert!(!text(&refused).contains("of the thruster"), "{}", text(&refused));
    // verbs on the motion of a vehicle refuse this log
    for verb in ["report", "discover", "compare"] {
        let told = hydrosysid(&[verb, "stand"], &folder);
        assert_eq!(told.status.code(), Some(1), "{verb}: {}", text(&told));
        assert!(
            text(&told).contains("M014") && text(&told).matches("none of the vehicle").count() == 1,
            "{}",
            text(&told)
        );
    }
    let unknown = hydrosysid(&["fit", "stand", "--model", "ours.toml", "--vehicle", "bluerov9"], &folder);
    assert!(!unknown.status.success() && !folder.join("ours.toml").exists(), "{}", text(&unknown));

    let fitted = hydrosysid(&["fit", "stand", "--model", "ours.toml", "--vehicle", "bluerov2"], &folder);
    assert!(fitted.status.success(), "{}", text(&fitted));
    assert!(text(&fitted).contains("ours.toml, which extends bluerov2"), "{}", text(&fitted));
    let file: toml::Table = std::fs::read_to_string(folder.join("ours.toml")).unwrap().parse().unwrap();
    assert_eq!(file["extends"].as_str(), Some("bluerov2"));
    let thrusters = file["thruster"].as_array().unwrap();
    assert_eq!(thrusters.len(), 6);
    let of = |table: &toml::Value, direction: &str, s: f64| {
        let curve = |key: &str| table[direction][key].as_float().unwrap();
        curve("a") * s * s + curve("b") * s
    };
    // at two thirds and at full command, in both directions, within 2 % of the largest thrust
    for (direction, s) in [("forward", 0.667), ("forward", 1.0), ("reverse", 0.667), ("reverse", 1.0)] {
        let (found, truth) = (of(&thrusters[0], direction, s), 45.0 * s * s + 8.0 * s);
        assert!((found - truth).abs() < 0.02 * 53.0, "{direction} {s}: {found} for {truth}\n{}", text(&fitted));
    }
    let lag = file["parameter"].as_array().unwrap();
    let lag = lag.iter().find(|p| p["effect"].as_str() == Some("thrust_lag")).expect("the lag goes into the file");
    let (value, std) = (lag["value"].as_float().unwrap(), lag["std"].as_float().unwrap());
    assert!((value - 0.12).abs() < (3.0 * std).max(0.012), "{value} ± {std}");

    // `init` with this vehicle file writes the curve and the lag into a campaign
    let dive: String = (0..200)
        .map(|k| {
            let t = 0.1 * f64::from(k);
            let pulse = 1500 + 100 * i32::from((k / 20) % 2 == 0);
            format!("{t:.1},{:.4},{pulse},{pulse},1500,1500,1500,1500\n", 0.3 * (0.5 * t).sin())
        })
        .collect();
    std::fs::write(folder.join("dive.csv"), format!("time,surge_vel,pwm1,pwm2,pwm3,pwm4,pwm5,pwm6\n{dive}")).unwrap();
    let scaffold = hydrosysid(&["init", "dive.csv", "--vehicle", "ours.toml", "-o", "dive"], &folder);
    assert!(scaffold.status.success(), "{}", text(&scaffold));
    let campaign = std::fs::read_to_string(folder.join("dive/campaign.toml")).unwrap();
    let a = thrusters[0]["forward"]["a"].as_float().unwrap();
    assert!(campaign.contains(&format!("\na = {a}\n")) && campaign.contains("thrust_lag"), "{campaign}");
    std::fs::remove_dir_all(folder).unwrap();
}
