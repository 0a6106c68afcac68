//! Zig-zags of a ship as recorded on its bridge: 1 Hz, one rudder, and constant revolutions of the propeller.

use super::*;

/// Virtual masses in surge and sway, kg, and in yaw, kg·m².
const INERTIA: [f64; 3] = [2.1e6, 3.4e6, 9.0e8];
/// Thrust for 6 m/s, N.
const THRUST: f64 = 144e3;
/// Thrust deduction of the hull, as a share of the propeller's thrust.
const DEDUCTION: f64 = 0.2;
/// Position of the rudder, m, and slope of its lift, kg/m.
const RUDDER: [f64; 2] = [-30.0, 4.0e3];

/// The log of one zig-zag of `degrees`, with sensor noise of 0.02 m/s, 0.01 °/s and 0.1°.
///
/// `m_u u̇ = T − q u² + m_v v r − k_D u² δ²`, `m_v v̇ = −m_u u r − d u v − k u (u δ + v + x r)`,
/// `I ṙ = (m_u − m_v) u v − e u r + x Y`, by Euler steps of 0.02 s: a hull at speed is damped by its lift.
fn zigzag(degrees: f64, seconds: f64, seed: u64) -> String {
    let header = "time,rudder_angle_deg,heading_deg,yaw_rate_deg_s,speed_m_s,sway_m_s,rpm";
    pushed(degrees, seconds, seed, header, |_| 1.0, |_| "80".into())
}

/// The same with the share `part(t)` of the thrust for 6 m/s, and `last` of that share in the last column.
fn pushed(
    degrees: f64,
    seconds: f64,
    seed: u64,
    header: &str,
    part: impl Fn(f64) -> f64,
    last: impl Fn(f64) -> String,
) -> String {
    let mut state = seed;
    let mut uniform = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    // a sum of twelve uniform numbers is close enough to Gaussian
    let mut noise = move |std: f64| std * ((0..12).map(|_| uniform()).sum::<f64>() - 6.0);
    let mut text = format!("{header}\n");
    let ([m_u, m_v, i_r], [x, k]) = (INERTIA, RUDDER);
    let (mut u, mut v, mut r, mut psi, mut delta, mut order) = (6.0_f64, 0.0_f64, 0.0_f64, 0.0_f64, 0.0_f64, 0.0_f64);
    let (dt, most) = (0.02, degrees.to_radians());
    for step in 0..(seconds / dt) as usize {
        let t = step as f64 * dt;
        order = match order {
            _ if t < 20.0 => 0.0,
            _ if psi > most => -most,
            _ if psi < -most => most,
            0.0 => most,
            held => held,
        };
        if step % 50 == 0 {
            let cells = [
                delta.to_degrees(),
                (psi.to_degrees() + noise(0.1)).rem_euclid(360.0),
                r.to_degrees() + noise(0.01),
                u + noise(0.02),
                v + noise(0.02),
            ];
            let _ = write!(text, "{t:.1}");
            for x in cells {
                let _ = write!(text, ",{x:.3}");
            }
            let _ = writeln!(text, ",{}", last(part(t)));
        }
        // 3 degrees per second, the rate of a steering gear
        delta += (order - delta).clamp(-0.052 * dt, 0.052 * dt);
        let lift = -k * u * (u * delta + v + x * r);
        let du = (4_000.0 * (36.0 * part(t) - u * u) + m_v * v * r - 3_000.0 * u * u * delta * delta) / m_u;
        let dv = (-m_u * u * r - 8.0e4 * u * v + lift) / m_v;
        let dr = ((m_u - m_v) * u * v - 5.0e7 * u * r + x * lift) / i_r;
        (u, v, r, psi) = (u + dt * du, v + dt * dv, r + dt * dr, psi + dt * r);
    }
    text
}

/// Path of the campaign that `init` makes from logs of a ship with known dry mass and length, and its output.
fn begun(folder: &Folder, logs: &[String]) -> (String, String) {
    let made = folder.path("made");
    let mut arguments = vec!["init", "--mass", "2000000", "--length", "70", "-o", &made];
    arguments.extend(logs.iter().map(String::as_str));
    let said = succeeds(&arguments);
    (made, said)
}

fn fitted(folder: &Folder, campaign: &str) -> serde_json::Value {
    let json = folder.path("fit.json");
    succeeds(&["fit", campaign, "--json", &json]);
    serde_json::from_str(&fs::read_to_string(json).expect("written")).expect("JSON")
}

/// Value and standard deviation of a parameter of a fit.
fn estimate(fit: &serde_json::Value, name: &str) -> (f64, f64) {
    let found = fit["parameters"].as_array().into_iter().flatten().find(|p| p["name"] == name);
    let p = found.unwrap_or_else(|| panic!("{name}: {fit}"));
    (p["value"].as_f64().unwrap_or(f64::NAN), p["std"].as_f64().unwrap_or(f64::NAN))
}

