//! The trait [`Effect`] of the catalogue, with the description and the places of an effect.

use std::fmt::Debug;

use serde::{Deserialize, Serialize};

use super::{Instant, Logged, ParameterSpec, Six};
use crate::frame::Dof;
use crate::symbolic::{Expr, Lateness};

/// Where on the chain an effect acts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Family {
    /// A force in the balance of momentum.
    Body,
    /// A change of the force between the command and the water.
    Actuator,
    /// A force or a flow from outside: current, wind, waves, a tether.
    Environment,
    /// A change of the logged values.
    Sensor,
}

impl Family {
    /// Lower-case name, as printed.
    pub const fn name(self) -> &'static str {
        ["body", "actuator", "environment", "sensor"][self as usize]
    }
}

/// The degrees of freedom in which an effect may stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scope {
    /// `id@dof`, once for each of these.
    Each(&'static [Dof]),
    /// `id@dof:other` for every ordered pair of different degrees of freedom.
    Pairs,
    /// `id@dof:other` for each of these ordered pairs of degrees of freedom.
    Couples(&'static [(Dof, Dof)]),
    /// `id`, once for the whole vehicle; it needs all of these degrees of freedom.
    Vehicle(&'static [Dof]),
    /// `id`, once for the whole vehicle; it needs all degrees of freedom of one of these sets.
    VehicleAny(&'static [&'static [Dof]]),
    /// `id`, once for the whole vehicle; it acts in those of the modelled degrees of freedom to
    /// which it applies.
    Everywhere,
    /// `id@T6` or `id@T2:T5`, of thrusters that a campaign describes. Its channels are their
    /// forces, which are part of the command, and it acts on the command before all other effects
    /// except a delay of the command.
    Thrusters,
}

impl Scope {
    /// The whole vehicle if the model has a velocity and a turn rate of one plane, so that each can
    /// be checked against the other.
    pub const MOVES_AND_TURNS: Scope =
        Scope::VehicleAny(&[&[Dof::Surge, Dof::Yaw], &[Dof::Sway, Dof::Yaw], &[Dof::Heave, Dof::Pitch]]);
}

/// The place of an effect: its degree of freedom and, for a coupling, the other one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Default)]
pub struct Place {
    /// Degree of freedom in whose balance the effect stands; `None` for the whole vehicle.
    pub dof: Option<Dof>,
    /// The other degree of freedom of a coupling.
    pub other: Option<Dof>,
}

impl Place {
    /// The whole vehicle.
    pub const VEHICLE: Place = Place { dof: None, other: None };

    /// One degree of freedom.
    pub const fn at(dof: Dof) -> Place {
        Place { dof: Some(dof), other: None }
    }

    /// A coupling of two.
    pub const fn pair(dof: Dof, other: Dof) -> Place {
        Place { dof: Some(dof), other: Some(other) }
    }

    /// The degree of freedom of an effect whose scope is [`Scope::Each`], [`Scope::Pairs`] or
    /// [`Scope::Couples`].
    ///
    /// # Panics
    /// For the place of the whole vehicle: a term is always made with a place of its effect's
    /// scope.
    pub fn here(&self) -> Dof {
        self.dof.expect("an effect of one degree of freedom is placed in one")
    }

    /// The other degree of freedom of an effect whose scope is [`Scope::Pairs`] or [`Scope::Couples`].
    ///
    /// # Panics
    /// As [`Place::here`].
    pub fn there(&self) -> Dof {
        self.other.expect("a coupling is placed in two degrees of freedom")
    }
}

/// Description of an effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct About<'a> {
    /// Stable id, as in a campaign file.
    pub id: &'a str,
    /// Where on the chain it acts.
    pub family: Family,
    /// Degrees of freedom in which it may stand.
    pub scope: Scope,
    /// The formula, in plain Unicode; i is the own degree of freedom, j the other one.
    pub formula: &'a str,
    /// One sentence: what it is.
    pub meaning: &'a str,
    /// Where it comes from.
    pub source: &'a str,
    /// Which data can show it.
    pub shown_by: &'a str,
}

/// A delay of the whole command, by the index of the effect's parameter that holds it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CommandDelay {
    /// By so many seconds.
    Constant(usize),
    /// By so many seconds in each second of the run: the clock of the log runs at another rate than that of the commands.
    Growing(usize),
}

impl CommandDelay {
    /// Index of the parameter that holds the delay.
    pub fn parameter(self) -> usize {
        match self {
            CommandDelay::Constant(index) | CommandDelay::Growing(index) => index,
        }
    }

    /// The delay of the command with this one in `late`, in the stead of another one of its kind; `parameters`: indices in the
    /// model of the effect's parameters.
    pub fn added_to(self, mut late: Lateness, parameters: &[usize]) -> Lateness {
        match self {
            CommandDelay::Constant(index) => late.constant = Some(parameters[index] as u16),
            CommandDelay::Growing(index) => late.drift = Some(parameters[index] as u16),
        }
        late
    }
}

