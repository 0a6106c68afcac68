//! True values of a campaign: the parameters of the baseline's terms and of the hidden effects, by
//! their names in `hydrosysid`, and the random force.
//!
//! Signs: drag positive where it dissipates, a bias b acts as −b, inertia is dry plus added.

use std::collections::BTreeMap;

use crate::campaign::Campaign;
use crate::dof::Dof;
use crate::hide::{OUTSIDE, Setup};
use crate::naming::{Name, Place};
use crate::plant::Plant;
use crate::sail::file_of_run;
use crate::slots::{V, slots};
use crate::water::Current;

/// One true value.
#[derive(Debug, Clone, PartialEq)]
pub struct TrueValue {
    /// Name of the term: `linear_drag@surge`, `coriolis_yaw`, …
    pub effect: String,
    /// Symbol of the parameter.
    pub name: String,
    /// Value, SI.
    pub value: f64,
}

/// The random force in one degree of freedom.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrueForce {
    /// Degree of freedom.
    pub dof: Dof,
    /// Root mean square, N or N·m.
    pub rms: f64,
    /// Correlation time, s.
    pub correlation: f64,
    /// Root mean square of the commanded force, N or N·m.
    pub commanded: f64,
}

/// All true values of a campaign.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Truth {
    /// Values of the parameters of baseline and hidden effects.
    pub values: Vec<TrueValue>,
    /// Names of the hidden effects.
    pub hidden: Vec<String>,
    /// The random force of each degree of freedom that has one.
    pub force: Vec<TrueForce>,
    /// Standard deviation of the noise by channel.
    pub noise: BTreeMap<String, f64>,
}

impl Truth {
    /// The value of the first parameter of a term.
    pub fn value(&self, effect: &str) -> Option<f64> {
        self.values.iter().find(|v| v.effect == effect).map(|v| v.value)
    }

    pub(crate) fn of(campaign: &Campaign, setup: &Setup, sigma: &[f64; 6], rms: &[f64; 6]) -> Truth {
        let mut setup = setup.clone();
        let hidden: Vec<String> = campaign.hidden.iter().map(|h| h.name.clone()).collect();
        let mut values = Vec::new();
        for effect in setup.baseline.clone().iter().chain(&hidden) {
            values.extend(values_of(effect, &mut setup));
        }
        let force = campaign.moves.iter().filter(|dof| sigma[dof.index()] > 0.0).map(|dof| TrueForce {
            dof: *dof,
            rms: sigma[dof.index()],
            correlation: campaign.force_of(dof.index()).correlation,
            commanded: rms[dof.index()],
        });
        let channels = setup.instruments.iter().flat_map(|one| &one.channels);
        let noise = channels.map(|c| (c.name.to_string(), c.noise)).collect();
        Truth { values, hidden, force: force.collect(), noise }
    }
}

/// Names of the effects of a plant without losses in the degrees of freedom of a model, each with its place.
pub(crate) fn baseline(plant: &Plant, dofs: &[Dof]) -> Vec<String> {
    let mut list = Vec::new();
    let inertia = plant.inertia();
    let moving: Vec<Dof> = Dof::ALL.into_iter().filter(|dof| plant.moves[dof.index()]).collect();
    list.extend(dofs.iter().map(|dof| format!("inertia@{}", dof.name())));
    for (id, matrix) in [("linear_drag", &plant.water.linear), ("quadratic_drag", &plant.water.quadratic)] {
        let cross = if id == "linear_drag" { "linear_cross_damping" } else { "cross_drag" };
        for i in dofs {
            for j in moving.iter().filter(|j| matrix[(i.index(), j.index())] != 0.0) {
                let (a, b) = (i.name(), j.name());
                list.push(if i == j { format!("{id}@{a}") } else { format!("{cross}@{a}:{b}") });
            }
        }
    }
    for i in dofs {
        // a symmetric term is listed once if both degrees of freedom are modelled
        for j in moving.iter().filter(|j| *j != i && !(dofs.contains(j) && *j < i)) {
            if inertia[(i.index(), j.index())].abs() > 1e-12 {
                list.push(format!("added_mass_coupling@{}:{}", i.name(), j.name()));
            }
        }
    }
    // the two products of each row of −C(ν)ν: of ω × P, and of v × P and ω × L
    let needs: [[[Dof; 2]; 2]; 6] = [
        [[Dof::Sway, Dof::Yaw], [Dof::Heave, Dof::Pitch]],
        [[Dof::Surge, Dof::Yaw], [Dof::Heave, Dof::Roll]],
        [[Dof::Surge, Dof::Pitch], [Dof::Sway, Dof::Roll]],
        [[Dof::Sway, Dof::Heave], [Dof::Pitch, Dof::Yaw]],
        [[Dof::Surge, Dof::Heave], [Dof::Roll, Dof::Yaw]],
        [[Dof::Surge, Dof::Sway], [Dof::Roll, Dof::Pitch]],
    ];
    for dof in dofs {
        if needs[dof.index()].iter().any(|pair| pair.iter().all(|n| dofs.contains(n))) {
            list.push(format!("coriolis_{}", dof.name()));
        }
    }
    let tilts = plant.moves[3] || plant.moves[4];
    let (weight, buoyancy) = (plant.body.weight, plant.body.buoyancy);
    for dof in dofs.iter().filter(|dof| !matches!(dof, Dof::Yaw)) {
        if (tilts || *dof == Dof::Heave) && (dof.is_rotation() || (weight - buoyancy).abs() > 0.0) {
            list.push(format!("restoring_{}", dof.name()));
        }
    }
    list
}

