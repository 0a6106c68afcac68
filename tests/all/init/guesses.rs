//! Guesses of `init` on columns by their names, units and values, and their limits.

use super::*;

/// Standard output of `init`, and the campaign that it writes.
fn told(folder: &Folder, log: &str, more: &[&str]) -> (String, String) {
    let place = folder.path("made");
    let said = succeeds(&[&["init", log, "-o", &place, "--force"], more].concat());
    (said, fs::read_to_string(Path::new(&place).join("campaign.toml")).expect("it was written"))
}

/// A log of `swim` with this header and these cells.
fn swum(folder: &Folder, name: &str, header: &str, cells: impl Fn(usize, [f64; 7]) -> String) -> String {
    let rows: Vec<String> = swim(60.0, 0.0).into_iter().enumerate().map(|(k, row)| cells(k, row)).collect();
    folder.write(name, &format!("{header}\n{}\n", rows.join("\n")))
}

#[test]
fn a_unit_that_is_stated_is_never_overruled() {
    let folder = Folder::new("stated");
    let log = swum(&folder, "a.csv", "t,u,psi,r,pos_n,Fx [kN],Mz [foo]", |_, [t, a, b, u, r, psi, north]| {
        format!("{t:.1},{u:.5},{psi:.5},{r:.5},{north:.4},{:.6},{:.4}", 1e-3 * (a + b), a - b)
    });
    let (said, text) = told(&folder, &log, &[]);
    assert!(text.contains("tau_u = { name = \"Fx [kN]\", unit = \"N\", scale = 1000.0 }"), "{text}");
    assert!(text.contains("x = \"pos_n\""), "{text}");
    assert!(
        text.contains("# \"Mz [foo]\" would be tau_r by its name and is left out: the unit \"foo\" is not known"),
        "{text}"
    );
    assert!(!text.lines().any(|line| line.starts_with("tau_r")), "{text}");
    assert!(said.contains("left out of the model: yaw (it moves, but no command drives it)"), "{said}");
    // with an unknown unit under a name of the library the log stays readable, too
    let log = swum(&folder, "b.csv", "t,u,tau_u,tau_v [foo]", |_, [t, a, b, u, ..]| {
        format!("{t:.1},{u:.5},{:.3},{b:.3}", a + b)
    });
    let (_, text) = told(&folder, &log, &[]);
    assert!(text.contains("tau_v_as_logged = \"tau_v [foo]\"") && text.contains("[[run]]\nfile"), "{text}");
    assert!(!checked(&folder).1.iter().any(|code| code.starts_with("L01")));
}

#[test]
fn turns_a_second_are_turns() {
    let folder = Folder::new("rps");
    for (name, unit, factor) in [("a.csv", "rps", 60.0), ("b.csv", "rad/s", 60.0 / std::f64::consts::TAU)] {
        let header = format!("t,u,r,psi,n_left [{unit}],n_right [{unit}]");
        let log = swum(&folder, name, &header, |_, [t, a, b, u, r, psi, _]| {
            format!("{t:.1},{u:.5},{r:.5},{psi:.5},{:.5},{:.5}", 10.0 * a / factor, 10.0 * b / factor)
        });
        let (_, text) = told(&folder, &log, &["--vehicle", "remus100"]);
        let table: toml::Table = toml::from_str(&text).expect("TOML");
        let scale = table["log"]["columns"]["V1"]["scale"].as_float().expect("a scale");
        // full_rpm of the vehicle
        assert!((scale * 1525.0 / factor - 1.0).abs() < 1e-12, "{unit}: {scale}");
    }
}

#[test]
fn a_channel_that_never_changes_is_no_thruster() {
    let folder = Folder::new("idle");
    let log =
        swum(&folder, "a.csv", "t,u,r,psi,pwm1,pwm2,pwm3,pwm4,pwm5,pwm6,pwm7,pwm8", |k, [t, a, b, u, r, psi, _]| {
            let (a, b, c) = (1500.0 + 4.0 * a, 1500.0 + 4.0 * b, 1500 + k % 7);
            format!("{t:.1},{u:.5},{r:.5},{psi:.5},{a:.0},{b:.0},{b:.0},{a:.0},{c},{c},1500,1100")
        });
    let (said, text) = told(&folder, &log, &[]);
    // the guessed thrusters also push in heave, but no channel of heave is logged
    assert!(!said.contains("left out of the model"), "{said}");
    assert!(text.contains("six thrusters: assumed to be those of a BlueROV2") && !text.contains("V7 = "), "{text}");
    assert!(
        text.contains(
            "# guessed: a channel that never changes belongs to no thruster: \"pwm7\" (1500), \"pwm8\" (1100)"
        ),
        "{text}"
    );
    let (_, text) = told(&folder, &log, &["--vehicle", "bluerov2-heavy"]);
    assert!(text.contains("V8 = ") && !text.contains("never changes"), "{text}");
}

#[test]
fn a_thrust_without_a_unit_is_what_its_range_says() {
    let folder = Folder::new("thrust");
    let log = |name: &str, full: f64| {
        swum(&folder, name, "t,u,r,psi,thrust_left,thrust_right", |_, [t, a, b, u, r, psi, _]| {
            format!("{t:.1},{u:.5},{r:.5},{psi:.5},{:.4},{:.4}", full * a / 60.0, full * b / 60.0)
        })
    };
    let (_, text) = told(&folder, &log("part.csv", 1.0), &[]);
    assert!(text.contains("V1 = { name = \"thrust_left\", unit = \"1\" }") && !text.contains("F1"), "{text}");
    let (_, text) = told(&folder, &log("newton.csv", 40.0), &[]);
    assert!(text.contains("F1 = \"thrust_left\"") && text.contains("its name gives no unit: N is assumed"), "{text}");
}

