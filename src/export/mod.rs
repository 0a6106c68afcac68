//! Export of a model to the tools that use it: simulators, control design, tables.
//!
//! ```text
//! model ──► coefficients (read off its terms) ──► rigid body + added mass + damping ──► one file per target
//! ```
//!
//! Every file states in a comment: the program that wrote it, the versions of the target it is for,
//! its signs and axes, the parts of the model that it does not contain, and the speeds and
//! amplitudes of the fit. What a target cannot express is never dropped silently: it gives a
//! finding.

pub mod body;
mod buoyancy;
mod c_header;
pub mod codes;
pub mod coefficients;
mod fossen;
mod gazebo;
mod header;
mod kalman;
mod kalman_python;
mod linear;
mod losses;
mod mat;
mod mujoco;
mod number;
mod range;
mod stability;
mod tables;
mod target;
mod thrusters;
mod urdf;
mod uuv;
mod vehicle_simulator;
mod version;
mod xml;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Serialize;
use thiserror::Error;

pub use coefficients::{Coefficients, LeftOut, coefficients};
pub use kalman::{Kalman, kalman};
pub use linear::{Linear, linear};
pub use target::Target;

use crate::campaign::file::{CampaignErrors, CampaignFile, ReadOptions};
use crate::campaign::{ModelFile, ModelFileError};
use crate::finding::Finding;
use crate::model::Model;
use crate::text_file;

/// Inputs that a target may need besides the model.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ExportOptions {
    /// Name of the link; `base_link` if absent.
    pub link: Option<String>,
    /// Dry mass, kg; that of the vehicle if absent.
    pub mass: Option<f64>,
    /// Dry moments of inertia about the body origin (roll, pitch, yaw), kg·m².
    pub inertia: Option<[f64; 3]>,
    /// Operating point of the linear model: states and forces by their names in a log, SI. An
    /// absent state is 0; if no force is given, the forces are those that hold the point.
    pub at: BTreeMap<String, f64>,
    /// Whether forces in the target are effective forces on the hull and not nominal ones: losses
    /// of thrust (`[efficiency]`) are then left to the part of the simulator that computes the
    /// forces.
    pub acting: bool,
    /// Version of the consumer that reads the file, `7.2`; if absent, any that the target supports.
    pub version: Option<String>,
}

/// A file for a target. Serialises as `hydrosysid export --json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Export {
    /// Format of this result: 1.
    pub format: u32,
    /// The target.
    pub target: Target,
    /// Versions of the target for which the file is meant.
    pub version: &'static str,
    /// Terms and coefficients of the model that the file does not contain.
    pub lost: Vec<String>,
    /// Findings for the user.
    pub warnings: Vec<Finding>,
    /// The content of the file.
    #[serde(skip)]
    pub bytes: Vec<u8>,
}

/// Error of an export.
#[derive(Debug, Error)]
pub enum ExportError {
    /// The model file cannot be used.
    #[error(transparent)]
    Model(#[from] ModelFileError),
    /// The campaign file cannot be used.
    #[error(transparent)]
    Campaign(#[from] CampaignErrors),
    /// The rigid body has no mass.
    #[error("the dry mass is not known: give it in [vehicle] of the campaign before fitting, or with --mass KG")]
    NoMass,
    /// The rigid body has no inertia.
    #[error(
        "no moment of inertia is known, and the vehicle's length is missing to estimate one: give --inertia \
             IXX,IYY,IZZ"
    )]
    NoInertia,
    /// A value that no file can contain.
    #[error("{name} = {value}: must be a finite number{}", if *.positive { " above 0" } else { "" })]
    Value {
        /// Name of the quantity.
        name: String,
        /// Its value.
        value: f64,
        /// Whether it has to be positive.
        positive: bool,
    },
    /// A key of the operating point that is neither a state nor a force of the model.
    #[error("the operating point has no `{key}`: this model has {known}")]
    Point {
        /// The key given.
        key: String,
        /// The names that the model has.
        known: String,
    },
    /// No force holds the operating point.
    #[error("no force can hold this operating point: {reason}")]
    NoTrim {
        /// Cause.
        reason: String,
    },
    /// The target has no place for the losses of thrust that belong to the model.
    #[error(
        "the model includes losses of thrust ([efficiency]: {losses}), and {reason}: apply them where the forces are \
         computed, and export with --acting, which makes the forces of the target the effective ones"
    )]
    Losses {
        /// The losses.
        losses: String,
        /// Why the target cannot carry them.
        reason: String,
    },
    /// A version of the consumer that the target does not support, or no version at all.
    #[error("{version:?}: {reason}")]
    Version {
        /// The version given.
        version: String,
        /// Why it is refused, and what to do.
        reason: String,
    },
    /// The model file contains no noise.
    #[error(
        "{}: this model has no noise, which the filter needs: fit the campaign with estimator = \"filter_error\" and \
         --model FILE, and export that",
        .0.display()
    )]
    NoNoise(PathBuf),
    /// The campaign describes no thruster.
    #[error("{}: there is no [[thruster]] table to export", .0.display())]
    NoThruster(PathBuf),
    /// The target needs the other kind of file.
    #[error("{}: the target `{target}` takes a {wanted}", .file.display())]
    WrongFile {
        /// The file given.
        file: PathBuf,
        /// Name of the target.
        target: &'static str,
        /// The kind of file that it takes.
        wanted: &'static str,
    },
}

