//! Velocities through the water, as measured by a log wheel or a water-tracking DVL:
//! `velocity_reference = "water"`, on the plant in a current.

use std::path::{Path, PathBuf};

use hydrosysid::campaign::{self, Campaign, FitOptions, LoadOptions};
use hydrosysid_plant::{Campaign as Sea, Dof as Axis, Hidden, RandomForce, Sailed, Vehicle};

use crate::changed_logs::change_logs;

/// Logs of the plant in a current, whose velocities over ground are replaced by velocities through
/// the water, u − Rᵀ V.
fn sailed(name: &str, seed: u64) -> (Sailed, PathBuf) {
    let mut sea = Sea::new(Vehicle::named("laurs").expect("it exists"), &Axis::PLANE);
    (sea.runs, sea.duration, sea.seed) = (6, 60.0, seed);
    sea.force = RandomForce { share: 0.02, correlation: 1.0 };
    sea.hidden = vec![Hidden::new("current")];
    let sailed = sea.sail().expect("it sails");
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("through_water_{name}"));
    let _ = std::fs::remove_dir_all(&folder);
    sailed.write(&folder).expect("the folder can be written");
    let water = |symbol: &str| {
        let of = sailed.truth.values.iter().find(|v| v.effect == "current" && v.name == symbol);
        of.expect("the truth has a current").value
    };
    let (north, east) = (water("V_N"), water("V_E"));
    change_logs(&folder, |text| through(text, north, east));
    (sailed, folder.join("campaign.toml"))
}

fn through(text: &str, north: f64, east: f64) -> String {
    let (head, rows) = text.split_once('\n').expect("a header");
    let names: Vec<&str> = head.split(',').map(|h| h.split(' ').next().unwrap_or(h)).collect();
    let at = |name: &str| names.iter().position(|n| *n == name).unwrap_or_else(|| panic!("no {name} in {head}"));
    let (u, v, psi) = (at("u"), at("v"), at("psi"));
    let row = |line: &str| {
        let mut cells: Vec<String> = line.split(',').map(str::to_string).collect();
        let number = |cells: &[String], k: usize| cells[k].parse::<f64>().expect("a number");
        let (sin, cos) = number(&cells, psi).sin_cos();
        cells[u] = (number(&cells, u) - (cos * north + sin * east)).to_string();
        cells[v] = (number(&cells, v) - (cos * east - sin * north)).to_string();
        cells.join(",") + "\n"
    };
    head.to_string() + "\n" + &rows.lines().map(row).collect::<String>()
}

fn referred(file: &Path, reference: &str, effects: &str) -> Result<Campaign, campaign::Error> {
    let text = std::fs::read_to_string(file).expect("it was written");
    let at = text.find("velocity_reference").expect("the plant says it");
    let end = at + text[at..].find('\n').expect("a line");
    let said = format!("{}velocity_reference = \"{reference}\"{}", &text[..at], &text[end..]);
    let said = said.replacen("effects = [", &format!("effects = [{effects}"), 1);
    let file = file.with_file_name(format!("{reference}{}.toml", effects.len()));
    std::fs::write(&file, said).expect("it can be written");
    Campaign::load(&file, LoadOptions::default())
}

/// Error of each estimate in standard deviations, with its name.
fn off(campaign: &Campaign, sailed: &Sailed) -> Vec<(f64, String)> {
    let fit = campaign::fit(campaign, FitOptions::default()).expect("it can be fitted");
    assert!(fit.converged);
    let of = |p: &hydrosysid::model::Parameter| {
        let of_term = || sailed.truth.values.iter().filter(|v| v.effect == p.term);
        let truth = of_term().find(|v| v.name == p.spec.name).or_else(|| of_term().next()).expect("the truth knows it");
        let off = (p.value - truth.value).abs() / p.std.expect("it is estimated");
        (off, format!("{}: {} for {}", p.full_name(), p.value, truth.value))
    };
    fit.model.parameters.iter().map(of).collect()
}

/// Velocities through the water together with positions determine vehicle and current. By chance
/// one of eleven estimates is beyond 3.5 standard deviations in 1 of 200 cases.
#[test]
fn velocities_through_the_water_tell_vehicle_and_current() {
    let (sailed, file) = sailed("both", 4402);
    let campaign = referred(&file, "water", "\"current\", ").expect("it is a campaign");
    assert!(campaign.model.through_water);
    let told = off(&campaign, &sailed);
    assert!(told.len() == 11 && told.iter().all(|(off, _)| *off < 3.5), "{told:#?}");
    // taken as velocities over ground they contradict the positions: at the same parameters the
    // errors are far larger
    let fit = campaign::fit(&campaign, FitOptions::default()).expect("it can be fitted");
    let ground = referred(&file, "ground", "\"current\", ").expect("it is a campaign");
    let rms = |campaign: &Campaign| {
        let mut model = fit.model.clone();
        model.through_water = campaign.model.through_water;
        let compared = campaign::simulate(campaign, &model, &fit.envelope).expect("it can be simulated");
        let of_run = |run: &campaign::Simulated| {
            let pairs = run.measured["u"].iter().zip(&run.simulated["u"]).filter_map(|(m, s)| Some((*m)? - *s));
            pairs.map(|e| e * e).sum::<f64>()
        };
        compared.runs.iter().map(of_run).sum::<f64>()
    };
    assert!(rms(&ground) > 10.0 * rms(&campaign), "{} and {}", rms(&ground), rms(&campaign));
}

/// Without positions, velocities through the water show no current, and the model without a current is right.
#[test]
fn without_positions_the_plain_model_is_right() {
    let (sailed, file) = sailed("plain", 4403);
    let text = std::fs::read_to_string(&file).expect("it was written");
    std::fs::write(&file, text.replace("\"independent\"", "\"dead_reckoned\"")).expect("it can be written");
    let campaign = referred(&file, "water", "").expect("it is a campaign");
    let told = off(&campaign, &sailed);
    // nine estimates, as above
    assert!(told.len() == 9 && told.iter().all(|(off, _)| *off < 3.5), "{told:#?}");
}

#[test]
fn runs_of_both_references_are_refused_by_name() {
    let (_, file) = sailed("mixed", 4404);
    let text = std::fs::read_to_string(&file).expect("it was written");
    let last = text.rfind("role = ").expect("a run");
    let mixed = format!("{}log = {{ velocity_reference = \"water\" }}\n{}", &text[..last], &text[last..]);
    std::fs::write(&file, mixed).expect("it can be written");
    let error = Campaign::load(&file, LoadOptions::default()).expect_err("two references");
    let told = error.findings();
    assert!(told.len() == 1 && told[0].code == "M146" && told[0].message.contains("run00.csv"), "{told:?}");
}
