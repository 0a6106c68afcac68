//! Guesses of `init` from several columns or several logs together.

use super::*;

/// Output of `init` on these logs, and the campaign that it writes.
fn told(folder: &Folder, logs: &[&str]) -> (String, String) {
    let place = folder.path("made");
    let output = run(&[&["init"], logs, &["-o", &place, "--force"]].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let said = [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned()).concat();
    (said, fs::read_to_string(Path::new(&place).join("campaign.toml")).expect("it was written"))
}

/// A vehicle that goes in circles for 80 s, with an unwrapped heading of about nine turns: time, x,
/// y, psi, u, r.
fn circles() -> Vec<[f64; 6]> {
    let (mut x, mut y, mut rows) = (0.0, 0.0, Vec::new());
    for k in 0..8000 {
        let t = 0.01 * f64::from(k);
        let (psi, r) = (0.7 * t + 0.5 * (0.4 * t).sin(), 0.7 + 0.2 * (0.4 * t).cos());
        let u = 0.5 + 0.2 * (0.3 * t).sin();
        if k % 10 == 0 {
            rows.push([t, x, y, psi, u, r]);
        }
        x += 0.01 * u * psi.cos();
        y += 0.01 * u * psi.sin();
    }
    rows
}

/// A log of `circles` with this header and these cells.
fn circled(folder: &Folder, name: &str, header: &str, cells: impl Fn([f64; 6]) -> String) -> String {
    let rows: Vec<String> = circles().into_iter().map(cells).collect();
    folder.write(name, &format!("{header}\n{}\n", rows.join("\n")))
}

#[test]
fn a_heading_and_its_rate_are_of_one_kind_which_the_way_tells() {
    let folder = Folder::new("kind");
    let log = |name: &str, unit: f64| {
        circled(&folder, name, "t,x,y,yaw,vel.x,vel.y,yaw_rate,tau_u,tau_r", |[t, x, y, psi, u, r]| {
            format!("{t:.1},{x:.4},{y:.4},{:.4},{u:.4},0,{:.5},{:.3},{:.3}", unit * psi, unit * r, 50.0 * u, r - 0.7)
        })
    };
    let (_, text) = told(&folder, &[&log("rad.csv", 1.0)]);
    assert!(text.contains("psi = { name = \"yaw\", unit = \"rad\" }") && text.contains("r = \"yaw_rate\""), "{text}");
    assert!(text.contains("the velocity over x, y turns as much as psi does in radians"), "{text}");
    assert!(!checked(&folder).0.contains("red"));
    // read as degrees, heading and rate contradict the path
    let wrong = text.replace("unit = \"rad\" }", "unit = \"deg\" }");
    let wrong = wrong.replace("r = \"yaw_rate\"", "r = { name = \"yaw_rate\", unit = \"deg/s\" }");
    fs::write(Path::new(&folder.path("made")).join("campaign.toml"), wrong).expect("it can be written");
    let (verdict, codes) = checked(&folder);
    assert!(verdict.contains("red") && codes.contains(&"K111".to_string()), "{verdict} {codes:?}");

    let (_, text) = told(&folder, &[&log("deg.csv", 1.0_f64.to_degrees())]);
    for line in ["psi = { name = \"yaw\", unit = \"deg\" }", "r = { name = \"yaw_rate\", unit = \"deg/s\" }"] {
        assert!(text.contains(line) && !text.contains("# or: "), "{line}\n{text}");
    }
}

#[test]
fn a_heading_of_which_nothing_tells_the_unit_is_a_choice() {
    let folder = Folder::new("choice");
    let log = circled(&folder, "a.csv", "t,yaw,vel.x,yaw_rate,tau_u,tau_r", |[t, _, _, psi, u, r]| {
        format!("{t:.1},{psi:.4},{u:.4},{r:.5},{:.3},{:.3}", 50.0 * u, r - 0.7)
    });
    let (_, text) = told(&folder, &[&log]);
    for line in
        ["# or: psi = { name = \"yaw\", unit = \"rad\" }", "# or: r = { name = \"yaw_rate\", unit = \"rad/s\" }"]
    {
        assert!(text.contains(line), "{line}\n{text}");
    }
    assert!(text.contains("with doubt: it reaches 56, and nothing else tells degrees from radians"), "{text}");
}

#[test]
fn a_doppler_log_measures_velocities_and_their_range_is_their_unit() {
    let folder = Folder::new("doppler");
    let text = |header: &str, factor: f64| {
        let rows: Vec<String> = swim(60.0, 0.0)
            .into_iter()
            .map(|[t, a, b, u, r, ..]| format!("{t:.1},{:.3},{:.3},{r:.5},{a:.3},{b:.3}", factor * u, 0.1 * factor * r))
            .collect();
        format!("{header}\n{}\n", rows.join("\n"))
    };
    let header = "t,DVL_X,DVL_Y,gyro_z,thruster_1,thruster_2";
    let (_, made) = told(&folder, &[&folder.write("mm.csv", &text(header, 1000.0))]);
    for line in ["u = { name = \"DVL_X\", unit = \"mm/s\" }", "v = { name = \"DVL_Y\", unit = \"mm/s\" }"] {
        assert!(made.contains(line), "{line}\n{made}");
    }
    assert!(!made.lines().any(|line| line.starts_with("x = ")), "{made}");
    let (_, made) = told(&folder, &[&folder.write("m.csv", &text(header, 1.0))]);
    assert!(made.contains("\nu = \"DVL_X\"\n"), "{made}");
    // a column named as a position that changes this fast is a guess with doubt
    let header = "t,pos_x,pos_y,gyro_z,thruster_1,thruster_2";
    let (_, made) = told(&folder, &[&folder.write("pos.csv", &text(header, 1e5))]);
    let guess = made.lines().find(|line| line.contains("\"pos_x\" is x by its name")).unwrap_or_default();
    assert!(guess.contains("with doubt") && guess.contains("impossible for a vehicle"), "{made}");
}

/// A log of a towing tank with the columns of `header`: speed and load, or command and load.
fn tank(folder: &Folder, name: &str, header: &str, speed: f64, command: f64, seconds: f64) -> String {
    let rows = (0..(10.0 * seconds) as usize).map(|k| {
        let ramp = (k as f64 / 30.0).min(1.0);
        let (u, c) = (speed * ramp + 1e-3 * (k % 3) as f64, if k > 20 { command } else { 0.0 });
        let load = 5.0 * u + 32.0 * u * u.abs() + c + 0.01 * (k % 5) as f64;
        let cell = |name: &str| match name {
            "t" => format!("{:.1}", 0.1 * k as f64),
            "u" => format!("{u:.4}"),
            "V1" => format!("{c:.2}"),
            _ => format!("{load:.3}"),
        };
        header.split(',').map(cell).collect::<Vec<_>>().join(",")
    });
    folder.write(name, &format!("{header}\n{}\n", rows.collect::<Vec<_>>().join("\n")))
}

#[test]
fn a_tank_log_is_towing_where_it_moves_and_a_bollard_pull_where_it_is_held() {
    let folder = Folder::new("tank");
    let towed = [0.2, 0.4, 0.6, 0.8, 1.0].map(|speed| {
        let name = format!("tow_{:.0}.csv", 100.0 * speed);
        tank(&folder, &name, "t,u,load_u", speed, 0.0, 30.0)
    });
    let held = [3.0, 6.0].map(|c| tank(&folder, &format!("bollard_{c:.0}.csv"), "t,V1,load_u", 0.0, c, 20.0));
    let both = tank(&folder, "both.csv", "t,u,V1,load_u", 0.5, 2.0, 30.0);
    let logs: Vec<&str> = held.iter().chain(&towed).map(String::as_str).collect();
    let (said, text) = told(&folder, &logs);
    assert!(!said.contains("nothing can be learned") && text.contains("dofs = [\"surge\"]"), "{said}\n{text}");
    assert_eq!(text.matches("\nkind = \"towing\"").count(), 5, "{text}");
    assert_eq!(text.matches("\nkind = \"bollard\"").count(), 2, "{text}");
    assert_eq!(text.matches("# guessed: load_u and u, but no command: it is towed\nkind").count(), 5, "{text}");
    let fit = succeeds(&["fit", &folder.path("made")]);
    assert!(fit.contains("quadratic_drag") && !fit.contains("Nothing was estimated"), "{fit}");
    let (_, text) = told(&folder, &[&both]);
    assert!(text.contains("# guessed: with doubt: load_u and u, and the command V1"), "{text}");
}

#[test]
fn clocks_that_begin_at_zero_join_no_logs_but_those_of_one_span() {
    let folder = Folder::new("clocks");
    let log = |name: &str, header: &str, seconds: f64, column: usize| {
        let rows: Vec<String> =
            swim(seconds, 0.0).into_iter().map(|row| format!("{:.1},{:.4}", row[0], row[column])).collect();
        folder.write(name, &format!("{header}\n{}\n", rows.join("\n")))
    };
    let (u, command) = (log("a.csv", "t,u", 60.0, 3), log("b.csv", "t,tau_u", 40.0, 1));
    let (_, text) = told(&folder, &[&u, &command]);
    assert_eq!(text.matches("[[run]]\n").count(), 2, "{text}");
    let command = log("c.csv", "t,tau_u", 60.0, 1);
    let (_, text) = told(&folder, &[&u, &command]);
    assert!(
        text.contains("with doubt: their clocks start at their own zero, and they start and end together"),
        "{text}"
    );
    // topics of one bag, one of which ends early
    let (u, command) = (log("x_imu.csv", "t,u", 60.0, 3), log("x_cmd.csv", "t,tau_u", 50.0, 1));
    let (_, text) = told(&folder, &[&u, &command]);
    assert!(text.contains("[[run.file]]") && text.contains("their names are similar"), "{text}");
}

#[test]
fn logs_of_one_header_are_read_alike() {
    let folder = Folder::new("alike");
    let log = |name: &str, depth: f64, code: bool| {
        let rows: Vec<String> = swim(30.0, depth)
            .into_iter()
            .enumerate()
            .map(|(k, [t, a, b, u, r, ..])| {
                let z = if code && k % 50 == 7 { -9999.0 } else { depth + 0.1 * (0.2 * t).sin() };
                format!("{t:.1},{u:.5},{r:.5},{z:.3},{a:.3},{b:.3}")
            })
            .collect();
        folder.write(name, &format!("Time (s),u,r,depth,pwm_1,pwm_2\n{}\n", rows.join("\n")))
    };
    // in one of them the vehicle floats above the zero of its sensor
    let logs = [log("a.csv", 2.0, false), log("b.csv", -0.6, false), log("c.csv", 1.5, true)];
    let (_, text) = told(&folder, &logs.each_ref().map(String::as_str));
    assert!(!text.contains("[run.log") && text.matches("t = \"Time (s)\"").count() == 1, "{text}");
    assert!(text.contains("\nz = \"depth\"\n") && text.contains("with doubt: in b.csv it is about -0.6"), "{text}");
    assert!(text.contains("missing_values = [\"-9999\"]"), "{text}");
    // over all of them together depth counts upwards
    let logs = [log("d.csv", -2.0, false), log("e.csv", -1.6, false), log("f.csv", 0.1, false)];
    let (_, text) = told(&folder, &logs.each_ref().map(String::as_str));
    assert!(text.contains("z = { name = \"depth\", sign = -1 }") && text.contains("with doubt: in f.csv"), "{text}");
    // options that are not common to all logs are written with their run
    let other = folder.write("g.csv", "t,u,tau_u\n0,0,1\n0.1,0.1,1\n0.2,0.2,2\n0.3,0.2,2\n");
    let (_, text) = told(&folder, &[&logs[0], &logs[1], &other]);
    assert!(text.contains("[run.log.columns]") && toml::from_str::<toml::Table>(&text).is_ok(), "{text}");
    assert!(!checked(&folder).1.iter().any(|code| code.starts_with("L02")));
}

#[test]
fn a_bench_wants_no_motion() {
    let folder = Folder::new("bench");
    let rows: Vec<String> = (0..400)
        .map(|k| format!("{:.2},{},{:.2}", 0.01 * f64::from(k), 1600 + 100 * (k / 50 % 3), 4.0 + f64::from(k / 50 % 3)))
        .collect();
    let log = folder.write("a.csv", &format!("time (s),input (us),force (lb)\n{}\n", rows.join("\n")));
    let (said, text) = told(&folder, &[&log]);
    assert!(!said.contains("nothing can be learned") && !text.contains("nothing can be learned"), "{said}\n{text}");
    assert!(text.contains("one thruster on a bench\nkind = \"bench\""), "{text}");
}

#[test]
fn a_campaign_without_a_run_leads_on_and_is_replaced() {
    let folder = Folder::new("void");
    let place = folder.path("made");
    let unread = folder.write("dive.BIN", "PK\u{3}\u{4}");
    let said = succeeds(&["init", &unread, "-o", &place]);
    assert!(said.contains("no log could be read") && said.contains("the next init replaces the file"), "{said}");
    for verb in ["check", "report"] {
        let output = run(&[verb, &place]);
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{told}");
        assert!(told.contains("could read none of the logs") && told.contains("not read: "), "{told}");
        assert!(!told.contains("campaign.toml:1:1"), "{told}");
    }
    let log = folder.write("a.csv", "t,u,tau_u\n0,0,1\n0.1,0.1,1\n0.2,0.2,2\n0.3,0.2,2\n");
    succeeds(&["init", &log, "-o", &place]);
    // a campaign with a run is not replaced
    assert_eq!(run(&["init", &log, "-o", &place]).status.code(), Some(2));
}

#[test]
fn a_depth_tells_the_axes_of_a_doppler_log() {
    let folder = Folder::new("axes");
    let (mut dvl, mut depth) = ("header.stamp,velocity.x,velocity.z\n".to_string(), "header.stamp,depth\n".to_string());
    for k in 0..600 {
        let t = 0.1 * f64::from(k);
        let stamp = |late: f64| 1_719_830_400_000_000_000_i64 + ((t + late) * 1e9) as i64;
        let _ = writeln!(dvl, "{},{:.4},{:.5}", stamp(0.0), 0.5 + 0.2 * t.sin(), -0.2 * (0.4 * t).cos());
        let _ = writeln!(depth, "{},{:.4}", stamp(0.03), 3.0 + 0.5 * (0.4 * t).sin());
    }
    let logs = [folder.write("dvl.csv", &dvl), folder.write("depth.csv", &depth)];
    let (_, text) = told(&folder, &[&logs[0], &logs[1]]);
    assert!(
        text.contains("decreases where the depth of depth.csv grows") && text.contains("body_frame = \"flu\""),
        "{text}"
    );
    let (_, text) = told(&folder, &[&logs[0]]);
    assert!(text.contains("# guessed: body_frame = \"frd\", with doubt: \"velocity.z\""), "{text}");
}

#[test]
fn commands_by_degree_of_freedom_are_forces_and_parts_are_told() {
    let folder = Folder::new("parts");
    let log = |name: &str, header: &str| {
        let rows: Vec<String> = swim(40.0, 0.0)
            .into_iter()
            .map(|[t, a, b, u, r, psi, _]| {
                format!("{t:.1},{u:.5},{r:.5},{psi:.4},{:.4},{:.4}", (a + b) / 120.0, (a - b) / 120.0)
            })
            .collect();
        folder.write(name, &format!("{header}\n{}\n", rows.join("\n")))
    };
    let (_, text) = told(&folder, &[&log("a.csv", "time,vel_fwd,yaw_rate,heading,cmd_surge,cmd_yaw")]);
    for line in ["tau_u = \"cmd_surge\"", "tau_r = \"cmd_yaw\""] {
        let at = text.find(&format!("\n{line}")).unwrap_or_else(|| panic!("{line}\n{text}"));
        let before = text[..at].lines().last().unwrap_or_default();
        assert!(before.starts_with("# guessed: ") && before.contains("it stays within ±1"), "{before}");
    }
    // alone, `cmd_yaw` may as well be a commanded heading
    let (_, text) = told(&folder, &[&log("b.csv", "time,vel_fwd,yaw_rate,heading,force_x,cmd_yaw")]);
    assert!(!text.contains("tau_r = \"cmd_yaw\"") && text.contains("tau_u = \"force_x\""), "{text}");
}
