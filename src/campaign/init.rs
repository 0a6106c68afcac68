//! The verb `init`: a commented campaign file from a set of logs and what is known of the vehicle.
//!
//! Nothing is guessed: what the logs hold decides the degrees of freedom, everything else is written as a question.

use std::fmt::Write;
use std::path::Path;

use super::error::Error;
use crate::frame::Dof;
use crate::log::{self, LogOptions};
use crate::vehicle::Vehicle;

/// What is known of the vehicle, SI; what is absent is written as a comment.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct InitFacts {
    /// Name shown to people.
    pub name: String,
    /// Dry mass, kg.
    pub mass: Option<f64>,
    /// Displaced volume, m³.
    pub volume: Option<f64>,
    /// Weight, N.
    pub weight: Option<f64>,
    /// Buoyancy, N.
    pub buoyancy: Option<f64>,
    /// Characteristic length, m.
    pub length: Option<f64>,
}

impl InitFacts {
    /// Refuses figures that cannot be.
    ///
    /// # Errors
    /// [`Error::Asked`] for one that is not positive and finite.
    fn validate(&self) -> Result<(), Error> {
        let InitFacts { mass, volume, weight, buoyancy, length, .. } = *self;
        let vehicle = Vehicle { mass, volume, weight, buoyancy, length, ..Vehicle::default() };
        vehicle.validate().map_err(|e| Error::Asked(e.to_string()))
    }
}

/// The text of a campaign over `logs`: each a path to read and the text that is to stand in the campaign.
///
/// # Errors
/// [`Error::Log`] for a log that cannot be read at all, [`Error::Asked`] for a figure that is not positive and finite.
pub fn init(logs: &[(&Path, String)], facts: &InitFacts, options: &LogOptions) -> Result<String, Error> {
    facts.validate()?;
    // a TOML string: Rust escapes other characters in other ways
    let quoted = |text: &str| toml::Value::from(text).to_string();
    let mut dofs: Vec<Dof> = Dof::ALL.to_vec();
    let mut driven: Vec<Dof> = Vec::new();
    let mut runs = String::new();
    for (path, shown) in logs {
        let read = log::read(path, options, &["t"]).map_err(|source| Error::Log { run: shown.clone(), source })?;
        let has = |channel: &str| read.signals.contains_key(channel);
        let towed = Dof::ALL.iter().any(|dof| has(dof.load()));
        let thrusters = has("V1") || has("F1");
        if !towed {
            dofs.retain(|dof| has(dof.velocity()) && (thrusters || has(dof.force())));
        }
        // a column of zeros is no command
        let pushes = |dof: &Dof| read.signals.get(dof.force()).is_some_and(|s| s.values().iter().any(|x| *x != 0.0));
        driven.extend(Dof::ALL.into_iter().filter(|dof| thrusters || pushes(dof)));
        let last = read.time.last().zip(read.time.first()).map_or(0.0, |(b, a)| b - a);
        let kind = if towed { "bollard" } else { "free" };
        let _ = write!(
            runs,
            "\n[[run]]\nfile = {}   # {} rows, {last:.1} s\nkind = \"{kind}\"   # bollard | towing | constant_velocity | oscillatory | zigzag | free\nrole = \"{}\"   # train | validate: takes no part in the fit\n",
            quoted(shown),
            read.rows,
            if logs.len() > 2 && shown == &logs[logs.len() - 1].1 { "validate" } else { "train" },
        );
    }
    dofs.retain(|dof| driven.contains(dof));
    if dofs.is_empty() {
        dofs = vec![Dof::Surge, Dof::Sway, Dof::Yaw];
    }
    let names: Vec<String> = dofs.iter().map(|dof| format!("\"{dof}\"")).collect();
    let mut effects = vec!["inertia".to_string(), "linear_drag".into(), "quadratic_drag".into()];
    let has = |dof| dofs.contains(&dof);
    for (dof, needed) in
        [(Dof::Surge, [Dof::Sway, Dof::Yaw]), (Dof::Sway, [Dof::Surge, Dof::Yaw]), (Dof::Yaw, [Dof::Surge, Dof::Sway])]
    {
        if has(dof) && needed.into_iter().all(has) {
            effects.push(format!("coriolis_{dof}"));
        }
    }
    let effects: Vec<String> = effects.iter().map(|e| format!("\"{e}\"")).collect();
    let figures = [
        ("mass", facts.mass, "dry mass, kg"),
        ("volume", facts.volume, "displaced volume, m3"),
        ("weight", facts.weight, "weight in air, N"),
        ("buoyancy", facts.buoyancy, "buoyancy, N"),
        ("length", facts.length, "characteristic length, m; volume^(1/3) when absent"),
    ];
    let mut text = format!(
        "# A campaign of hydrosysid: one vehicle, its runs, and the model to fit. SI units.\nformat = 1\n\n[vehicle]\nname = {}\n",
        quoted(&facts.name)
    );
    for (key, value, meaning) in figures {
        let _ = match value {
            Some(value) => writeln!(text, "{key} = {value:?}   # {meaning}"),
            None => writeln!(text, "# {key} =    # {meaning}"),
        };
    }
    let _ = write!(
        text,
        "\n[water]\ndensity = 1000.0   # kg/m3\nkinematic_viscosity = 1.004e-6   # m2/s, fresh water of 20 degrees\n\n[model]\ndofs = [{}]   # surge sway heave roll pitch yaw\neffects = [{}]   # `hydrosysid effects` lists them\ncoriolis = \"tied\"   # \"tied\" to the inertias | \"free\" coefficients\ninput = \"linear\"   # what commands do between samples: \"linear\" | \"hold\"\n",
        names.join(", "),
        effects.join(", ")
    );
    text += "\n[log]\n# position_source = \"independent\"   # x, y measured apart from the velocity (acoustics, GNSS); \"dead_reckoned\" otherwise\n# velocity_reference = \"ground\"   # what u, v, w are measured against: \"ground\" | \"water\"\n";
    let usual = LogOptions::default();
    if *options != usual {
        // only what differs from the defaults
        let (own, plain) = (toml::Table::try_from(options), toml::Table::try_from(&usual));
        if let (Ok(own), Ok(plain)) = (own, plain) {
            let changed: toml::Table = own.into_iter().filter(|(key, value)| plain.get(key) != Some(value)).collect();
            // under its heading, so that a table in it gets its whole name
            let section = toml::Table::from_iter([("log".to_string(), toml::Value::from(changed))]).to_string();
            text += section.strip_prefix("[log]\n").unwrap_or(&section);
        }
    }
    text += "\n# What is known of a parameter beforehand:\n# [[parameter]]\n# effect = \"quadratic_drag@surge\"\n# value = 309.07\n# fixed = true   # or std = 20.0 as a prior, min = , max = ; or tie = \"quadratic_drag@sway\", one unknown with that\n";
    Ok(text + &runs)
}