/// A model to be written, with its origin.
struct Source<'a> {
    path: &'a Path,
    file: &'a ModelFile,
    model: &'a Model,
    losses: losses::Losses,
}

/// Makes the file of a target from a model file or, for thrusters, from a campaign file.
///
/// # Errors
/// [`ExportError`].
pub fn export(path: &Path, target: Target, options: &ExportOptions) -> Result<Export, ExportError> {
    check(options)?;
    // read only once: the file may be a pipe
    let bytes = text_file::read_bytes(path)
        .map_err(|e| ModelFileError::CannotRead { file: path.to_path_buf(), kind: e.kind() })?;
    let text = String::from_utf8_lossy(&bytes);
    if target.takes_campaign() {
        let read = ReadOptions { look_for_files: false, allow_outside: true, ..ReadOptions::default() };
        let campaign = match CampaignFile::from_bytes(&bytes, path, &read) {
            Err(_) if ModelFile::from_text(&text, path).is_ok() => {
                return Err(wrong_file(path, target, "campaign, whose [[thruster]] tables it writes"));
            }
            read => read?,
        };
        return thrusters::export(path, &campaign, target, options);
    }
    let file = match ModelFile::from_text(&text, path) {
        Err(ModelFileError::Campaign { .. }) => {
            return Err(wrong_file(path, target, "model: fit the campaign with --model FILE, and export that"));
        }
        read => read?,
    };
    export_model(&file, path, target, options)
}

/// Makes the file of a target from a model in memory; the file names `path` as its source.
///
/// # Errors
/// [`ExportError`].
pub fn export_model(
    file: &ModelFile,
    path: &Path,
    target: Target,
    options: &ExportOptions,
) -> Result<Export, ExportError> {
    check(options)?;
    let told = version::check(target, options)?;
    let model = file.model(&[], path)?;
    if let Some(p) = model.parameters.iter().find(|p| !p.value.is_finite()) {
        let name = format!("{} of `{}`", p.spec.name, p.term);
        return Err(ExportError::Value { name, value: p.value, positive: false });
    }
    let losses = losses::of(&file.efficiency, target, options)?;
    let source = Source { path, file, model: &model, losses };
    let mut made = match target {
        Target::Gazebo | Target::GazeboAddedMass => gazebo::export(&source, target, options),
        Target::Uuv => uuv::export(&source, options),
        Target::Urdf => urdf::export(&source, options),
        Target::FossenPython | Target::FossenMatlab => fossen::export(&source, target, options),
        Target::CHeader => c_header::export(&source, options),
        Target::VehicleSimulator => vehicle_simulator::export(&source, options),
        Target::Mujoco => mujoco::export(&source, options),
        Target::LinearJson | Target::LinearPython | Target::LinearMat => linear::export(&source, target, options),
        Target::Kalman | Target::KalmanToml | Target::KalmanPython | Target::KalmanMat => {
            kalman::export(&source, target, options)
        }
        Target::Latex | Target::Csv => tables::export(&source, target, options),
        Target::GazeboThrusters | Target::Ardusub => {
            Err(wrong_file(path, target, "campaign, whose [[thruster]] tables it writes"))
        }
    }?;
    made.warnings.splice(..0, file.unsettled(&path.display().to_string()));
    made.warnings.extend(told);
    made.warnings.extend(range::findings(file, &model, target, options));
    Ok(made)
}

fn check(options: &ExportOptions) -> Result<(), ExportError> {
    let masses = options.mass.iter().map(|m| ("mass", *m));
    let inertia = options.inertia.iter().flatten().map(|i| ("inertia", *i));
    if let Some((name, value)) = masses.chain(inertia).find(|(_, x)| !(x.is_finite() && *x > 0.0)) {
        return Err(ExportError::Value { name: name.into(), value, positive: true });
    }
    match options.at.iter().find(|(_, x)| !x.is_finite()) {
        Some((name, value)) => Err(ExportError::Value { name: name.clone(), value: *value, positive: false }),
        None => Ok(()),
    }
}

fn wrong_file(path: &Path, target: Target, wanted: &'static str) -> ExportError {
    ExportError::WrongFile { file: path.to_path_buf(), target: target.name(), wanted }
}
