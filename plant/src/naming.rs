//! Names of effects: `id`, `id@dof`, `id@dof:other`, `id@T6`, `id@T2:T5`.

use crate::campaign::PlantError;
use crate::dof::Dof;
use crate::vehicle::Vehicle;

/// A parsed name.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Name<'a> {
    /// The name as written.
    pub full: &'a str,
    /// The id.
    pub id: &'a str,
    /// Indices of degrees of freedom, or of thrusters.
    pub place: Place,
}

/// Where an effect acts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Place {
    /// The whole vehicle.
    Whole,
    /// One degree of freedom.
    One(usize),
    /// One degree of freedom under the influence of another.
    Pair(usize, usize),
    /// A thruster.
    Thruster(usize),
    /// Two thrusters.
    Thrusters(usize, usize),
}

impl<'a> Name<'a> {
    pub fn parse(full: &'a str, vehicle: &Vehicle) -> Result<Name<'a>, PlantError> {
        let (id, place) = full.split_once('@').map_or((full, None), |(id, place)| (id, Some(place)));
        let unknown = || PlantError::CannotHide { name: full.to_string(), reason: "no such place" };
        let dof = |name: &str| Dof::from_name(name).map(Dof::index);
        let thruster = |name: &str| vehicle.thrusters.iter().position(|t| t.name == name);
        let place = match place {
            None => Place::Whole,
            Some(place) => match place.split_once(':') {
                None => {
                    dof(place).map(Place::One).or_else(|| thruster(place).map(Place::Thruster)).ok_or_else(unknown)?
                }
                Some((a, b)) => match (dof(a), dof(b), thruster(a), thruster(b)) {
                    (Some(i), Some(j), ..) => Place::Pair(i, j),
                    (_, _, Some(i), Some(j)) => Place::Thrusters(i, j),
                    _ => return Err(unknown()),
                },
            },
        };
        Ok(Name { full, id, place })
    }

    /// Index of the degree of freedom if the effect is a row of −C(ν)ν.
    pub fn coriolis_row(&self) -> Option<usize> {
        let row = self.id.strip_prefix("coriolis_").and_then(Dof::from_name)?;
        (self.place == Place::Whole).then_some(row.index())
    }
}
