//! Candidates that further columns of the log suggest: wind, density or current is logged, and only
//! the strength of its effect on the vehicle is unknown.
//!
//! ```text
//! wind      −k A (a_u, a_v),  −2 k a_u a_v       A² = a_u² + a_v²    surge, sway, yaw
//!           a = (u + W cos γ, v + W sin γ),  γ = ψ_W − ψ             true wind, ψ_W where it blows from
//!           a = A (cos γ, sin γ)                                     apparent wind, γ from the bow
//! density   k (ρ − ρ̄) (sin θ, −cos θ sin φ, −cos θ cos φ)            buoyancy, k = g V
//!           −k (ρ/ρ̄ − 1) νᵢ|νᵢ|                                      drag
//! current   k (νᵢ|νᵢ| − (νᵢ − cᵢ)|νᵢ − cᵢ|),  k cᵢ                   c = Rᵀ(ψ) (V_N, V_E)
//! ```
//!
//! W, ψ_W: speed (m/s) and direction (rad) of the wind; a: speed of the air that meets the vehicle
//! from ahead and from starboard, the vehicle's own motion included; ρ: density, kg/m³, ρ̄ its
//! median; V_N, V_E: velocity of the water, m/s. If nothing says whether a direction is the one the
//! wind blows from or to, both are tried. The supply voltage has an effect in the catalogue.
//!
//! Each candidate becomes an `[[effect]]` of the campaign with the role `candidate`, as if its file
//! held it. If the campaign lists it in `effects`, it is in the model from the start. A column that
//! a formula of the user reads suggests nothing. Fossen, *Handbook of Marine Craft Hydrodynamics
//! and Motion Control*, 2nd ed. (2021), ch. 10.

use super::baseline::wrong;
use super::codes;
use super::error::Error;
use super::file::{CampaignFile, EffectRole, EffectTable};
use super::moves::moves;
use crate::finding::Finding;
use crate::formula::Formula;
use crate::frame::Dof;
use crate::log::check::statistics::median;
use crate::navigation::unwrap;
use crate::run::{Run, Signal};
use crate::units::Dimension;

const WIND_SPEED: &[&str] = &["wind_speed", "wind", "wind_mps"];
const WIND_FROM: &str = "wind_from";
const WIND_TO: &str = "wind_to";
const WIND_DIRECTION: &[&str] = &[WIND_FROM, WIND_TO, "wind_dir", "wind_direction"];
const APPARENT_SPEED: &[&str] = &["apparent_wind_speed", "relative_wind_speed", "aws"];
const APPARENT_ANGLE: &[&str] = &["apparent_wind_angle", "relative_wind_angle", "awa"];
/// Directions that wrap around: the value between two rows lies on the shorter way.
const ROUND: [&[&str]; 2] = [WIND_DIRECTION, APPARENT_ANGLE];
/// Magnitude beyond which a direction is taken as degrees, rad.
const TWO_TURNS: f64 = 2.0 * std::f64::consts::TAU;
const DENSITY: &[&str] = &["density", "water_density", "rho", "density_kgm3"];
const CURRENT: &[(&str, &str)] =
    &[("current_north", "current_east"), ("current_n", "current_e"), ("water_north", "water_east")];
const CURRENT_POLAR: &[(&str, &str)] = &[("current_speed", "current_dir"), ("current_speed", "current_direction")];

/// Unwraps the directions of a run.
pub(super) fn unwind(run: &mut Run) {
    for name in ROUND.into_iter().flatten() {
        let Some(signal) = run.signals.get_mut(*name) else { continue };
        let most = signal.values().iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let unit = if most > TWO_TURNS { std::f64::consts::PI / 180.0 } else { 1.0 };
        let turned: Vec<f64> = unwrap(&signal.values().iter().map(|x| x * unit).collect::<Vec<f64>>());
        let back: Vec<f64> = turned.iter().map(|x| x / unit).collect();
        // radians that go on beyond two turns would be taken as degrees
        if unit < 1.0 || back.iter().all(|x| x.abs() <= TWO_TURNS) {
            *signal = Signal::new(signal.shared_time().clone(), back);
        }
    }
}

