//! Vehicle files: properties, thrusters and published parameters of a vehicle, each with its
//! source.
//!
//! A file holds the tables of a campaign that belong to the vehicle, `sources`, and `[published]`,
//! a file of parameters as `compare --params` reads it. `extends = "bluerov2"` takes over another
//! vehicle: keys of the file replace those of that vehicle, thrusters of the same name are merged
//! key by key, others are added.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::error::Error;
use super::file::{EffectTable, ObserveTable, ParameterTable};
use crate::effects::EffectName;
use crate::frame::Dof;
use crate::nearest::nearest;
use crate::thrust::efficiency::Efficiency;
use crate::thrust::thruster::Thruster;
use crate::vehicle::{Vehicle, Water};

/// Names and texts of the vehicles that come with the program.
const KNOWN: &[(&str, &str)] = &[
    ("bluerov2", include_str!("../../vehicles/bluerov2.toml")),
    ("bluerov2-heavy", include_str!("../../vehicles/bluerov2-heavy.toml")),
    ("laurs", include_str!("../../vehicles/laurs.toml")),
    ("otter", include_str!("../../vehicles/otter.toml")),
    ("remus100", include_str!("../../vehicles/remus100.toml")),
];

/// Largest number of extensions that are followed; more mean a circle.
const DEEPEST: usize = 8;

/// A vehicle file.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct VehicleFile {
    /// Vehicle, or path of a vehicle file beside this one, that it extends.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub extends: Option<String>,
    /// Sources of its numbers.
    pub sources: Vec<String>,
    /// FRAME_CONFIG of ArduSub for this frame.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ardusub_frame: Option<i64>,
    /// Speed of a propeller at a command of 1, rev/min, if its command is a part of that speed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub full_rpm: Option<f64>,
    /// Properties of the dry vehicle.
    pub vehicle: Vehicle,
    /// The water.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub water: Option<Water>,
    /// Known losses of thrust.
    pub efficiency: Efficiency,
    /// Thrusters, in the order of the commands V1, V2, …
    #[serde(rename = "thruster")]
    pub thrusters: Vec<Thruster>,
    /// Degrees of freedom and effects that suit the vehicle.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub model: Option<SuitedModel>,
    /// Prior knowledge of parameters.
    #[serde(rename = "parameter", skip_serializing_if = "Vec::is_empty")]
    pub parameters: Vec<ParameterTable>,
    /// Own effects.
    #[serde(rename = "effect", skip_serializing_if = "Vec::is_empty")]
    pub effects: Vec<EffectTable>,
    /// Observed functions of the states.
    #[serde(rename = "observe", skip_serializing_if = "Vec::is_empty")]
    pub observed: Vec<ObserveTable>,
    /// Published parameters, as `compare --params` reads them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub published: Option<toml::Table>,
}

/// The `[model]` table of a vehicle file: what suits the vehicle; a campaign takes from it what its
/// logs show.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SuitedModel {
    /// Degrees of freedom.
    pub dofs: Vec<Dof>,
    /// Effects besides inertia and drag.
    pub effects: Vec<EffectName>,
}

/// A vehicle with the text of its tables.
#[derive(Debug, Clone, PartialEq)]
pub struct KnownVehicle {
    /// Name under which it was asked for.
    pub id: String,
    /// Its tables.
    pub file: VehicleFile,
    /// The tables for a campaign as text, with the comments of the file.
    pub text: String,
    /// Folder of the file; `None` for one that comes with the program.
    pub folder: Option<PathBuf>,
}

/// Returns the vehicles that come with the program.
///
/// # Panics
/// Never: the files are part of the program, and a test reads them.
pub fn known_vehicles() -> Vec<KnownVehicle> {
    KNOWN.iter().map(|(id, _)| vehicle(id).expect("part of the program")).collect()
}

/// Returns the vehicle of this name, or of the file at this path.
///
/// # Errors
/// [`Error::Vehicle`] for an unknown name and for a file that cannot be read.
pub fn vehicle(name: &str) -> Result<KnownVehicle, Error> {
    let (text, folder) = source(name, None)?;
    let table = merged(name, &text, folder.as_deref(), DEEPEST)?;
    let extends = table.contains_key("extends");
    let file: VehicleFile = table.try_into().map_err(|e: toml::de::Error| failed(name, e.message()))?;
    if let Some(full) = file.full_rpm.filter(|full| !(full.is_finite() && *full > 0.0)) {
        return Err(failed(name, &format!("full_rpm = {full:?} must be finite and above 0")));
    }
    for thruster in &file.thrusters {
        thruster.validate().map_err(|e| failed(name, &e.to_string()))?;
    }
    let text = if extends { plain(&file) } else { tables_of(&text) };
    Ok(KnownVehicle { id: name.to_string(), file, text, folder })
}