#[test]
fn a_counter_of_rows_is_no_time_in_seconds() {
    let folder = Folder::new("counter");
    let log = swum(&folder, "a.csv", "sample,u,r,psi,V1,V2", |k, [_, a, b, u, r, psi, _]| {
        format!("{},{u:.5},{r:.5},{psi:.5},{:.4},{:.4}", k + 17, a / 100.0, b / 100.0)
    });
    let (_, text) = told(&folder, &log, &[]);
    assert!(
        text.contains("t = { name = \"sample\", scale = 0.1 }") && text.contains("it counts rows, 10 a second"),
        "{text}"
    );
    assert!(!checked(&folder).1.contains(&"L106".to_string()));
    let log = swum(&folder, "b.csv", "index,u,r,V1,V2", |k, [_, a, b, u, r, ..]| {
        format!("{k},{u:.5},{r:.5},{:.4},{:.4}", a / 100.0, b / 100.0)
    });
    let (_, text) = told(&folder, &log, &[]);
    assert!(text.contains("their rate is unknown") && text.contains("\nt = \"index\"\n"), "{text}");
    let (verdict, codes) = checked(&folder);
    assert!(codes.contains(&"L106".to_string()) && verdict != "\"green\"", "{verdict} {codes:?}");
}

#[test]
fn tables_of_ros_messages_are_in_the_axes_of_ros() {
    let folder = Folder::new("rep103");
    let header =
        "%time,field.twist.twist.linear.x,field.twist.twist.angular.z,field.wrench.force.x,field.wrench.torque.z";
    let log = swum(&folder, "a.csv", header, |_, [t, a, b, u, r, ..]| {
        format!("{},{u:.5},{:.5},{:.3},{:.3}", 1_719_830_400_000_000_000_i64 + (t * 1e9) as i64, -r, a + b, b - a)
    });
    let (_, text) = told(&folder, &log, &[]);
    for line in ["body_frame = \"flu\"", "earth_frame = \"enu\""] {
        let at = text.find(&format!("\n{line}")).unwrap_or_else(|| panic!("{line}\n{text}"));
        let before = text[..at].lines().last().unwrap_or_default();
        assert!(before.starts_with("# guessed: ") && before.contains("REP 103"), "{before}");
    }
}

#[test]
fn pulses_have_a_neutral_where_the_vehicle_says_none() {
    let folder = Folder::new("otter");
    let log = swum(&folder, "a.csv", "t,u,r,psi,pwm_left,pwm_right", |_, [t, a, b, u, r, psi, _]| {
        format!("{t:.1},{u:.5},{r:.5},{psi:.5},{:.0},{:.0}", 1500.0 + 4.0 * a, 1500.0 + 4.0 * b)
    });
    let (_, text) = told(&folder, &log, &["--vehicle", "otter"]);
    assert_eq!(text.matches("\nneutral = 1500.0\n").count(), 2, "{text}");
    assert_eq!(text.matches("# guessed: the vehicle file gives no span").count(), 2, "{text}");
    assert!(!checked(&folder).1.contains(&"M005".to_string()));
}

#[test]
fn of_two_header_lines_the_second_is_read() {
    let folder = Folder::new("header");
    let header = "clock,DVL,IMU,IMU,Cmd,Cmd\ntime,u,r,psi,tau_u,tau_r";
    let log = swum(&folder, "a.csv", header, |_, [t, a, b, u, r, psi, _]| {
        format!("{t:.1},{u:.5},{r:.5},{psi:.5},{:.3},{:.3}", a + b, 0.2 * (a - b))
    });
    let (_, text) = told(&folder, &log, &[]);
    assert!(
        text.contains("comment = \"clock,DVL,IMU,IMU,Cmd,Cm\"") && text.contains("# guessed: of two header lines"),
        "{text}"
    );
    assert!(text.contains("dofs = [\"surge\", \"yaw\"]") && !text.contains("DVL ["), "{text}");
    assert!(!checked(&folder).0.contains("red"));
}

#[test]
fn a_clock_that_is_set_back_is_not_sorted() {
    let folder = Folder::new("back");
    let log = |name: &str, of: &dyn Fn(usize, f64) -> f64| {
        swum(&folder, name, "t,u,r,psi,V1,V2", |k, [t, a, b, u, r, psi, _]| {
            format!("{:.2},{u:.5},{r:.5},{psi:.5},{:.4},{:.4}", of(k, t), a / 100.0, b / 100.0)
        })
    };
    let far = log("far.csv", &|k, t| if k < 400 { t } else { t - 30.0 });
    let place = folder.path("made");
    let output = run(&["init", &far, "-o", &place]);
    let stderr = String::from_utf8_lossy(&output.stderr);
    let text = fs::read_to_string(Path::new(&place).join("campaign.toml")).expect("it was written");
    for told in [&*stderr, &text] {
        assert!(told.contains("goes back by 29.900 s at line 402") && told.contains("Split the file"), "{told}");
    }
    assert!(!text.contains("\nsort = true"), "{text}");
    let near = log("near.csv", &|k, t| if k == 400 { t - 0.35 } else { t });
    let (_, text) = told(&folder, &near, &[]);
    assert!(text.contains("\nsort = true") && text.contains("rows are out of order"), "{text}");
}