/// True values of one term.
fn values_of(effect: &str, setup: &mut Setup) -> Vec<TrueValue> {
    let vehicle = setup.vehicle.clone();
    let Ok(name) = Name::parse(effect, &vehicle) else { return Vec::new() };
    let one = |symbol: &str, value: f64| TrueValue { effect: effect.to_string(), name: symbol.to_string(), value };
    if OUTSIDE.contains(&name.id) {
        return Vec::new();
    }
    let inertia = setup.plant.inertia();
    let body = &setup.plant.body;
    if let Some(row) = name.coriolis_row() {
        let m = |i: usize| inertia[(i, i)];
        let (symbol, value) = [
            ("k_vr", m(1)),
            ("k_ur", m(0)),
            ("k_uq", m(0)),
            ("k_vw", m(2) - m(1)),
            ("k_wu", m(0) - m(2)),
            ("k_uv", m(1) - m(0)),
        ][row];
        return vec![one(symbol, setup.plant.coriolis[row] * value)];
    }
    match (name.id, name.place) {
        ("inertia", Place::One(i)) => return vec![one("m", inertia[(i, i)])],
        ("added_mass_coupling", Place::Pair(i, j)) => return vec![one("m", inertia[(i, j)])],
        ("restoring_surge" | "restoring_sway" | "restoring_heave", _) => {
            return vec![one("W-B", body.weight - body.buoyancy)];
        }
        ("restoring_roll" | "restoring_pitch", _) => {
            let moment = body.gravity_centre.z * body.weight - body.buoyancy_centre.z * body.buoyancy;
            return vec![one("z_gW-z_bB", moment)];
        }
        ("trim_offset", _) => {
            let share = -body.buoyancy / body.weight;
            let centre = body.buoyancy_centre;
            return vec![one("x_g", share * centre.x), one("y_g", share * centre.y)];
        }
        ("current", _) => {
            let Current::Steady(v) = setup.plant.current else { return Vec::new() };
            return vec![one("V_N", v.x), one("V_E", v.y)];
        }
        ("current_each_run", _) => {
            return of_runs(effect, &["V_N", "V_E"], setup.currents.iter().map(|v| vec![v.x, v.y]));
        }
        ("earth_force_each_run", _) => {
            return of_runs(effect, &["F_N", "F_E"], setup.pushes.iter().map(|f| f.to_vec()));
        }
        ("bias_each_run", Place::One(i)) => {
            let symbol = format!("b_{}", V[i]);
            return of_runs(effect, &[&symbol], setup.biases[i].iter().map(|b| vec![*b]));
        }
        ("thruster_loss", Place::Thruster(k)) => {
            return setup.plant.actuation.thrusters.get(k).map(|t| one("k", t.loss.0)).into_iter().collect();
        }
        ("thruster_advance_loss", _) => {
            return setup
                .plant
                .actuation
                .thrusters
                .first()
                .map(|t| one("k_advance", t.advance_loss))
                .into_iter()
                .collect();
        }
        ("sensor_delay", _) => {
            return setup.instruments.first().map(|i| one("T_log", i.latency)).into_iter().collect();
        }
        ("sensor_clock_drift", _) => return vec![one("delta_clock", setup.clock_drift)],
        ("sensor_dvl_delay", _) => {
            let dvl = setup.instruments.iter().find(|i| i.has("u"));
            return dvl.map(|i| one("T_dvl", i.latency)).into_iter().collect();
        }
        ("sensor_gyro_lag", _) => {
            let gyro = setup.instruments.iter().find(|i| i.is_gyro());
            return gyro.map(|i| one("T_gyro_lag", i.low_pass)).into_iter().collect();
        }
        ("sensor_position_delay", _) => {
            let fix = setup.instruments.iter().find(|i| i.has("x"));
            return fix.map(|i| one("T_xy", i.latency)).into_iter().collect();
        }
        ("sensor_dvl_scale", _) => {
            return crate::slots::of(&mut setup.instruments, "u").map(|c| one("s_dvl", c.scale)).into_iter().collect();
        }
        ("sensor_tilt_offset", _) => {
            let mut bias = |channel| crate::slots::of(&mut setup.instruments, channel).map_or(0.0, |c| c.bias);
            return vec![one("c_phi", bias("phi")), one("c_theta", bias("theta"))];
        }
        _ => {}
    }
    slots(&name, setup).into_iter().flatten().map(|(symbol, value)| one(&symbol, *value)).collect()
}

/// True values of a term with its own values in each run, run by run: `V_N of run00.csv`.
fn of_runs(effect: &str, symbols: &[&str], runs: impl Iterator<Item = Vec<f64>>) -> Vec<TrueValue> {
    let of_run = |(run, values): (usize, Vec<f64>)| {
        let of = |(symbol, value): (&&str, f64)| TrueValue {
            effect: effect.to_string(),
            name: format!("{symbol} of {}", file_of_run(run)),
            value,
        };
        symbols.iter().zip(values).map(of).collect::<Vec<_>>()
    };
    runs.enumerate().flat_map(of_run).collect()
}
