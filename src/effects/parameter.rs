//! Parameters of effects: name, unit, how they enter, and the start of a search for them.

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

/// Unit of the grid of a shape parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GridUnit {
    /// The parameter's own unit.
    Own,
    /// The greatest command of the campaign.
    GreatestCommand,
    /// The length of the vehicle; metres if it is not known.
    Length,
}

/// Specification of a parameter: what is known of it before any data.
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
    /// Key of a shared parameter: those of several terms with the same key are one (the net weight
    /// of surge, sway and heave).
    pub shared: Option<&'static str>,
    /// Unit of the grid of a shape parameter.
    pub grid_in: GridUnit,
    /// Whether each run has its own value (the phase of a wave).
    pub per_run: bool,
    /// Smallest value of a linear parameter that physics allows.
    pub least: f64,
}

impl ParameterSpec {
    /// A linear parameter whose neutral value is 0.
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

    /// Sets SNAME's name.
    pub fn sname(self, sname: impl Into<String>) -> ParameterSpec {
        ParameterSpec { sname: Some(sname.into()), ..self }
    }

    /// Sets the value at which the effect is absent; the default is 0.
    pub fn neutral(self, neutral: f64) -> ParameterSpec {
        ParameterSpec { neutral, ..self }
    }

    /// Shares the parameter with those of other terms that have this key.
    pub fn shared(self, key: &'static str) -> ParameterSpec {
        ParameterSpec { shared: Some(key), ..self }
    }

    /// Sets the unit of the grid to the greatest command.
    pub fn relative(self) -> ParameterSpec {
        ParameterSpec { grid_in: GridUnit::GreatestCommand, ..self }
    }

    /// Sets the unit of the grid to the vehicle's length.
    pub fn by_length(self) -> ParameterSpec {
        ParameterSpec { grid_in: GridUnit::Length, ..self }
    }

    /// Gives the parameter a value of its own in every run.
    pub fn per_run(self) -> ParameterSpec {
        ParameterSpec { per_run: true, ..self }
    }

    /// Lower limit of a virtual mass or moment of inertia, kg and kg·m²: above 0, and below that of
    /// any vehicle.
    pub const LEAST_INERTIA: f64 = 1e-6;

    /// Sets a lower limit, below which the parameter would feed energy to the motion.
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

/// A drag coefficient in `dof`: name `k_<term>`, SNAME `X_<term>`, unit that makes
/// `coefficient · product` a force.
pub(super) fn drag(dof: Dof, term: &str, product: Dimension) -> ParameterSpec {
    let spec = ParameterSpec::linear(format!("k_{term}"), force(dof).over(product));
    spec.sname(format!("{}_{term}", dof.sname()))
}