/// Four zig-zags and the dry mass give a model with the ship's masses and its rudder, within four
/// standard deviations.
#[test]
fn zig_zags_of_a_ship_become_its_masses() {
    let folder = Folder::new("ship");
    let logs: Vec<String> = [(10.0, 400.0, 1), (20.0, 500.0, 2), (15.0, 400.0, 3), (20.0, 400.0, 4)]
        .into_iter()
        .map(|(degrees, seconds, seed)| folder.write(&format!("zz{seed}.csv"), &zigzag(degrees, seconds, seed)))
        .collect();
    let (made, said) = begun(&folder, &logs);
    assert!(!said.contains("left out"), "{said}");
    let text = fs::read_to_string(Path::new(&made).join("campaign.toml")).expect("it was written");
    for line in
        ["dofs = [\"surge\", \"sway\", \"yaw\"]", "\"bias@surge\"", "\"rudder_force\"", "undriven = [\"surge\"]"]
    {
        assert!(text.contains(line), "{line}:\n{text}");
    }
    assert!(text.contains("rpm is one constant force"), "{text}");
    // the rudder is a command, so sway and yaw are not reported as unexcited
    let (_, found) = checked(&folder);
    assert!(!found.iter().any(|code| code == "M111" || code == "K131"), "{found:?}");

    let fit = fitted(&folder, &made);
    assert_eq!(fit["converged"], true, "{fit}");
    let of = |name: &str| estimate(&fit, name);
    // the scale is only known by the prior, 2.1e6 ± 1e5; the runs determine the ratios of the masses
    let (m_u, _) = of("m_u");
    for (name, truth) in [("m_v", INERTIA[1]), ("I_r", INERTIA[2]), ("k_rudder", RUDDER[1])] {
        let (value, std) = of(name);
        assert!((value / m_u * INERTIA[0] - truth).abs() < 4.0 * std, "{name}: {value} ± {std} for {truth}");
        assert!(std < 0.25 * truth, "{name} ± {std} for {truth} says nothing");
    }
    let (place, std) = of("x_rudder");
    assert!((place - RUDDER[0]).abs() < 4.0 * std && std < 10.0, "{place} ± {std}");

    // the rate limit of the rudder is not named as a delay of thrust or as drag
    let found = folder.path("found.json");
    succeeds(&["discover", &made, "--json", &found]);
    let found: serde_json::Value = serde_json::from_str(&fs::read_to_string(found).expect("written")).expect("JSON");
    assert_eq!(found["verdict"], "nothing_missing", "{}", found["sentence"]);
}

/// Columns with the names of model basins, without units, and with the thrust of the propeller give
/// a model. With the dry mass the fit finds that the thrust deduction of the hull is a fifth.
#[test]
fn columns_of_a_basin_become_a_model_and_the_hull_takes_its_part_of_the_thrust() {
    let folder = Folder::new("basin");
    let steady = THRUST / (1.0 - DEDUCTION);
    let run = |(degrees, seed): (f64, u64)| {
        let part = move |t: f64| 1.0 + 0.3 * (0.02 * t + seed as f64).sin();
        let text =
            pushed(degrees, 400.0, seed, "time,delta,psi,r,u,vm,thrust", part, |part| format!("{:.0}", steady * part));
        folder.write(&format!("zz{seed}.csv"), &text)
    };
    let logs: Vec<String> = [(10.0, 1), (20.0, 2), (15.0, 3), (20.0, 4)].into_iter().map(run).collect();
    let (made, _) = begun(&folder, &logs);
    let text = fs::read_to_string(Path::new(&made).join("campaign.toml")).expect("it was written");
    for line in [
        "rudder = { name = \"delta\", unit = \"deg\" }",
        "v = \"vm\"",
        "F1 = \"thrust\"",
        "\"thrust_interaction_loss@surge\"",
        "\"mixed_drag@yaw:surge\"",
        "the loss of thrust at the hull is not known",
    ] {
        assert!(text.contains(line), "{line}:\n{text}");
    }
    let (verdict, found) = checked(&folder);
    assert!(found.iter().all(|code| !["M111", "K131"].contains(&code.as_str())), "{verdict} {found:?}");
    let fit = fitted(&folder, &made);
    let of = |name: &str| estimate(&fit, name);
    // both have the scale of the prior, which is known to 5 %
    let (m_u, _) = of("m_u");
    for (name, truth) in [("eta_u", 1.0 - DEDUCTION), ("m_v", INERTIA[1]), ("I_r", INERTIA[2])] {
        let (value, std) = of(name);
        assert!((value / m_u * INERTIA[0] - truth).abs() < 4.0 * std, "{name}: {value} ± {std} for {truth}");
        assert!(std < 0.25 * truth, "{name} ± {std} for {truth} says nothing");
    }
}

/// A log that counts rudder to port as positive gets a sign from `init`, and without it `check`
/// reports the sign.
#[test]
fn a_rudder_of_the_other_sign_is_turned_round() {
    let folder = Folder::new("port");
    let turned = |text: String| -> String {
        let line = |line: &str| match line.split_once(',').and_then(|(t, rest)| Some((t, rest.split_once(',')?))) {
            Some((t, (angle, rest))) if !t.starts_with('t') => {
                format!("{t},{},{rest}\n", angle.parse::<f64>().map_or(0.0, |x| -x))
            }
            _ => format!("{line}\n"),
        };
        text.lines().map(line).collect()
    };
    let log = folder.write("zz.csv", &turned(zigzag(20.0, 400.0, 5)));
    let made = folder.path("made");
    succeeds(&["init", &log, "--mass", "2000000", "--length", "70", "-o", &made]);
    let file = Path::new(&made).join("campaign.toml");
    let text = fs::read_to_string(&file).expect("it was written");
    assert!(text.contains("rudder = { name = \"rudder_angle_deg\", unit = \"deg\", sign = -1 }"), "{text}");
    let (_, found) = checked(&folder);
    assert!(!found.contains(&"K121".to_string()), "{found:?}");
    // without the sign it is reported
    fs::write(&file, text.replace(", sign = -1", "")).expect("it can be written");
    let (verdict, found) = checked(&folder);
    assert!(found.contains(&"K121".to_string()) && verdict.contains("red"), "{verdict} {found:?}");
}