/// Returns the text of a vehicle file and its folder.
fn source(name: &str, beside: Option<&Path>) -> Result<(String, Option<PathBuf>), Error> {
    if let Some((_, text)) = KNOWN.iter().find(|(id, _)| id.eq_ignore_ascii_case(name)) {
        return Ok(((*text).to_string(), None));
    }
    let path = beside.map_or_else(|| PathBuf::from(name), |folder| folder.join(name));
    if !path.is_file() {
        let ids: Vec<&str> = KNOWN.iter().map(|(id, _)| *id).collect();
        let near = nearest(name, ids.iter().copied()).map(|n| format!(", did you mean `{n}`?")).unwrap_or_default();
        let text =
            format!("there is neither a vehicle nor a file of this name{near}; the vehicles are {}", ids.join(", "));
        return Err(failed(name, &text));
    }
    let text = crate::text_file::read(&path).map_err(|e| failed(name, &e.to_string()))?;
    Ok((text, path.parent().map(Path::to_path_buf)))
}

fn failed(name: &str, message: &str) -> Error {
    Error::Vehicle { name: name.to_string(), message: message.to_string() }
}

/// Returns the table of a vehicle file, merged over that which it extends.
fn merged(name: &str, text: &str, folder: Option<&Path>, deepest: usize) -> Result<toml::Table, Error> {
    let own: toml::Table = toml::from_str(text).map_err(|e| failed(name, &e.to_string()))?;
    let Some(base) = own.get("extends").and_then(toml::Value::as_str).map(str::to_string) else { return Ok(own) };
    if deepest == 0 {
        return Err(failed(name, "vehicle files extend each other in a circle"));
    }
    let (text, beside) = source(&base, folder)?;
    let mut table = merged(&base, &text, beside.as_deref(), deepest - 1)?;
    overlay(&mut table, own);
    Ok(table)
}

fn overlay(base: &mut toml::Table, own: toml::Table) {
    for (key, value) in own {
        match (base.get_mut(&key), value) {
            (Some(toml::Value::Table(base)), toml::Value::Table(own)) => overlay(base, own),
            (Some(toml::Value::Array(base)), toml::Value::Array(own)) if key == "thruster" => {
                for one in own {
                    let name = one.get("name").cloned();
                    let same = base.iter_mut().find(|b| b.get("name") == name.as_ref());
                    match (same, one) {
                        (Some(toml::Value::Table(base)), toml::Value::Table(own)) => overlay(base, own),
                        (_, one) => base.push(one),
                    }
                }
            }
            (Some(toml::Value::Array(base)), toml::Value::Array(own)) if key == "sources" => base.extend(own),
            (_, value) => {
                base.insert(key, value);
            }
        }
    }
}

/// Returns the tables for a campaign, with their comments; `sources` become comments, `[model]` and
/// `[published]` are left out.
fn tables_of(text: &str) -> String {
    let (mut out, mut section, mut pending) = (String::new(), String::new(), String::new());
    for line in text.lines() {
        let trimmed = line.trim_start();
        if trimmed.starts_with('[') {
            section = trimmed.trim_start_matches('[').split([']', '.']).next().unwrap_or("").trim().to_string();
        }
        let comment = trimmed.starts_with('#') || trimmed.is_empty();
        // a comment belongs to the table that it stands before
        if comment {
            pending += line;
            pending.push('\n');
            continue;
        }
        if section.is_empty() {
            // before the first table, only the sources matter to a reader
            let quoted = trimmed.trim_end_matches(',').trim_matches('"');
            if trimmed.starts_with('"') {
                pending += &format!("# source: {quoted}\n");
            }
        } else if !["published", "model"].contains(&section.as_str()) {
            out += &pending;
            out += line;
            out.push('\n');
            pending.clear();
        } else {
            pending.clear();
        }
    }
    out
}

/// Returns the same without comments, for a file that extends another.
fn plain(file: &VehicleFile) -> String {
    let own = VehicleFile {
        extends: None,
        sources: Vec::new(),
        ardusub_frame: None,
        full_rpm: None,
        model: None,
        published: None,
        ..file.clone()
    };
    let sources: String = file.sources.iter().map(|source| format!("# source: {source}\n")).collect();
    let mut table = toml::Table::try_from(&own).unwrap_or_default();
    table.remove("sources");
    if file.efficiency == Efficiency::default() {
        table.remove("efficiency");
    }
    format!("{sources}{table}")
}

/// Returns the text of a vehicle with these lines at the head of each thruster's table, by its
/// index.
pub(super) fn with_thruster_lines(text: &str, lines: impl Fn(usize) -> String) -> String {
    let (mut out, mut index) = (String::new(), 0);
    for line in text.lines() {
        out = out + line + "\n";
        if line.trim_start().starts_with("[[thruster]]") {
            out += &lines(index);
            index += 1;
        }
    }
    out
}

