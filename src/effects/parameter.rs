//! Parameters of effects: name, unit, how they enter, and where a search for them starts.

use crate::frame::Dof;
use crate::units::Dimension;

/// How a parameter enters the equations.
#[derive(Debug, Clone, PartialEq)]
pub enum ParameterKind {
    /// Linearly: least squares finds it in one step.
    Linear,
    /// As the shape of a function (a time constant, a delay, a direction): searched over `grid`, then refined
    /// within `min` and `max`.
    Shape {
        /// Values to try, in the parameter's unit.
        grid: Vec<f64>,
        /// Smallest admissible value.
        min: f64,
        /// Largest admissible value.
        max: f64,
    },
}

/// What the grid of a shape parameter is counted in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GridUnit {
    /// The parameter's own unit.
    Own,
    /// The greatest command of the campaign.
    GreatestCommand,
    /// The length of the vehicle; metres where it is not known.
    Length,
}

/// What is known of a parameter before any data.
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterSpec {
    /// Symbol, as in `k_u|u|`.
    pub name: String,
    /// Unit, as exponents.
    pub dimension: Dimension,
    /// Linear or shape.
    pub kind: ParameterKind,
    /// Value at which the effect is absent, in the parameter's unit.
    pub neutral: f64,
    /// SNAME's name of the same quantity (`X_u|u|`), whose value has the opposite sign.
    pub sname: Option<String>,
    /// Parameters of several terms with the same key are one (the net weight of surge, sway and heave).
    pub shared: Option<&'static str>,
    /// What the grid of a shape parameter is counted in.
    pub grid_in: GridUnit,
    /// Whether each run has its own value (the phase of a wave).
    pub per_run: bool,
    /// Smallest value that physics allows to a linear parameter.
    pub least: f64,
}

impl ParameterSpec {
    /// A linear parameter that is absent at 0.
    pub fn linear(name: impl Into<String>, dimension: Dimension) -> ParameterSpec {
        ParameterSpec {
            name: name.into(),
            dimension,
            kind: ParameterKind::Linear,
            neutral: 0.0,
            sname: None,
            shared: None,
            grid_in: GridUnit::Own,
            per_run: false,
            least: f64::NEG_INFINITY,
        }
    }

    /// A shape parameter that is searched over `grid` and kept between `min` and `max`.
    pub fn shape(name: impl Into<String>, dimension: Dimension, grid: &[f64], min: f64, max: f64) -> ParameterSpec {
        let kind = ParameterKind::Shape { grid: grid.to_vec(), min, max };
        ParameterSpec { kind, ..ParameterSpec::linear(name, dimension) }
    }

    /// With SNAME's name.
    pub fn sname(self, sname: impl Into<String>) -> ParameterSpec {
        ParameterSpec { sname: Some(sname.into()), ..self }
    }

    /// Absent at this value instead of 0.
    pub fn neutral(self, neutral: f64) -> ParameterSpec {
        ParameterSpec { neutral, ..self }
    }

    /// One with the parameters of other terms that bear this key.
    pub fn shared(self, key: &'static str) -> ParameterSpec {
        ParameterSpec { shared: Some(key), ..self }
    }

    /// With a grid in units of the greatest command.
    pub fn relative(self) -> ParameterSpec {
        ParameterSpec { grid_in: GridUnit::GreatestCommand, ..self }
    }

    /// With a grid in units of the vehicle's length.
    pub fn by_length(self) -> ParameterSpec {
        ParameterSpec { grid_in: GridUnit::Length, ..self }
    }

    /// With a value of its own in every run.
    pub fn per_run(self) -> ParameterSpec {
        ParameterSpec { per_run: true, ..self }
    }

    /// Smallest virtual mass or moment of inertia: above 0, and below that of anything that is driven, kg and kg·m².
    pub const LEAST_INERTIA: f64 = 1e-6;

    /// With a smallest value: less would feed energy to the motion.
    pub fn at_least(self, least: f64) -> ParameterSpec {
        ParameterSpec { least, ..self }
    }

    /// Whether least squares can find it.
    pub fn is_linear(&self) -> bool {
        self.kind == ParameterKind::Linear
    }
}

/// Dimension of the force or moment of a degree of freedom.
pub(super) fn force(dof: Dof) -> Dimension {
    if dof.is_rotation() { Dimension::MOMENT } else { Dimension::FORCE }
}

/// Dimension of the velocity or rate of a degree of freedom.
pub(super) fn velocity(dof: Dof) -> Dimension {
    if dof.is_rotation() { Dimension::RATE } else { Dimension::VELOCITY }
}

/// A drag coefficient in `dof`: name `k_<term>`, SNAME `X_<term>`, unit that makes `coefficient · product` a force.
pub(super) fn drag(dof: Dof, term: &str, product: Dimension) -> ParameterSpec {
    let spec = ParameterSpec::linear(format!("k_{term}"), force(dof).over(product));
    spec.sname(format!("{}_{term}", dof.sname()))
}
