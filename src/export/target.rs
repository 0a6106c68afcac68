//! The export targets: names, versions, kinds of file.

use serde::{Deserialize, Serialize};

/// A target of an export.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Target {
    /// gz-sim's Hydrodynamics system, added mass as a force.
    Gazebo,
    /// gz-sim's Hydrodynamics system, added mass in the inertia of the link.
    GazeboAddedMass,
    /// gz-sim's Thruster system, from a campaign.
    GazeboThrusters,
    /// uuv_simulator and DAVE, `fossen`.
    Uuv,
    /// URDF with the `<hydrodynamics>` of the Robotic Decision Making Laboratory's library.
    Urdf,
    /// MuJoCo: an MJCF and a callback for the bias forces of its motors.
    Mujoco,
    /// A vehicle class of PythonVehicleSimulator, and of HoloOcean.
    #[serde(rename = "python-vehicle-simulator")]
    VehicleSimulator,
    /// Matrices of Fossen's equations, Python.
    FossenPython,
    /// Matrices of Fossen's equations, MATLAB.
    FossenMatlab,
    /// Fossen's equations as a C header.
    CHeader,
    /// Linear model as JSON.
    LinearJson,
    /// Linear model for python-control.
    LinearPython,
    /// Linear model as a MAT file.
    LinearMat,
    /// Linear model with its noise, for a Kalman filter, as JSON.
    Kalman,
    /// Linear model with its noise as TOML.
    KalmanToml,
    /// Linear model with its noise for python-control.
    KalmanPython,
    /// Linear model with its noise as a MAT file.
    KalmanMat,
    /// Thrust tables and parameters for ArduSub, from a campaign.
    Ardusub,
    /// Table of the parameters for LaTeX.
    Latex,
    /// Table of the parameters as CSV.
    Csv,
}

impl Target {
    /// All targets, in the order of the list for users.
    pub const ALL: [Target; 20] = [
        Target::Gazebo,
        Target::GazeboAddedMass,
        Target::GazeboThrusters,
        Target::Uuv,
        Target::Urdf,
        Target::Mujoco,
        Target::VehicleSimulator,
        Target::FossenPython,
        Target::FossenMatlab,
        Target::CHeader,
        Target::LinearJson,
        Target::LinearPython,
        Target::LinearMat,
        Target::Kalman,
        Target::KalmanToml,
        Target::KalmanPython,
        Target::KalmanMat,
        Target::Ardusub,
        Target::Latex,
        Target::Csv,
    ];

