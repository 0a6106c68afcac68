//! Six degrees of freedom, fully coupled: full symmetric inertia, Coriolis, linear and quadratic
//! drag with cross terms, restoring. Output error recovers all parameters from logs of the
//! independent plant (`plant/`).

use std::path::PathBuf;

use hydrosysid::campaign::{self, Campaign, Fit, FitOptions, LoadOptions};
use hydrosysid_plant::{Campaign as Sea, Dof, Hidden, Manoeuvre, Sailed, Suite, Vehicle};

/// All couplings of the inertia that the vehicle does not have already, and four of the drag.
fn couplings() -> Vec<String> {
    let mut names: Vec<String> =
        ["cross_drag@sway:yaw", "cross_drag@yaw:sway", "cross_drag@heave:pitch"].map(String::from).into();
    names.push("linear_cross_damping@pitch:heave".into());
    for dof in Dof::ALL {
        let apart = |other: &Dof| ![(Dof::Surge, Dof::Pitch), (Dof::Sway, Dof::Roll)].contains(&(dof, *other));
        for other in Dof::ALL.into_iter().filter(|other| other.index() > dof.index()).filter(apart) {
            names.push(format!("added_mass_coupling@{}:{}", dof.name(), other.name()));
        }
    }
    names
}

/// Nine runs of 60 s, six of them training runs, in which all degrees of freedom move.
fn sail(noise: f64) -> Sailed {
    let mut sea = Sea::new(Vehicle::named("heavy").expect("it exists"), &Dof::ALL);
    sea.runs = 9;
    sea.manoeuvres = vec![Manoeuvre::Multisine];
    sea.hidden = couplings().iter().map(|name| Hidden { name: name.clone(), size: 0.4 }).collect();
    sea.instruments = Suite { noise, ..Suite::default() }.instruments(&Dof::ALL);
    sea.sail().expect("it sails")
}

/// The fit of the campaign with all couplings in its model, and for each free parameter its name,
/// value, standard deviation and true value.
fn fitted(name: &str, sailed: &Sailed, longest_step: f64) -> (Fit, Vec<(String, f64, f64, f64)>) {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    sailed.write(&folder).expect("the folder can be written");
    let file = folder.join("campaign.toml");
    let text = std::fs::read_to_string(&file).expect("it was written");
    let listed: String = couplings().iter().map(|name| format!("{name:?}, ")).collect();
    let fit = format!("[fit]\nestimator = \"output_error\"\nsegment = 6.0\nlongest_step = {longest_step}\n[log]\n");
    let text = text.replace("effects = [", &format!("effects = [{listed}")).replace("[log]\n", &fit);
    std::fs::write(&file, text).expect("it can be written");
    let campaign = Campaign::load(&file, LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    let fit = campaign::fit(&campaign, FitOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    let truth = |term: &str, symbol: &str| {
        let values: Vec<_> = sailed.truth.values.iter().filter(|v| v.effect == term).collect();
        let of = values.iter().find(|v| v.name == symbol).or(values.first().filter(|_| values.len() == 1));
        of.unwrap_or_else(|| panic!("the truth does not know {term} {symbol}")).value
    };
    let free = fit.model.parameters.iter().filter(|p| !p.fixed);
    let rows = free.map(|p| {
        let std = p.std.unwrap_or_else(|| panic!("{} has no deviation", p.term));
        (format!("{} {}", p.term, p.spec.name), p.value, std, truth(&p.term, &p.spec.name))
    });
    let rows = rows.collect();
    (fit, rows)
}

/// Without noise all parameters are found within 0.1 %. Only the two integrators differ, by about
/// 1e-8 of the motion, which changes even the weakest parameter by less than 1e-4 of its value.
#[test]
fn exact_unknowns_of_a_coupled_vehicle_from_data_without_noise() {
    let (fit, rows) = fitted("six_exact", &sail(0.0), 0.02);
    assert!(rows.len() >= 39, "{}", rows.len());
    for (name, value, _, truth) in &rows {
        assert!((value / truth - 1.0).abs() < 1e-3, "{name}: {value} for {truth}");
    }
    assert!(fit.converged);
}

/// With ordinary noise, the 95 % intervals cover the truth: at most six of 39 do not, and none is
/// off by four standard deviations. By chance this fails in less than 1 of 100 cases.
#[test]
fn law_intervals_of_a_coupled_vehicle_hold_the_truth() {
    let (_, rows) = fitted("six_noise", &sail(1.0), 0.1);
    let off: Vec<(&str, f64)> = rows.iter().map(|(name, v, std, truth)| (name.as_str(), (v - truth) / std)).collect();
    let outside: Vec<_> = off.iter().filter(|(_, z)| z.abs() > 1.96).collect();
    assert!(
        outside.len() <= 6 && off.iter().all(|(_, z)| z.abs() < 4.0),
        "{} of {}: {outside:?}",
        outside.len(),
        off.len()
    );
}
