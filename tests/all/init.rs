//! `init` on logs as pilots record them makes a folder that the other verbs read, with every guess marked.
#![cfg(feature = "cli")]

mod guesses;
mod ship;
mod together;

use crate::shared;

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A folder for one test, removed at the end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Folder {
        let path = std::env::temp_dir().join(format!("hydrosysid-init-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).expect("a folder for temporary files");
        Folder(path)
    }

    fn path(&self, name: &str) -> String {
        self.0.join(name).display().to_string()
    }

    fn write(&self, name: &str, text: &str) -> String {
        fs::write(self.0.join(name), text).expect("a file can be written");
        self.path(name)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn run(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hydrosysid")).args(arguments).output().expect("the command runs")
}

fn succeeds(arguments: &[&str]) -> String {
    let output = run(arguments);
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// Verdict of `check`, and the codes of its findings.
fn checked(folder: &Folder) -> (String, Vec<String>) {
    let json = folder.path("check.json");
    run(&["check", &folder.path("made"), "--json", &json, "--force"]);
    let check: serde_json::Value = serde_json::from_str(&fs::read_to_string(json).expect("written")).expect("JSON");
    let of = |key: &str| check[key].as_array().cloned().unwrap_or_default();
    let found = of("errors").into_iter().chain(of("warnings"));
    (check["verdict"].to_string(), found.filter_map(|f| f["code"].as_str().map(str::to_string)).collect())
}

/// Time, commands and motion of `m u̇ + d u + q u|u| = F`, `I ṙ + e r = N` under two thrusters, by
/// Euler steps of 1 ms.
fn swim(seconds: f64, seed: f64) -> Vec<[f64; 7]> {
    let (dt, mut rows) = (0.001, Vec::new());
    let (mut u, mut r, mut psi, mut north, mut east) = (0.0_f64, 0.0_f64, 1.0_f64, 0.0_f64, 0.0_f64);
    for k in 0..(seconds / dt) as usize {
        let t = k as f64 * dt;
        // steps of 3 s, in a sequence without a period
        let step = (t / 3.0).floor();
        let left = 60.0 * (step * 1.7 + seed).sin();
        let right = 60.0 * (step * 2.3 + 1.0 + seed).sin();
        if k % 100 == 0 {
            rows.push([t, left, right, u, r, psi, north]);
        }
        // thrust of a T200 at 16 V, the default of `init`, 0.2 m off the centre line
        let force = |c: f64| {
            let w = ((c / 100.0).abs() - 0.074).max(0.0);
            if c > 0.0 { 36.3 * w * w + 23.3 * w } else { -(25.0 * w * w + 20.7 * w) }
        };
        let (f, n) = (force(left) + force(right), 0.2 * (force(left) - force(right)));
        u += dt * (f - 10.0 * u - 20.0 * u * u.abs()) / 60.0;
        r += dt * (n - 4.0 * r) / 6.0;
        psi += dt * r;
        north += dt * u * psi.cos();
        east += dt * u * psi.sin();
    }
    let _ = east;
    rows
}

#[test]
fn a_pilots_log_becomes_a_campaign_that_fits() {
    let folder = Folder::new("pilot");
    let mut logs = Vec::new();
    for k in 0..3 {
        let mut text = "time;heading;yaw_rate_deg_s;surge_vel;left_cmd [%];right_cmd [%];battery;note\n".to_string();
        for [t, left, right, u, r, psi, _] in swim(60.0, f64::from(k)) {
            let heading = psi.to_degrees().rem_euclid(360.0);
            let _ = writeln!(
                text,
                "{:.0};{heading:.3};{:.4};{u:.5};{left:.2};{right:.2};15.8;dive",
                1000.0 * t,
                r.to_degrees()
            );
        }
        logs.push(folder.write(&format!("dive{k}.csv"), &text));
    }
    let place = folder.path("dive");
    let mut arguments = vec!["init"];
    arguments.extend(logs.iter().map(String::as_str));
    arguments.extend(["-o", &place]);
    succeeds(&arguments);
    let text = fs::read_to_string(Path::new(&place).join("campaign.toml")).expect("it was written");
    for said in [
        "delimiter = \";\"",
        "time_unit = \"ms\"",
        "psi = { name = \"heading\", unit = \"deg\" }",
        "r = { name = \"yaw_rate_deg_s\", unit = \"deg/s\" }",
        "V1 = { name = \"left_cmd [%]\", unit = \"1\", scale = 0.01 }",
        "dofs = [\"surge\", \"yaw\"]",
        "input = \"hold\"",
        "role = \"validate\"",
        "supply_V = \"battery\"",
        "not recognised",
    ] {
        assert!(text.contains(said), "{said} is not in\n{text}");
    }
    // each guessed option and column has its reason on the line before
    for line in ["delimiter = ", "time_unit = ", "psi = ", "V1 = ", "input = \"hold\""] {
        let at = text.find(&format!("\n{line}")).unwrap_or_else(|| panic!("{line}\n{text}"));
        let before = text[..at].lines().last().unwrap_or_default();
        assert!(before.starts_with("# guessed: "), "{before}");
    }
    // the folder means the campaign.toml in it
    succeeds(&["check", &place]);
    let json = folder.path("fit.json");
    succeeds(&["fit", &place, "--json", &json]);
    let fit: serde_json::Value = serde_json::from_str(&fs::read_to_string(json).expect("written")).expect("JSON");
    let value = |effect: &str, dof: &str| {
        let all = fit["parameters"].as_array().expect("a list").clone();
        all.iter().find(|p| p["effect"] == effect && p["dof"] == dof).and_then(|p| p["value"].as_f64()).expect("there")
    };
    // Euler steps of 1 ms with time constants of some seconds cause errors of about 1e-4
    for (effect, dof, truth) in [
        ("inertia", "surge", 60.0),
        ("inertia", "yaw", 6.0),
        ("linear_drag", "surge", 10.0),
        ("linear_drag", "yaw", 4.0),
        ("quadratic_drag", "surge", 20.0),
    ] {
        let found = value(effect, dof);
        assert!((found / truth - 1.0).abs() < 1e-3, "{effect}@{dof} = {found}, not {truth}");
    }
    assert!(value("quadratic_drag", "yaw").abs() < 1e-3, "{}", value("quadratic_drag", "yaw"));
    let page = folder.path("report.html");
    succeeds(&["report", &place, "-o", &page]);
    let html = fs::read_to_string(page).expect("it was written");
    let verdict =
        html.split("<p class=\"verdict\">").nth(1).and_then(|rest| rest.split("</p>").next()).unwrap_or_default();
    assert!(html.contains("dive2.csv") && verdict.contains("times the sensor noise"), "{verdict}");
    assert_eq!(run(&["init", &logs[0], "-o", &place]).status.code(), Some(2), "a campaign that is there stays");
}

#[test]
fn files_of_one_dive_are_joined_on_their_clocks() {
    let folder = Folder::new("joined");
    let (mut imu, mut dvl, mut pwm) = (
        "%time,field.angular_velocity.z\n".to_string(),
        "%time,field.twist.twist.linear.x\n".to_string(),
        "%time,field.channels0,field.channels1\n".to_string(),
    );
    let wall = 1_719_830_400_000_000_000_i64;
    for (k, [t, left, right, u, r, ..]) in swim(40.0, 0.5).into_iter().enumerate() {
        let at = |late: f64| wall + ((t + late) * 1e9) as i64;
        let _ = writeln!(imu, "{},{r:.6}", at(0.0));
        if k % 2 == 0 && k > 10 {
            let _ = writeln!(dvl, "{},{u:.5}", at(0.033));
        }
        let _ = writeln!(pwm, "{},{:.0},{:.0}", at(0.01), 1500.0 + 4.0 * left, 1500.0 + 4.0 * right);
    }
    let logs = [folder.write("imu.csv", &imu), folder.write("dvl.csv", &dvl), folder.write("rcout.csv", &pwm)];
    let place = folder.path("dive");
    succeeds(&["init", &logs[0], &logs[1], &logs[2], "-o", &place]);
    let text = fs::read_to_string(Path::new(&place).join("campaign.toml")).expect("it was written");
    assert!(text.matches("[[run]]").count() == 1 && text.matches("[[run.file]]").count() == 3, "{text}");
    assert!(text.contains("neutral = 1500.0") && text.contains("dofs = [\"surge\", \"yaw\"]"), "{text}");
    let json = folder.path("check.json");
    succeeds(&["check", &place, "--json", &json]);
    let check: serde_json::Value = serde_json::from_str(&fs::read_to_string(json).expect("written")).expect("JSON");
    let seconds = check["logs"][0]["duration"].as_f64().expect("a number");
    // 40 s on one clock, not three logs one after the other
    assert!((seconds - 39.9).abs() < 0.1, "{seconds}");
}

#[test]
fn it_writes_whatever_the_log_is() {
    let folder = Folder::new("any");
    for (name, text) in [
        ("nameless.csv", "1,2,3\n2,3,4\n3,4,5\n"),
        ("empty.csv", "time,depth\n"),
        (
            "codes.csv",
            "time,depth,yaw\n0,1,0\n1,-9999,1\n2,1.1,2\n3,-9999,3\n4,1.2,4\n5,1.3,5\n6,1.4,5\n7,1.5,5\n8,1.6,5\n9,1.7,4\n",
        ),
        ("holes.csv", "time,depth,yaw\n0,1,\n1,,0.1\n1,1.1,0.2\n3,nan,0.3\n"),
        ("words.csv", "what,who\na,b\nc,d\n"),
    ] {
        let log = folder.write(name, text);
        let place = folder.path(&format!("{name}.dive"));
        succeeds(&["init", &log, "-o", &place]);
        let campaign = fs::read_to_string(Path::new(&place).join("campaign.toml")).expect("it was written");
        assert!(toml::from_str::<toml::Table>(&campaign).is_ok(), "{campaign}");
        if name == "codes.csv" {
            assert!(campaign.contains("missing_values = [\"-9999\"]"), "{campaign}");
        }
    }
    assert_eq!(run(&["init", &folder.path("none.csv"), "-o", &folder.path("x")]).status.code(), Some(2));
}

/// A log that cannot be read is reported on standard error, not only in the file.
#[test]
fn a_log_that_is_not_read_is_told() {
    let folder = Folder::new("unread");
    let log = folder.path("dive.BIN");
    fs::write(&log, [0xa3, 0x95, 0x80, 0x80, 0x59, 0x46, 0x4d, 0x54, 0, 1, 2, 3]).expect("a file can be written");
    let output = run(&["init", &log, "-o", &folder.path("made")]);
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(told.contains("not read: ") && told.contains("dive.BIN") && told.contains("Python package"), "{told}");
    // standard output claims neither that nothing can be learned nor that the campaign can be checked
    let told = String::from_utf8_lossy(&output.stdout);
    assert!(told.contains("no log could be read") && !told.contains("hydrosysid check"), "{told}");
    let campaign = fs::read_to_string(folder.path("made/campaign.toml")).expect("it is written");
    assert!(
        campaign.contains("# guessed: no log could be read: these are listed as an example\ndofs = "),
        "{campaign}"
    );
    let output = run(&["fit", &log]);
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(told.contains("this is an ArduPilot DataFlash log, not a campaign file"), "{told}");
}

/// Every verb recognises a log in another format by its first bytes, and a CSV file under any name.
#[test]
fn formats_are_known_by_their_first_bytes_in_every_verb() {
    let folder = Folder::new("bytes");
    let unknown = [&[0_u8; 40][..], b"\xa3\x95\x80\x80FMT"].concat();
    for (name, bytes, told) in [
        ("dive.csv", &b"\xa3\x95\x80\x80YFMT\0\x01\x02"[..], "ArduPilot DataFlash log"),
        ("a.dat", b"ULog\x01\x12\x35\x01\0\0", "PX4 ULog"),
        ("b.csv", b"PAR1\x15\0\x15", "Parquet file"),
        ("zeros.BIN", &unknown, "not text, and its first bytes are not those of a known log format"),
    ] {
        let log = folder.path(name);
        fs::write(&log, bytes).expect("a file can be written");
        let out = folder.path("out");
        for arguments in
            [&["init", &log, "-o", &out, "--force"][..], &["check", &log], &["convert", &log, "-o", &out, "--force"]]
        {
            let output = run(arguments);
            let both = [output.stdout, output.stderr].concat();
            let said = String::from_utf8_lossy(&both).split_whitespace().collect::<Vec<_>>().join(" ");
            assert!(said.contains(told), "{arguments:?}: {said}");
            assert!(!said.contains("cut these bytes"), "{arguments:?}: {said}");
        }
    }
    let text: String =
        (0..30).map(|k| format!("{:.1},{:.3}\n", 0.1 * f64::from(k), (0.2 * f64::from(k)).sin())).collect();
    for name in ["plain.bin", "plain.mat"] {
        let log = folder.write(name, &format!("t,u\n{text}"));
        let out = folder.path(&format!("{name}.csv"));
        succeeds(&["convert", &log, "-o", &out]);
        assert!(fs::read_to_string(&out).expect("written").starts_with("t [s],u [m/s]\n0.0,0.0\n"));
        succeeds(&["init", &log, "-o", &folder.path(&format!("{name}.dive"))]);
    }
    let absent = run(&["convert", &folder.path("absent.bin"), "-o", &folder.path("x.csv")]);
    let told = String::from_utf8_lossy(&absent.stderr).into_owned();
    assert!(told.contains("there is no such file") && told.contains("Python package"), "{told}");
    assert_eq!(absent.status.code(), Some(2));
}

/// Standard error of `init` on one log, and the campaign that it writes.
fn scaffolded(name: &str, log: &str) -> (String, String) {
    let folder = Folder::new(name);
    let log = folder.write("log.csv", log);
    let output = run(&["init", &log, "-o", &folder.path("made")]);
    assert!(output.status.success());
    let text = fs::read_to_string(Path::new(&folder.path("made")).join("campaign.toml")).expect("it was written");
    (String::from_utf8_lossy(&output.stderr).into_owned(), text)
}

#[test]
fn a_table_of_a_thruster_is_no_run() {
    let rows: String = (0..20).fold(String::new(), |mut text, k| {
        let _ = writeln!(text, "{},{},16", 1500 + 20 * k, 2 * k);
        text
    });
    let (told, text) = scaffolded("table", &format!("pwm_us,force_N,supply_V\n{rows}"));
    assert!(told.contains("a table of a thruster (command \"pwm_us\", force \"force_N\")"), "{told}");
    assert!(told.contains("bollard = \"log.csv\"") && !text.contains("\n[[run]]"), "{told}{text}");
}

#[test]
fn pressure_is_depth_and_what_nothing_commands_is_told() {
    let rows: String = (0..200).fold(String::new(), |mut text, k| {
        let t = f64::from(k);
        let _ = writeln!(text, "{t},{:.4},{:.4}", 1.0 + (0.1 * t).sin(), 0.3 * (0.07 * t).cos());
        text
    });
    let (told, text) = scaffolded("glider", &format!("time_s,pressure_bar,u_through_water_mps\n{rows}"));
    // 1 bar over 9806.65 N/m3
    assert!(text.contains("z = { name = \"pressure_bar\", unit = \"m\", scale = 10.19716"), "{text}");
    assert!(text.contains("velocity_reference = \"water\""), "{text}");
    assert!(told.contains("no degree of freedom moves under a command") && told.contains("tau_u"), "{told}");
}

/// Revolutions per minute of one propeller have the same scale in all logs: by the largest of all
/// of them, by `full_rpm` of the vehicle, or by the given scale.
#[test]
fn turns_are_scaled_alike_in_all_logs() {
    let folder = Folder::new("turns");
    let log = |name: &str, most: f64| {
        let mut text = "time,prop_rpm,surge_vel,heading,rudder\n".to_string();
        for [t, left, _, u, _, psi, _] in swim(30.0, 0.0) {
            let _ = writeln!(text, "{t:.1},{:.1},{u:.5},{psi:.5},{:.3}", most * left / 60.0, 0.1 * (0.4 * t).sin());
        }
        folder.write(name, &text)
    };
    let (slow, fast) = (log("slow.csv", 400.0), log("fast.csv", 1000.0));
    let scales = |name: &str, more: &[&str]| -> Vec<f64> {
        let place = folder.path(name);
        succeeds(&[&["init", &slow, &fast, "-o", &place], more].concat());
        let text = fs::read_to_string(Path::new(&place).join("campaign.toml")).expect("it was written");
        let table: toml::Table = toml::from_str(&text).expect("TOML");
        let own = |log: &toml::Value| log.get("columns")?.get("V1")?.get("scale")?.as_float();
        let runs = table["run"].as_array().expect("runs").iter().filter_map(|run| own(run.get("log")?));
        table.get("log").and_then(own).into_iter().chain(runs).collect()
    };
    // the largest command is a little below the amplitude of the sine
    let greatest = swim(30.0, 0.0).iter().fold(0.0, |m: f64, row| m.max(row[1].abs())) * 1000.0 / 60.0;
    for (name, more, wanted) in [
        ("guessed", &[][..], 1.0 / greatest),
        ("vehicle", &["--vehicle", "remus100"], 1.0 / 1525.0),
        ("said", &["--log", "columns.V1 = { name = \"prop_rpm\", unit = \"1\", scale = 0.0005 }"], 0.0005),
    ] {
        let found = scales(name, more);
        assert!(!found.is_empty(), "{name}");
        // the log is rounded to 0.1 rpm of 1000
        found.iter().for_each(|scale| assert!((scale / wanted - 1.0).abs() < 2e-4, "{name}: {found:?} and {wanted}"));
        succeeds(&["check", &folder.path(name)]);
    }
}

/// Published parameters of a vehicle are written into the campaign as commented priors, which are
/// valid once the comment marks are removed.
#[test]
fn published_parameters_are_priors_that_load() {
    let folder = Folder::new("priors");
    let mut text = "t,V1,V2,V3,V4,V5,V6,V7,V8,u,v,r,psi\n".to_string();
    for [t, left, right, u, r, psi, _] in swim(30.0, 0.0) {
        let (a, b) = (left / 100.0, right / 100.0);
        let _ = writeln!(text, "{t:.1},{a:.4},{b:.4},{b:.4},{a:.4},0,0,0,0,{u:.5},{:.5},{r:.5},{psi:.5}", 0.3 * u);
    }
    let log = folder.write("dive.csv", &text);
    let place = folder.path("dive");
    succeeds(&["init", &log, "--vehicle", "bluerov2-heavy", "-o", &place]);
    let file = Path::new(&place).join("campaign.toml");
    let campaign = fs::read_to_string(&file).expect("it was written");
    let from = campaign.find("as priors: uncomment").expect("priors");
    let until = campaign[from..].find("[[run]]").expect("runs") + from;
    let bare: String = campaign[from..until]
        .lines()
        .filter(|line| ["# [[parameter]]", "# effect", "# value", "# std"].iter().any(|mark| line.starts_with(mark)))
        .map(|line| format!("{}\n", line.trim_start_matches("# ")))
        .collect();
    // published are inertias and linear or quadratic drag in surge and sway; von Benzon et al. (2022)
    assert!(bare.contains("effect = \"inertia@surge\"   # m_u\nvalue = 19.86\nstd = 5.96"), "{bare}");
    assert!(bare.contains("effect = \"quadratic_drag@sway\""), "{bare}");
    fs::write(&file, format!("{campaign}\n{bare}")).expect("it can be written");
    let json = folder.path("fit.json");
    succeeds(&["fit", &place, "--json", &json]);
    let fit: serde_json::Value = serde_json::from_str(&fs::read_to_string(json).expect("written")).expect("JSON");
    let parameters = fit["parameters"].as_array().expect("a list");
    assert!(parameters.iter().any(|p| p["effect"] == "quadratic_drag" && p["dof"] == "sway"), "{parameters:?}");
}

/// If two columns could be one channel, the alternative is written below the guess.
#[test]
fn a_doubtful_guess_has_its_choices_beside_it() {
    let folder = Folder::new("choices");
    let mut text = "time,heading_deg,course_deg,V1\n".to_string();
    for [t, left, _, _, _, psi, _] in swim(30.0, 0.0) {
        let degrees = psi.to_degrees().rem_euclid(360.0);
        let _ = writeln!(text, "{t:.1},{degrees:.2},{:.2},{:.3}", (degrees + 3.0).rem_euclid(360.0), left / 100.0);
    }
    let log = folder.write("dive.csv", &text);
    let place = folder.path("dive");
    succeeds(&["init", &log, "-o", &place]);
    let campaign = fs::read_to_string(Path::new(&place).join("campaign.toml")).expect("it was written");
    let wanted =
        "psi = { name = \"heading_deg\", unit = \"deg\" }\n# or: psi = { name = \"course_deg\", unit = \"deg\" }\n";
    assert!(campaign.contains(wanted), "{campaign}");
}

#[test]
fn columns_that_are_given_win_whatever_they_are_called() {
    let folder = Folder::new("given");
    let mut text = "time,turn,heading,V1,V2\n".to_string();
    for [t, left, right, _, r, psi, _] in swim(30.0, 0.0) {
        let _ = writeln!(text, "{t:.1},{:.5},{psi:.5},{:.3},{:.3}", -r, left / 100.0, right / 100.0);
    }
    let log = folder.write("odd.csv", &text);
    let place = folder.path("odd");
    let options = ["--log", "columns.t = \"time\"", "--log", "columns.r = { name = \"turn\", sign = -1 }"];
    succeeds(&[&["init", &log, "-o", &place], &options[..]].concat());
    let campaign = fs::read_to_string(Path::new(&place).join("campaign.toml")).expect("it was written");
    let at = campaign.find("[log.columns]").expect("a table of columns");
    assert!(campaign[at..].contains("\nt = \"time\"\n") && campaign[at..].contains("sign = -1"), "{campaign}");
    assert!(!campaign.contains("# guessed: \"time\""), "{campaign}");
    succeeds(&["check", &place]);
}

#[test]
fn bolts_poses_load_without_velocities() {
    let Some(bolt) = shared::path("realdata/bolt") else { return };
    let logs: Vec<String> = ["yaw_test.csv", "yaw_test_2.csv", "depth_test.csv", "depth_test_4.csv"]
        .iter()
        .map(|name| bolt.join(name).display().to_string())
        .collect();
    let folder = Folder::new("bolt");
    // thrusters and mass properties as in the campaign that comes with the data
    let campaign = fs::read_to_string(bolt.join("campaign.toml")).expect("it can be read");
    let from = campaign.find("[vehicle]").expect("a table");
    let (model, thruster, runs) = (
        campaign.find("[model]").expect("a table"),
        campaign.find("[[thruster]]").expect("a table"),
        campaign.find("[[run]]").expect("a table"),
    );
    let tables = format!("sources = [\"its README\"]\n{}{}", &campaign[from..model], &campaign[thruster..runs]);
    fs::copy(bolt.join("t200_16v.csv"), folder.0.join("t200_16v.csv")).expect("it can be copied");
    let vehicle = folder.write("bolt.toml", &tables);
    let place = folder.path("dive");
    let mut arguments = vec!["init"];
    arguments.extend(logs.iter().map(String::as_str));
    arguments.extend(["--vehicle", &vehicle, "-o", &place]);
    succeeds(&arguments);
    assert!(Path::new(&place).join("t200_16v.csv").is_file(), "the table of the vehicle goes with it");
    let text = fs::read_to_string(Path::new(&place).join("campaign.toml")).expect("it was written");
    assert!(text.contains("dofs = [\"heave\", \"yaw\"]"), "{text}");
    let json = folder.path("check.json");
    succeeds(&["check", &place, "--json", &json]);
    let check: serde_json::Value = serde_json::from_str(&fs::read_to_string(json).expect("written")).expect("JSON");
    assert!(check["errors"].as_array().is_some_and(Vec::is_empty), "{}", check["errors"]);
    assert_ne!(check["verdict"], "red");
}

#[test]
fn vehicles_are_listed_with_their_sources() {
    let list: serde_json::Value = serde_json::from_str(&succeeds(&["vehicles", "--json", "-"])).expect("JSON");
    let names: Vec<&str> = list.as_array().expect("a list").iter().filter_map(|v| v["name"].as_str()).collect();
    for name in ["bluerov2", "bluerov2-heavy", "laurs", "otter", "remus100"] {
        assert!(names.contains(&name), "{names:?}");
    }
    assert!(list.as_array().expect("a list").iter().all(|v| !v["sources"].as_array().expect("a list").is_empty()));
}