    /// Name on the command line: `gazebo-added-mass`.
    pub const fn name(self) -> &'static str {
        match self {
            Target::Gazebo => "gazebo",
            Target::GazeboAddedMass => "gazebo-added-mass",
            Target::GazeboThrusters => "gazebo-thrusters",
            Target::Uuv => "uuv",
            Target::Urdf => "urdf",
            Target::Mujoco => "mujoco",
            Target::VehicleSimulator => "python-vehicle-simulator",
            Target::CHeader => "c-header",
            Target::FossenPython => "fossen-python",
            Target::FossenMatlab => "fossen-matlab",
            Target::LinearJson => "linear-json",
            Target::LinearPython => "linear-python",
            Target::LinearMat => "linear-mat",
            Target::Kalman => "kalman",
            Target::KalmanToml => "kalman-toml",
            Target::KalmanPython => "kalman-python",
            Target::KalmanMat => "kalman-mat",
            Target::Ardusub => "ardusub",
            Target::Latex => "latex",
            Target::Csv => "csv",
        }
    }

    /// The target of this name.
    pub fn from_name(name: &str) -> Option<Target> {
        Target::ALL.into_iter().find(|target| target.name() == name)
    }

    /// The form of the target for a file with this extension: `kalman` as `.toml`, `.py` or `.mat`.
    pub fn for_ending(self, ending: Option<&str>) -> Target {
        match (self, ending) {
            (Target::Kalman, Some("toml")) => Target::KalmanToml,
            (Target::Kalman, Some("py")) => Target::KalmanPython,
            (Target::Kalman, Some("mat")) => Target::KalmanMat,
            _ => self,
        }
    }

    /// Versions of the target for which the file is written.
    pub const fn version(self) -> &'static str {
        match self {
            Target::Gazebo => {
                "gz-sim 7.2 to 8 (Garden, Harmonic), Hydrodynamics system; 9 reads it but calls it deprecated"
            }
            Target::GazeboAddedMass => {
                "SDF 1.10 and later, gz-sim 8 and later with the DART engine, Hydrodynamics system"
            }
            Target::GazeboThrusters => "gz-sim 7 and later, Thruster system",
            Target::Uuv => "uuv_simulator 0.6, DAVE for Gazebo classic: underwater object plugin, model `fossen`",
            Target::Urdf => "URDF with the <hydrodynamics> of the library `hydrodynamics` (auv_controllers, blue)",
            Target::Mujoco => "MuJoCo 3 and 4, Python bindings: MJCF and passive-force callback",
            Target::VehicleSimulator => "PythonVehicleSimulator (2021 to 2025), HoloOcean 2 (fossen_dynamics)",
            Target::CHeader => "C99 and C++",
            Target::FossenPython => "Python 3 with NumPy",
            Target::FossenMatlab => "MATLAB R2016b and later, GNU Octave",
            Target::LinearJson | Target::Kalman => "JSON, format 1",
            Target::LinearPython | Target::KalmanPython => "Python 3, python-control 0.9 and later",
            Target::LinearMat | Target::KalmanMat => "MAT file, level 5",
            Target::KalmanToml => "TOML 1.0",
            Target::Ardusub => "ArduSub 4",
            Target::Latex => "LaTeX with booktabs",
            Target::Csv => "CSV",
        }
    }

    /// Whether the target computes forces itself: it is code or a matrix, not coefficients alone.
    pub const fn computes(self) -> bool {
        let code = matches!(
            self,
            Target::FossenPython | Target::FossenMatlab | Target::CHeader | Target::VehicleSimulator | Target::Mujoco
        );
        code || self.is_linear()
    }

    /// Why a simulator that people ask for is no target, and what to do instead; `None` for any
    /// other name.
    pub fn why_absent(name: &str) -> Option<&'static str> {
        name.eq_ignore_ascii_case("stonefish").then_some(
            "Stonefish is not a target: its scenario computes drag from the faces of a mesh and added mass from an \
             ellipsoid, and cannot represent derivatives of moments or couplings, so no scenario file moves as the \
             model does. Give the body physics=\"surface\" and apply the force of `c-header` to it: docs/exports.md, \
             Stonefish",
        )
    }

    /// Whether it is a linear model at an operating point.
    pub const fn is_linear(self) -> bool {
        matches!(
            self,
            Target::LinearJson
                | Target::LinearPython
                | Target::LinearMat
                | Target::Kalman
                | Target::KalmanToml
                | Target::KalmanPython
                | Target::KalmanMat
        )
    }

    /// The first supported version of the consumer, major and minor, if files differ between
    /// versions.
    pub const fn first_version(self) -> Option<[u32; 2]> {
        match self {
            Target::Gazebo => Some([7, 2]),
            Target::GazeboAddedMass => Some([8, 0]),
            Target::GazeboThrusters => Some([7, 0]),
            _ => None,
        }
    }

    /// Whether it is made from a campaign, not from a model.
    pub const fn takes_campaign(self) -> bool {
        matches!(self, Target::GazeboThrusters | Target::Ardusub)
    }

    /// Whether the file is bytes, not text.
    pub const fn is_binary(self) -> bool {
        matches!(self, Target::LinearMat | Target::KalmanMat)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_the_json_and_lead_back() {
        for target in Target::ALL {
            assert_eq!(Target::from_name(target.name()), Some(target));
            assert_eq!(serde_json::to_value(target).unwrap(), target.name());
            assert_eq!(Target::why_absent(target.name()), None);
        }
    }
}
