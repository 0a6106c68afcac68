//! Candidates that further columns of the log bring with them: what blows, flows or thins out is known there, and only
//! how much of it the vehicle feels is not.
//!
//! ```text
//! wind      k W² (cos γ, sin γ, sin 2γ)          γ = ψ_W − ψ         surge, sway, yaw
//! density   k (ρ − ρ̄) (sin θ, −cos θ sin φ, −cos θ cos φ)            buoyancy, k = g V
//!           −k (ρ/ρ̄ − 1) νᵢ|νᵢ|                                      drag
//! current   k (νᵢ|νᵢ| − (νᵢ − cᵢ)|νᵢ − cᵢ|),  k cᵢ                   c = Rᵀ(ψ) (V_N, V_E)
//! ```
//!
//! W, ψ_W: speed (m/s) and direction (rad) of the wind; ρ: density, kg/m³, ρ̄ its median; V_N, V_E: velocity of the water, m/s. A
//! direction from where it blows and one to where it blows differ by the sign of k. The supply voltage has an effect of
//! the catalogue. Each becomes an `[[effect]]` of the campaign, role `candidate`, as though its file held it; a column
//! that a formula of the user reads brings nothing. Fossen, *Handbook of Marine Craft Hydrodynamics and Motion Control*,
//! 2nd ed. (2021), ch. 10.

use super::codes;
use super::file::{CampaignFile, EffectRole, EffectTable};
use super::moves::moves;
use crate::finding::Finding;
use crate::formula::Formula;
use crate::frame::Dof;
use crate::log::check::statistics::median;
use crate::run::Run;
use crate::units::Dimension;

const WIND_SPEED: &[&str] = &["wind_speed", "wind", "wind_mps"];
const WIND_DIRECTION: &[&str] = &["wind_dir", "wind_direction", "wind_from"];
const DENSITY: &[&str] = &["density", "water_density", "rho", "density_kgm3"];
const CURRENT: &[(&str, &str)] =
    &[("current_north", "current_east"), ("current_n", "current_e"), ("water_north", "water_east")];
const CURRENT_POLAR: &[(&str, &str)] = &[("current_speed", "current_dir"), ("current_speed", "current_direction")];

/// What the columns of `runs` bring, added to the `[[effect]]` tables of the campaign; one finding a column.
pub(super) fn bring(file: &mut CampaignFile, runs: &[Run]) -> (Vec<EffectTable>, Vec<Finding>) {
    let free: Vec<&Run> = runs.iter().filter(|run| moves(run.kind)).collect();
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
    /// The first of `names` that every run logs and no formula of the user reads.
    fn column(&self, names: &[&'static str]) -> Option<&'static str> {
        names.iter().copied().find(|name| self.logged(name) && !self.read(name))
    }

    fn logged(&self, name: &str) -> bool {
        self.runs.iter().all(|run| run.signal(name).is_some_and(|s| !s.is_empty()))
    }

    fn read(&self, name: &str) -> bool {
        let formulas = self.file.effects.iter().filter_map(|e| Formula::parse(&e.formula).ok());
        formulas.into_iter().any(|f| f.names().contains(name))
    }

    /// Smallest and greatest value of a column.
    fn range(&self, name: &str) -> (f64, f64) {
        let values = self.runs.iter().filter_map(|run| run.signal(name)).flat_map(|s| s.values());
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(*x), b.max(*x)))
    }

    /// Median of a column that is there: one bad sample does not move it.
    fn median(&self, name: &str) -> f64 {
        let values = self.runs.iter().filter_map(|run| run.signal(name)).flat_map(|s| s.values());
        median(values.copied()).unwrap_or(0.0)
    }

    /// A degree of freedom that is modelled.
    fn models(&self, dof: Dof) -> bool {
        self.file.model.dofs.contains(&dof)
    }

    /// Whether a formula can read the angle: it is simulated or logged.
    fn knows(&self, angle: Dof) -> bool {
        self.models(angle) || self.logged(angle.position())
    }

    fn add(&mut self, id: &str, dof: Dof, unit: Dimension, formula: String) {
        let id = format!("{id}_{dof}");
        if self.models(dof) && !self.file.effects.iter().any(|e| e.id == id) {
            self.tables.push(EffectTable { id, dof, formula, unit, role: EffectRole::Candidate });
        }
    }

    /// Says which candidates a column has brought since there were `before` of them.
    fn tell(&mut self, columns: &str, what: &str, before: usize) {
        let ids: Vec<&str> = self.tables[before..].iter().map(|t| t.id.as_str()).collect();
        if !ids.is_empty() {
            let text = format!("{columns}: {what}; candidates {}", ids.join(", "));
            self.findings.push(Finding::new(&codes::COLUMN, text));
        }
    }

    /// The direction as a formula in rad; what is beyond two turns is taken for degrees, and said.
    fn angle(&self, name: &str) -> (String, &'static str) {
        let (low, high) = self.range(name);
        if low.abs().max(high.abs()) > 2.0 * std::f64::consts::TAU {
            (format!("{name}*pi/180"), " (taken as degrees: it goes beyond two turns)")
        } else {
            (name.to_string(), "")
        }
    }

    fn wind(&mut self) {
        let (Some(speed), Some(direction)) = (self.column(WIND_SPEED), self.column(WIND_DIRECTION)) else { return };
        if !self.knows(Dof::Yaw) || self.range(speed).1 <= 0.0 {
            return;
        }
        let (angle, said) = self.angle(direction);
        let before = self.tables.len();
        let force = Dimension::new(1, -1, 0);
        self.add("wind", Dof::Surge, force, format!("{speed}^2*cos({angle} - psi)"));
        self.add("wind", Dof::Sway, force, format!("{speed}^2*sin({angle} - psi)"));
        self.add("wind", Dof::Yaw, Dimension::new(1, 0, 0), format!("{speed}^2*sin(2*({angle} - psi))"));
        self.tell(&format!("{speed}, {direction}{said}"), "drag of the wind may act", before);
    }

    fn density(&mut self) {
        let Some(name) = self.column(DENSITY) else { return };
        let (low, high) = self.range(name);
        // a column that never changes tells nothing; a sigma-t (5 kg/m3) or a density of air is no density of water in kg/m3
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
            &format!("buoyancy and drag may follow the density (about its median, {mean:.1} kg/m3)"),
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
        self.tell(&columns, "drag may act on the motion through this current", before);
    }

    fn supply(&mut self) {
        let volts: Vec<f64> =
            self.runs.iter().filter_map(|run| run.supply_voltage()).flat_map(|s| s.values().iter().copied()).collect();
        let every = self.runs.iter().all(|run| run.supply_voltage().is_some());
        let (low, high) = volts.iter().fold((f64::INFINITY, 0.0_f64), |(a, b), x| (a.min(*x), b.max(*x)));
        if every && high > low {
            let text =
                format!("supply voltage, {low:.2} to {high:.2} V: thrust may follow it; candidate supply_voltage");
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
        assert_eq!(formula("wind_surge"), Some("wind_speed^2*cos(wind_dir*pi/180 - psi)"));
        assert_eq!(formula("density_buoyancy_surge"), Some("(density - 1008.000)*sin(theta)"));
        assert_eq!(formula("logged_current_linear_sway"), Some("(current_east*cos(psi) - current_north*sin(psi))"));
        assert!(brought.iter().all(|t| Formula::parse(&t.formula).is_ok() && t.role == EffectRole::Candidate));
        assert_eq!((file.effects.len(), findings.len()), (brought.len(), 4));
        assert!(findings[0].message.contains("taken as degrees"), "{}", findings[0].message);
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
