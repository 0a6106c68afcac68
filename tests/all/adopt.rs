//! `discover --adopt`: the named effects are written into the campaign, and the campaign can then be fitted.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const CAMPAIGN: &str = "# my vehicle
format = 1
[model]
dofs = [\"surge\"]
effects = [\"inertia\", \"quadratic_drag\"] # so far
[[run]]
file = \"0.csv\"
[[run]]
file = \"1.csv\"
[[run]]
file = \"2.csv\"
role = \"validate\"
";

/// A new folder with a simulated campaign.
fn sailed(name: &str, bias: f64) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("a folder can be made");
    sail(&folder, bias);
    folder
}

/// Logs of m u̇ + k u|u| + b = τ with noise on u, integrated in small steps, and a campaign whose
/// model lacks b.
pub fn sail(folder: &Path, bias: f64) {
    std::fs::write(folder.join("campaign.toml"), CAMPAIGN).expect("a file can be written");
    let mut noise = 1u64;
    for run in 0..3 {
        let mut text = String::from("t,u,tau_u\n");
        let (mut u, small) = (0.0_f64, 100);
        let tau = |t: f64| 12.0 * (t * (0.5 + 0.2 * f64::from(run))).sin() + 5.0 * (1.7 * t).sin();
        for k in 0..600 {
            let t = 0.1 * f64::from(k);
            noise = noise.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let white = (noise >> 11) as f64 / (1u64 << 53) as f64 - 0.5;
            writeln!(text, "{t:.1},{:.6},{:.9}", u + 0.01 * white, tau(t)).expect("it fits");
            for i in 0..small {
                let at = t + 0.1 * (f64::from(i) + 0.5) / f64::from(small);
                // commands are linear between samples
                let share = (at - t) / 0.1;
                let force = tau(t) + share * (tau(t + 0.1) - tau(t));
                u += 0.1 / f64::from(small) * (force - 40.0 * u * u.abs() - bias) / 20.0;
            }
        }
        std::fs::write(folder.join(format!("{run}.csv")), text).expect("a file can be written");
    }
}

fn run(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hydrosysid")).args(arguments).current_dir(folder).output().expect("it starts")
}

fn text(folder: &Path, name: &str) -> String {
    std::fs::read_to_string(folder.join(name)).expect("it was written")
}

#[test]
fn what_is_named_stands_in_the_campaign() {
    let folder = sailed("adopted", 2.0);
    let plain = run(&folder, &["discover", "campaign.toml"]);
    let told = String::from_utf8_lossy(&plain.stdout).into_owned();
    assert!(told.contains("--adopt writes \"bias@surge\" into `effects`"), "{told}");
    assert_eq!(text(&folder, "campaign.toml"), CAMPAIGN, "nothing is written unless it is asked for");
    let copied = run(&folder, &["discover", "campaign.toml", "--adopt", "mine.toml"]);
    assert!(copied.status.success(), "{}", String::from_utf8_lossy(&copied.stderr));
    let expected = CAMPAIGN.replace("\"quadratic_drag\"]", "\"quadratic_drag\", \"bias@surge\"]");
    assert_eq!(text(&folder, "mine.toml"), expected);
    assert_eq!(text(&folder, "campaign.toml"), CAMPAIGN);
    let elsewhere = run(&folder, &["discover", "campaign.toml", "--adopt", "../mine.toml"]);
    assert_eq!(elsewhere.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&elsewhere.stderr).contains("another folder"));
    assert!(run(&folder, &["discover", ".", "--adopt"]).status.success());
    assert_eq!(text(&folder, "campaign.toml"), expected);
    let fitted = run(&folder, &["fit", "campaign.toml", "--json", "fit.json"]);
    assert!(fitted.status.success(), "{}", String::from_utf8_lossy(&fitted.stderr));
    let fit: serde_json::Value = serde_json::from_str(&text(&folder, "fit.json")).expect("JSON");
    let own = fit["parameters"].as_array().and_then(|all| all.iter().find(|p| p["effect"] == "bias"));
    let bias = own.expect("it is fitted");
    let (value, std) = (bias["value"].as_f64().expect("a number"), bias["std"].as_f64().expect("a number"));
    assert!((value - 2.0).abs() < 4.0 * std && std < 0.1, "{value} ± {std}");
}

#[test]
fn where_nothing_is_named_nothing_is_written() {
    let folder = sailed("adopted-nothing", 0.0);
    let found = run(&folder, &["discover", "campaign.toml", "--adopt"]);
    assert!(found.status.success(), "{}", String::from_utf8_lossy(&found.stderr));
    assert!(String::from_utf8_lossy(&found.stdout).contains("Nothing is missing"));
    assert_eq!(text(&folder, "campaign.toml"), CAMPAIGN);
}