/// Returns the text with the value of a key of thruster `index` (from 0) replaced by `change` of
/// it.
pub(super) fn with_thruster_value(
    text: &str,
    index: usize,
    key: &str,
    change: impl Fn(f64) -> f64,
    why: &str,
) -> String {
    let (mut out, mut at) = (String::new(), None::<usize>);
    for line in text.lines() {
        if line.trim_start().starts_with('[') {
            let thruster = line.trim_start().starts_with("[[thruster]]");
            at = match (thruster, at) {
                (true, at) => Some(at.map_or(0, |k| k + 1)),
                (false, at) => at,
            };
        }
        let value = line.split_once('=').filter(|(name, _)| at == Some(index) && name.trim() == key);
        match value.and_then(|(_, value)| value.split('#').next().unwrap_or("").trim().parse::<f64>().ok()) {
            Some(value) => out += &format!("# guessed: {why}\n{key} = {:?}\n", change(value)),
            None => {
                out += line;
                out.push('\n');
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_vehicle_is_whole_and_says_where_its_numbers_come_from() {
        let all = known_vehicles();
        assert_eq!(all.len(), KNOWN.len());
        for known in &all {
            assert!(!known.file.sources.is_empty() && known.file.vehicle.mass.is_some(), "{}", known.id);
            known.file.vehicle.validate().unwrap();
            // the text for a campaign reads back as what the file says
            let table: toml::Table = toml::from_str(&known.text).unwrap();
            let again: VehicleFile = table.try_into().unwrap();
            assert_eq!(
                (&again.vehicle, &again.thrusters),
                (&known.file.vehicle, &known.file.thrusters),
                "{}",
                known.id
            );
            assert!(known.text.contains("# source: "), "{}", known.text);
        }
    }

    #[test]
    fn the_thrusters_of_ardusub_push_where_its_mixer_says() {
        // AP_Motors6DOF.cpp: roll, pitch, yaw, throttle (up), forward, lateral of motors 1 to 8
        let heavy: [[f64; 6]; 8] = [
            [0., 0., 1., 0., -1., 1.],
            [0., 0., -1., 0., -1., -1.],
            [0., 0., -1., 0., 1., 1.],
            [0., 0., 1., 0., 1., -1.],
            [1., -1., 0., -1., 0., 0.],
            [-1., -1., 0., -1., 0., 0.],
            [1., 1., 0., -1., 0., 0.],
            [-1., 1., 0., -1., 0., 0.],
        ];
        let vehicle = vehicle("bluerov2-heavy").unwrap();
        for (k, factors) in heavy.iter().enumerate() {
            let w = vehicle.file.thrusters[k].unit_wrench();
            let [roll, pitch, yaw, up, forward, lateral] = *factors;
            // the horizontal ones are off the plane of the origin and cause some roll and pitch,
            // which the mixer leaves out
            let pairs = [(w[0], forward), (w[1], lateral), (w[2], -up), (w[5], yaw)];
            for (own, factor) in
                pairs.into_iter().chain((k >= 4).then_some([(w[3], roll), (w[4], pitch)]).into_iter().flatten())
            {
                assert!((own.abs() < 1e-9) == (factor.abs() < 1e-9) && own * factor >= 0.0, "motor {}: {w}", k + 1);
            }
        }
    }

    #[test]
    fn a_file_of_ones_own_extends_a_vehicle() {
        let folder = std::env::temp_dir().join(format!("hydrosysid-vehicle-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join("ours.toml");
        let text = "extends = \"bluerov2\"\nsources = [\"own scales\"]\n[vehicle]\nmass = 12.3\n[[thruster]]\nname = \"2\"\nspan = -400.0\n";
        std::fs::write(&path, text).unwrap();
        let own = vehicle(path.to_str().unwrap()).unwrap();
        assert_eq!((own.file.vehicle.mass, own.file.vehicle.name.as_str()), (Some(12.3), "BlueROV2"));
        assert_eq!((own.file.thrusters.len(), own.file.thrusters[1].span), (6, Some(-400.0)));
        assert!(own.file.sources.last().is_some_and(|s| s == "own scales"));
        std::fs::write(&path, "extends = \"ours.toml\"\n").unwrap();
        assert!(vehicle(path.to_str().unwrap()).unwrap_err().to_string().contains("circle"));
        std::fs::remove_dir_all(&folder).unwrap();
        assert!(vehicle("bluerov").unwrap_err().to_string().contains("did you mean `bluerov2`"));
    }

    #[test]
    fn a_direction_of_the_log_turns_a_span() {
        let text = vehicle("bluerov2").unwrap().text;
        let turned = with_thruster_value(&text, 1, "span", |span| -span, "MOT_2_DIRECTION = -1");
        let file: VehicleFile = toml::from_str::<toml::Table>(&turned).unwrap().try_into().unwrap();
        let spans: Vec<f64> = file.thrusters.iter().filter_map(|t| t.span).collect();
        assert_eq!(spans, [400.0, -400.0, 400.0, 400.0, 400.0, 400.0]);
    }
}
