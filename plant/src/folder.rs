//! Writes a campaign as the folder that `hydrosysid` reads: `campaign.toml` and one CSV file for
//! each run; and `truth.json`.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

use serde_json::{Value, json};

use crate::campaign::{Commands, PlantError};
use crate::commands::Input;
use crate::dof::Dof;
use crate::sail::Sailed;

impl Sailed {
    /// Writes the folder; files that are there already are replaced.
    ///
    /// # Errors
    /// [`PlantError::File`].
    pub fn write(&self, folder: &Path) -> Result<(), PlantError> {
        let failed = |path: &Path, e: &std::io::Error| PlantError::File {
            path: path.display().to_string(),
            reason: e.to_string(),
        };
        std::fs::create_dir_all(folder).map_err(|e| failed(folder, &e))?;
        let write = |name: &str, text: &str| {
            let path = folder.join(name);
            std::fs::write(&path, text).map_err(|e| failed(&path, &e))
        };
        for log in &self.logs {
            write(&log.name, &log.csv(self.command_unit()))?;
        }
        write("campaign.toml", &self.campaign_toml())?;
        write("truth.json", &format!("{:#}\n", self.truth_json()))
    }

    /// Unit of the thrusters' commands: `1` if no command exceeds 1, else `V`.
    fn command_unit(&self) -> &'static str {
        if self.vehicle.thrusters.iter().all(|t| t.max <= 1.0) { "1" } else { "V" }
    }

    /// The campaign file, with the baseline model that a user of the vehicle would write.
    pub fn campaign_toml(&self) -> String {
        let (campaign, body) = (&self.campaign, &self.vehicle.plant.body);
        let mut text = format!(
            "format = 1\n[vehicle]\nname = \"{}\"\nmass = {}\nvolume = {}\nweight = {}\nbuoyancy = {}\nlength = {}\n",
            self.vehicle.name, body.mass, self.vehicle.volume, body.weight, body.buoyancy, self.vehicle.length
        );
        text.push_str("[water]\ndensity = 1000.0\nkinematic_viscosity = 1.004e-6\n");
        let input = if campaign.input == Input::Hold { "hold" } else { "linear" };
        let dofs: Vec<&str> = campaign.dofs.iter().map(|d| d.name()).collect();
        let _ = write!(
            text,
            "[model]\ndofs = {dofs:?}\neffects = {:?}\ncoriolis = \"tied\"\ninput = \"{input}\"\n[log]\n",
            collapsed(&self.baseline, &campaign.dofs)
        );
        if !self.logs.iter().all(super::log::Log::is_full) {
            text.push_str("missing = \"no_sample\"\n");
        }
        text.push_str("position_source = \"independent\"\nvelocity_reference = \"ground\"\n");
        if campaign.commands == Commands::Thrusters {
            for t in &self.vehicle.thrusters {
                let (p, s) = (t.position, t.axis);
                let _ = write!(
                    text,
                    "[[thruster]]\nname = \"{}\"\nposition = [{}, {}, {}]\naxis = [{}, {}, {}]\n\
                     forward = {{ a = {}, b = {} }}\nreverse = {{ a = {}, b = {} }}\ndeadband = {}\nmax = {}\n",
                    t.name,
                    p.x,
                    p.y,
                    p.z,
                    s.x,
                    s.y,
                    s.z,
                    t.forward.0,
                    t.forward.1,
                    t.reverse.0,
                    t.reverse.1,
                    t.deadband,
                    t.max
                );
            }
        }
        for log in &self.logs {
            let role = if log.validates { "validate" } else { "train" };
            let _ = write!(text, "[[run]]\nfile = \"{}\"\nkind = \"{}\"\nrole = \"{role}\"\n", log.name, log.kind);
        }
        text
    }

    /// The true values, and how the campaign was made.
    pub fn truth_json(&self) -> Value {
        let truth = &self.truth;
        let values: Vec<Value> =
            truth.values.iter().map(|v| json!({ "effect": v.effect, "name": v.name, "value": v.value })).collect();
        let force: Vec<Value> = truth
            .force
            .iter()
            .map(|f| {
                json!({ "dof": f.dof.name(), "rms": f.rms, "correlation_time": f.correlation,
                        "unit": if f.dof.is_rotation() { "N*m" } else { "N" }, "share_of_thrust": f.rms / f.commanded })
            })
            .collect();
        let sizes: BTreeMap<&str, f64> = self.campaign.hidden.iter().map(|h| (h.name.as_str(), h.size)).collect();
        json!({
            "hidden": truth.hidden,
            "sizes": sizes,
            "parameters": values,
            "force": force,
            "sensors": truth.noise,
            "vehicle": self.vehicle.name,
            "seed": self.campaign.seed,
        })
    }
}

/// Names of effects; an effect that is there in all of `dofs` is given once, by its id.
fn collapsed(names: &[String], dofs: &[Dof]) -> Vec<String> {
    let mut list: Vec<String> = Vec::new();
    for name in names {
        let Some((id, place)) = name.split_once('@') else {
            list.push(name.clone());
            continue;
        };
        let everywhere = !place.contains(':') && dofs.iter().all(|d| names.contains(&format!("{id}@{}", d.name())));
        let entry = if everywhere { id.to_string() } else { name.clone() };
        if !list.contains(&entry) {
            list.push(entry);
        }
    }
    list
}