/// Ids of the effects that columns may suggest, without the degree of freedom; a campaign may list
/// them among its effects.
const IDS: [&str; 6] =
    ["wind", "wind_to", "density_buoyancy", "density_drag", "logged_current", "logged_current_linear"];

/// Whether an effect of this id is one that columns of the log suggest.
pub(super) fn may_bring(id: &str) -> bool {
    id.rsplit_once('_').is_some_and(|(id, dof)| IDS.contains(&id) && Dof::ALL.iter().any(|d| d.name() == dof))
}

/// Returns the first of `names` that is logged.
fn first(names: &[&'static str], logged: &impl Fn(&str) -> bool) -> Option<&'static str> {
    names.iter().copied().find(|name| logged(name))
}

/// Returns the ids of the effects in `dofs` of a wind that is `logged`. If the column does not say
/// whether the wind blows from or to its direction, it is taken to blow from there.
pub(super) fn blowing(dofs: &[Dof], logged: impl Fn(&str) -> bool) -> Vec<String> {
    let has = |names: &[&'static str]| first(names, &logged);
    let id = match (has(APPARENT_SPEED).and(has(APPARENT_ANGLE)), has(WIND_SPEED).and(has(WIND_DIRECTION))) {
        (Some(_), _) => "wind",
        (None, Some(WIND_TO)) => "wind_to",
        (None, Some(_)) => "wind",
        (None, None) => return Vec::new(),
    };
    let pushed = dofs.iter().filter(|dof| [Dof::Surge, Dof::Sway, Dof::Yaw].contains(*dof));
    pushed.map(|dof| format!("{id}_{dof}")).collect()
}

/// Whether a true wind is `logged` by columns that do not say if it blows from its direction or to
/// it.
pub(super) fn is_either_way(logged: impl Fn(&str) -> bool) -> bool {
    let has = |names: &[&'static str]| first(names, &logged);
    let is_apparent = has(APPARENT_SPEED).and(has(APPARENT_ANGLE)).is_some();
    let direction = has(WIND_SPEED).and(has(WIND_DIRECTION));
    !is_apparent && direction.is_some_and(|name| ![WIND_FROM, WIND_TO].contains(&name))
}

/// Adds the suggested effects that the campaign lists in `effects` to its `[[effect]]` tables, with
/// their formulas.
///
/// # Errors
/// [`Error::File`] if the columns of `runs` do not suggest one of them.
pub(super) fn add_listed<'a>(file: &mut CampaignFile, runs: impl Iterator<Item = &'a Run>) -> Result<(), Error> {
    let is_listed = |file: &CampaignFile, id: &str| file.model.effects.iter().any(|name| name.id == id);
    let of_user = |file: &CampaignFile, id: &str| file.effects.iter().any(|table| table.id == id);
    if !file.model.effects.iter().any(|name| may_bring(&name.id) && !of_user(file, &name.id)) {
        return Ok(());
    }
    let (tables, _) = bring(&mut file.clone(), runs);
    let listed: Vec<EffectTable> = tables.into_iter().filter(|table| is_listed(file, &table.id)).collect();
    file.effects.extend(listed);
    match file.model.effects.iter().position(|name| may_bring(&name.id) && !of_user(file, &name.id)) {
        Some(i) => {
            let text = format!(
                "`{}` depends on columns of the log, such as wind_speed and wind_dir, that not every run has",
                file.model.effects[i].id
            );
            Err(wrong(file, &format!("model.effects[{i}]"), &text))
        }
        None => Ok(()),
    }
}

/// Returns the effects that the columns of `runs` suggest and one finding per column, and adds the
/// effects to the `[[effect]]` tables of the campaign.
pub(super) fn bring<'a>(
    file: &mut CampaignFile,
    runs: impl IntoIterator<Item = &'a Run>,
) -> (Vec<EffectTable>, Vec<Finding>) {
    let free: Vec<&Run> = runs.into_iter().filter(|run| moves(run.kind)).collect();
    let mut brought = Brought { file, runs: &free, tables: Vec::new(), findings: Vec::new() };
    if !free.is_empty() {
        brought.wind();
        brought.density();
        brought.current();
        brought.supply();
    }
    let Brought { tables, findings, .. } = brought;
    file.effects.extend(tables.iter().cloned());
    (tables, findings)
}

struct Brought<'a> {
    file: &'a CampaignFile,
    runs: &'a [&'a Run],
    tables: Vec<EffectTable>,
    findings: Vec<Finding>,
}