/// An effect on the chain command → actuator → body → sensor → log.
///
/// Every hook has an empty default; an effect writes those it needs, as formulas on the symbols of
/// the [`Instant`]. `theta` holds the symbols of its parameters in the order of
/// [`Effect::parameters`], `memory` those of its states.
///
/// A complete effect:
///
/// ```
/// use hydrosysid::effects::{About, Effect, Family, Instant, ParameterSpec, Place, Scope, Six};
/// use hydrosysid::frame::Dof;
/// use hydrosysid::symbolic::Expr;
/// use hydrosysid::units::Dimension;
///
/// /// A sail: force in proportion to the square of the wind speed.
/// #[derive(Debug)]
/// struct Sail;
///
/// impl Effect for Sail {
///     fn about(&self) -> About<'_> {
///         About {
///             id: "sail",
///             family: Family::Environment,
///             scope: Scope::Each(&[Dof::Surge]),
///             formula: "d W²",
///             meaning: "Wind on a sail.",
///             source: "-",
///             shown_by: "a logged wind",
///         }
///     }
///     fn parameters(&self, _: Place) -> Vec<ParameterSpec> {
///         vec![ParameterSpec::linear("d_W", Dimension::new(1, -1, 0))]
///     }
///     fn channels(&self, _: Place) -> Vec<String> {
///         vec!["wind_speed".into()]
///     }
///     fn wrench<'g>(
///         &self,
///         at: &Instant<'g>,
///         _: Place,
///         theta: &[Expr<'g>],
///         _: &[Expr<'g>],
///         wrench: &mut Six<'g>,
///     ) {
///         let wind = at.channel("wind_speed");
///         wrench[0] += theta[0] * wind * wind;
///     }
/// }
/// ```
pub trait Effect: Debug + Send + Sync {
    /// Id, family, scope, formula, meaning, source, and what data can show it.
    fn about(&self) -> About<'_>;

    /// The formula as it stands in a model of these degrees of freedom.
    fn formula_in(&self, _dofs: &[Dof]) -> String {
        self.about().formula.to_string()
    }

    /// Its parameters at this place.
    fn parameters(&self, place: Place) -> Vec<ParameterSpec>;

    /// Channels of the log that it reads besides states and commands.
    fn channels(&self, _place: Place) -> Vec<String> {
        Vec::new()
    }

    /// Logged angles and positions that it needs.
    fn pose(&self) -> &'static [&'static str] {
        &[]
    }

    /// Whether it acts from a place on the ground, as an anchor does. All other effects are the
    /// same seen from the ground and from water that moves over it (Galilean invariance), which
    /// `tests/all/laws.rs` checks for the whole catalogue.
    fn tied_to_ground(&self) -> bool {
        false
    }

    /// Adds to the momentum π, in kg·m/s and kg·m²/s: affine in ν_r.
    fn momentum<'g>(&self, _at: &Instant<'g>, _place: Place, _theta: &[Expr<'g>], _momentum: &mut Six<'g>) {}

    /// Adds to the wrench w, in N and N·m: linear in its linear parameters.
    fn wrench<'g>(
        &self,
        _at: &Instant<'g>,
        _place: Place,
        _theta: &[Expr<'g>],
        _memory: &[Expr<'g>],
        _wrench: &mut Six<'g>,
    ) {
    }

    /// The row of −C(ν)ν with the same leading product. If that row is not in a model, or has a
    /// coefficient of its own, no log tells the two apart, and the row stands for both.
    fn shares_row(&self, _place: Place) -> Option<Dof> {
        None
    }

    /// Id of the same effect with one value for all runs, for an effect with a value in each run. A
    /// model holds one of the two at a place.
    fn same_in_all_runs(&self) -> Option<&str> {
        None
    }

    /// How it delays the whole command, for an effect that does.
    fn delays_command(&self) -> Option<CommandDelay> {
        None
    }

    /// Changes the force τ between command and water, in N and N·m.
    fn actuate<'g>(
        &self,
        _at: &Instant<'g>,
        _place: Place,
        _theta: &[Expr<'g>],
        _memory: &[Expr<'g>],
        _tau: &mut Six<'g>,
    ) {
    }

    /// Velocity of the water in earth axes, m/s: north, east, down.
    fn water<'g>(&self, _at: &Instant<'g>, _place: Place, _theta: &[Expr<'g>]) -> Option<[Expr<'g>; 3]> {
        None
    }

    /// Changes the logged values.
    fn sense<'g>(
        &self,
        _at: &Instant<'g>,
        _place: Place,
        _theta: &[Expr<'g>],
        _memory: &[Expr<'g>],
        _logged: &mut Logged<'g>,
    ) {
    }

    /// The states of the effect, each by its value in quasi-steady motion; empty for an effect
    /// without memory. For an actuator `tau` is the force at its input.
    fn memory<'g>(&self, _at: &Instant<'g>, _place: Place, _tau: &Six<'g>) -> Vec<Expr<'g>> {
        Vec::new()
    }

    /// Time derivative of its states, in the order of [`Effect::memory`].
    fn memory_rate<'g>(
        &self,
        _at: &Instant<'g>,
        _place: Place,
        _theta: &[Expr<'g>],
        _memory: &[Expr<'g>],
        _tau: &Six<'g>,
    ) -> Vec<Expr<'g>> {
        Vec::new()
    }
}