impl Brought<'_> {
    /// Returns the first of `names` that every run logs and no formula of the user reads.
    fn column(&self, names: &[&'static str]) -> Option<&'static str> {
        names.iter().copied().find(|name| self.logged(name) && !self.read(name))
    }

    fn logged(&self, name: &str) -> bool {
        self.runs.iter().all(|run| run.signal(name).is_some_and(|s| !s.is_empty()))
    }

    fn read(&self, name: &str) -> bool {
        let of_user = self.file.effects.iter().filter(|e| !may_bring(&e.id));
        let formulas = of_user.filter_map(|e| Formula::parse(&e.formula).ok());
        formulas.into_iter().any(|f| f.names().contains(name))
    }

    /// Returns the smallest and greatest value of a column.
    fn range(&self, name: &str) -> (f64, f64) {
        let values = self.runs.iter().filter_map(|run| run.signal(name)).flat_map(|s| s.values());
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(*x), b.max(*x)))
    }

    /// Returns the median of a column that is there: one bad sample does not move it.
    fn median(&self, name: &str) -> f64 {
        let values = self.runs.iter().filter_map(|run| run.signal(name)).flat_map(|s| s.values());
        median(values.copied()).unwrap_or(0.0)
    }

    /// Whether a degree of freedom is modelled.
    fn models(&self, dof: Dof) -> bool {
        self.file.model.dofs.contains(&dof)
    }

    /// Whether a formula can read the angle, because it is simulated or logged.
    fn knows(&self, angle: Dof) -> bool {
        self.models(angle) || self.logged(angle.position())
    }

    fn add(&mut self, id: &str, dof: Dof, unit: Dimension, formula: String) {
        let id = format!("{id}_{dof}");
        if self.models(dof) && !self.file.effects.iter().any(|e| e.id == id) {
            self.tables.push(EffectTable { id, dof, formula, unit, role: EffectRole::Candidate });
        }
    }

    /// Adds a finding with the candidates that a column has added since there were `before` of
    /// them.
    fn tell(&mut self, columns: &str, what: &str, before: usize) {
        let ids: Vec<&str> = self.tables[before..].iter().map(|t| t.id.as_str()).collect();
        if !ids.is_empty() {
            let text = format!("{columns}: {what}; candidates {}", ids.join(", "));
            self.findings.push(Finding::new(&codes::COLUMN, text));
        }
    }

    /// Returns the direction as a formula in rad, with a remark if it is taken as degrees because
    /// it goes beyond two turns.
    fn angle(&self, name: &str) -> (String, &'static str) {
        let (low, high) = self.range(name);
        if low.abs().max(high.abs()) > TWO_TURNS {
            (format!("{name}*pi/180"), " (taken as degrees: its range exceeds two turns)")
        } else {
            (name.to_string(), "")
        }
    }

    fn wind(&mut self) {
        let before = self.tables.len();
        if let (Some(speed), Some(angle)) = (self.column(APPARENT_SPEED), self.column(APPARENT_ANGLE)) {
            let (gamma, said) = self.angle(angle);
            self.blow("wind", &format!("{speed}*cos({gamma})"), &format!("{speed}*sin({gamma})"), speed);
            self.tell(&format!("{speed}, {angle}{said}"), "wind drag may act", before);
            return;
        }
        let (Some(speed), Some(direction)) = (self.column(WIND_SPEED), self.column(WIND_DIRECTION)) else { return };
        if !self.knows(Dof::Yaw) || self.range(speed).1 <= 0.0 {
            return;
        }
        let (angle, said) = self.angle(direction);
        // the vehicle's own velocity through the air, where it is modelled
        let own = |dof: Dof| if self.models(dof) { dof.velocity() } else { "0" };
        let (u, v) = (own(Dof::Surge), own(Dof::Sway));
        for (id, sign, other) in [("wind", "+", WIND_TO), ("wind_to", "-", WIND_FROM)] {
            if direction != other {
                let part = |own: &str, f: &str| format!("({own} {sign} {speed}*{f}({angle} - psi))");
                let (ahead, across) = (part(u, "cos"), part(v, "sin"));
                self.blow(id, &ahead, &across, &format!("sqrt({ahead}^2 + {across}^2)"));
            }
        }
        let both = match direction {
            WIND_FROM | WIND_TO => String::new(),
            _ => format!(
                " (wind_…: {direction} is where it blows from; wind_to_…: where it blows to; call the column {WIND_FROM} or {WIND_TO} \
                 where that is known)"
            ),
        };
        self.tell(&format!("{speed}, {direction}{said}"), &format!("wind drag may act{both}"), before);
    }

    /// Adds the drag of air that meets the vehicle from ahead and from starboard at these speeds;
    /// `all` is their magnitude.
    fn blow(&mut self, id: &str, ahead: &str, across: &str, all: &str) {
        let force = Dimension::new(1, -1, 0);
        self.add(id, Dof::Surge, force, format!("-{all}*{ahead}"));
        self.add(id, Dof::Sway, force, format!("-{all}*{across}"));
        self.add(id, Dof::Yaw, Dimension::new(1, 0, 0), format!("-2*{ahead}*{across}"));
    }

    fn density(&mut self) {
        let Some(name) = self.column(DENSITY) else { return };
        let (low, high) = self.range(name);
        // a constant column tells nothing; a sigma-t (5 kg/m3) or a density of air is no density of
        // water in kg/m3
        if high <= low || low < 500.0 || high > 1500.0 {
            return;
        }
        let mean = self.median(name);
        let before = self.tables.len();
        let (roll, pitch) = (self.knows(Dof::Roll), self.knows(Dof::Pitch));
        let buoyancy = Dimension::new(0, 4, -2);
        let upright = match (pitch, roll) {
            (true, true) => "*cos(theta)*cos(phi)",
            (true, false) => "*cos(theta)",
            (false, true) => "*cos(phi)",
            (false, false) => "",
        };
        if pitch {
            self.add("density_buoyancy", Dof::Surge, buoyancy, format!("({name} - {mean:.3})*sin(theta)"));
        }
        if roll {
            let level = if pitch { "*cos(theta)" } else { "" };
            self.add("density_buoyancy", Dof::Sway, buoyancy, format!("-({name} - {mean:.3}){level}*sin(phi)"));
        }
        self.add("density_buoyancy", Dof::Heave, buoyancy, format!("-({name} - {mean:.3}){upright}"));
        for dof in [Dof::Surge, Dof::Sway, Dof::Heave] {
            let v = dof.velocity();
            let formula = format!("-({name}/{mean:.3} - 1)*{v}*abs({v})");
            self.add("density_drag", dof, Dimension::new(1, -1, 0), formula);
        }
        self.tell(
            name,
            &format!("buoyancy and drag may depend on the density (about its median, {mean:.1} kg/m3)"),
            before,
        );
    }

    fn current(&mut self) {
        let pair = |(a, b): &(&'static str, &'static str)| Some((self.column(&[a])?, self.column(&[b])?));
        let cartesian = CURRENT.iter().find_map(pair);
        let polar = CURRENT_POLAR.iter().find_map(pair);
        let (columns, north, east) = match (cartesian, polar) {
            (Some((n, e)), _) => (format!("{n}, {e}"), n.to_string(), e.to_string()),
            (None, Some((speed, direction))) => {
                let (angle, said) = self.angle(direction);
                let of = |f: &str| format!("{speed}*{f}({angle})");
                (format!("{speed}, {direction}{said}"), of("cos"), of("sin"))
            }
            (None, None) => return,
        };
        if !self.knows(Dof::Yaw) {
            return;
        }
        let before = self.tables.len();
        let along = format!("({north}*cos(psi) + {east}*sin(psi))");
        let across = format!("({east}*cos(psi) - {north}*sin(psi))");
        for (dof, c) in [(Dof::Surge, along), (Dof::Sway, across)] {
            let v = dof.velocity();
            let formula = format!("{v}*abs({v}) - ({v} - {c})*abs({v} - {c})");
            self.add("logged_current", dof, Dimension::new(1, -1, 0), formula);
            self.add("logged_current_linear", dof, Dimension::new(1, 0, -1), c);
        }
        self.tell(&columns, "drag may depend on the motion relative to this current", before);
    }

    fn supply(&mut self) {
        let volts: Vec<f64> =
            self.runs.iter().filter_map(|run| run.supply_voltage()).flat_map(|s| s.values().iter().copied()).collect();
        let every = self.runs.iter().all(|run| run.supply_voltage().is_some());
        let (low, high) = volts.iter().fold((f64::INFINITY, 0.0_f64), |(a, b), x| (a.min(*x), b.max(*x)));
        if every && high > low {
            let text =
                format!("supply voltage, {low:.2} to {high:.2} V: thrust may depend on it; candidate supply_voltage");
            self.findings.push(Finding::new(&codes::COLUMN, text));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::Signal;

    fn run(columns: &[(&str, [f64; 2])]) -> Run {
        let mut run = Run { name: "a".into(), ..Run::default() };
        for (name, values) in columns {
            run.signals.insert((*name).into(), Signal::new(vec![0.0, 1.0].into(), values.to_vec()));
        }
        run
    }

    fn campaign(dofs: &[Dof]) -> CampaignFile {
        let mut file = CampaignFile::default();
        file.model.dofs = dofs.to_vec();
        file
    }

    #[test]
    fn columns_with_a_standard_form_become_candidates() {
        let mut file = campaign(&[Dof::Surge, Dof::Sway, Dof::Yaw]);
        let log = run(&[
            ("wind_speed", [3.0, 8.0]),
            ("wind_dir", [250.0, 280.0]),
            ("density", [1004.0, 1008.0]),
            ("theta", [0.0, 0.1]),
            ("current_north", [0.1, 0.2]),
            ("current_east", [0.0, 0.1]),
            ("supply_V", [14.0, 16.0]),
        ]);
        let (brought, findings) = bring(&mut file, &[log]);
        let formula = |id: &str| brought.iter().find(|t| t.id == id).map(|t| t.formula.as_str());
        let air = ["(u + wind_speed*cos(wind_dir*pi/180 - psi))", "(v + wind_speed*sin(wind_dir*pi/180 - psi))"];
        let surge = format!("-sqrt({0}^2 + {1}^2)*{0}", air[0], air[1]);
        assert_eq!(formula("wind_surge"), Some(surge.as_str()));
        assert_eq!(formula("wind_to_surge"), Some(surge.replace(" + wind", " - wind").as_str()));
        assert_eq!(formula("density_buoyancy_surge"), Some("(density - 1008.000)*sin(theta)"));
        assert_eq!(formula("logged_current_linear_sway"), Some("(current_east*cos(psi) - current_north*sin(psi))"));
        assert!(brought.iter().all(|t| Formula::parse(&t.formula).is_ok() && t.role == EffectRole::Candidate));
        assert!(brought.iter().all(|t| may_bring(&t.id)), "{brought:?}");
        assert_eq!((file.effects.len(), findings.len()), (brought.len(), 4));
        assert!(findings[0].message.contains("taken as degrees"), "{}", findings[0].message);
    }

    #[test]
    fn apparent_wind_has_the_motion_of_the_vehicle_in_it_and_a_known_direction_is_tried_one_way() {
        let mut file = campaign(&[Dof::Sway, Dof::Yaw]);
        let apparent =
            run(&[("aws", [3.0, 8.0]), ("awa", [-0.5, 0.5]), ("wind", [3.0, 8.0]), ("wind_from", [0.0, 1.0])]);
        let (brought, _) = bring(&mut file, std::slice::from_ref(&apparent));
        let of = |brought: &[EffectTable]| -> Vec<(String, String)> {
            brought.iter().map(|t| (t.id.clone(), t.formula.clone())).collect()
        };
        let named = |id: &str, formula: &str| (id.to_string(), formula.to_string());
        assert_eq!(
            of(&brought),
            [named("wind_sway", "-aws*aws*sin(awa)"), named("wind_yaw", "-2*aws*cos(awa)*aws*sin(awa)")]
        );
        let mut file = campaign(&[Dof::Surge]);
        let known = run(&[("wind", [3.0, 8.0]), ("wind_to", [0.0, 1.0]), ("psi", [0.0; 2])]);
        let ids: Vec<String> = bring(&mut file, &[known]).0.into_iter().map(|t| t.id).collect();
        assert_eq!(ids, ["wind_to_surge"]);
    }

    #[test]
    fn what_the_campaign_lists_stands_in_its_tables_and_the_rest_is_still_asked() {
        let blown = run(&[("wind", [3.0, 8.0]), ("wind_from", [0.0, 1.0]), ("psi", [0.0; 2])]);
        let mut file = campaign(&[Dof::Surge, Dof::Sway]);
        file.model.effects.push("wind_sway".parse().unwrap());
        add_listed(&mut file, std::iter::once(&blown)).unwrap();
        assert_eq!(file.effects.iter().map(|e| e.id.as_str()).collect::<Vec<_>>(), ["wind_sway"]);
        let more: Vec<String> = bring(&mut file, [&blown]).0.into_iter().map(|t| t.id).collect();
        assert_eq!(more, ["wind_surge"]);
        let mut file = campaign(&[Dof::Surge]);
        file.model.effects.push("wind_surge".parse().unwrap());
        let told = add_listed(&mut file, std::iter::once(&run(&[("u", [0.0, 1.0])]))).unwrap_err().to_string();
        assert!(told.contains("wind_surge") && told.contains("depends on columns of the log"), "{told}");
    }

    #[test]
    fn a_wind_that_is_logged_blows_the_way_its_column_says() {
        let of = |names: &[&str]| blowing(&[Dof::Surge, Dof::Roll], |name| names.contains(&name));
        assert_eq!(of(&["wind_speed", "wind_dir"]), ["wind_surge"]);
        assert_eq!(of(&["wind_speed", "wind_to"]), ["wind_to_surge"]);
        assert_eq!(of(&["aws", "awa", "wind_speed", "wind_to"]), ["wind_surge"]);
        assert!(of(&["wind_speed"]).is_empty());
        let either = |names: &[&str]| is_either_way(|name| names.contains(&name));
        assert!(either(&["wind_speed", "wind_dir"]) && !either(&["wind_speed", "wind_from"]));
        assert!(!either(&["aws", "awa", "wind_speed", "wind_dir"]));
    }

    /// From 350° over north to 10°, and from 3.1 rad over astern to −3.1 rad.
    #[test]
    fn a_direction_goes_the_shorter_way_round() {
        let mut logged = run(&[("wind_dir", [350.0, 10.0]), ("awa", [3.1, -3.1])]);
        unwind(&mut logged);
        let middle = |name: &str| logged.signals[name].at(0.5);
        assert!((middle("wind_dir") - 360.0).abs() < 1e-9, "{}", middle("wind_dir"));
        assert!((middle("awa") - std::f64::consts::PI).abs() < 1e-9, "{}", middle("awa"));
    }

    #[test]
    fn what_the_user_has_formulated_or_does_not_change_brings_nothing() {
        let mut file = campaign(&[Dof::Surge]);
        file.effects.push(EffectTable {
            id: "sail".into(),
            dof: Dof::Surge,
            formula: "wind^2".into(),
            unit: Dimension::new(1, -1, 0),
            role: EffectRole::Candidate,
        });
        let log = run(&[("wind", [3.0, 8.0]), ("wind_dir", [0.0, 1.0]), ("psi", [0.0; 2]), ("density", [1000.0; 2])]);
        let (brought, findings) = bring(&mut file, &[log]);
        assert!(brought.is_empty() && findings.is_empty(), "{brought:?}");
    }
}
