//! The name of an effect as a user writes it: `id`, `id@dof` or `id@dof:other`; of single thrusters
//! `id@T6`, `id@T2:T5`.

use std::fmt;
use std::str::FromStr;

use serde::de::{Deserialize, Deserializer, Error, Visitor};
use serde::{Serialize, Serializer};

use super::{Place, ThrusterLoss, ThrusterSwap};
use crate::frame::Dof;
use crate::nearest::nearest;

/// The name of an effect, split into its parts. A plain `id` means every place where the effect applies.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct EffectName {
    /// Id, as in the catalogue or of a user's own effect: letters, digits and `_`.
    pub id: String,
    /// Degree of freedom in whose balance it stands.
    pub dof: Option<Dof>,
    /// The other degree of freedom of a coupling; present only with `dof`.
    pub other: Option<Dof>,
    /// Thrusters of an effect of single thrusters, as the campaign calls them.
    pub thrusters: Vec<String>,
}

/// Effects of single thrusters, each with its number of thrusters.
const OF_THRUSTERS: [(&str, usize); 2] = [(ThrusterLoss::ID, 1), (ThrusterSwap::ID, 2)];

/// A text that names no effect.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum EffectNameError {
    /// The id is empty or holds other characters than letters, digits and `_`.
    #[error("{text:?}: an effect is written `id`, `id@dof` or `id@dof:other`, its id in letters, digits and `_`")]
    Form {
        /// The whole text.
        text: String,
    },
    /// No degree of freedom has this name.
    #[error(
        "{text:?}: `{dof}` is not a degree of freedom{}; these are surge, sway, heave, roll, pitch and yaw",
        suggestion(*.nearest)
    )]
    UnknownDof {
        /// The whole text.
        text: String,
        /// The part that should be a degree of freedom.
        dof: String,
        /// The degree of freedom with the nearest name.
        nearest: Option<Dof>,
    },
    /// A coupling of a degree of freedom with itself.
    #[error("{text:?}: a coupling needs two different degrees of freedom")]
    SameDof {
        /// The whole text.
        text: String,
    },
    /// Wrong number of thrusters.
    #[error("{text:?}: it is written with {}, as [[thruster]] tables name them", if *count == 1 { "one thruster, `@T6`" } else { "two thrusters, `@T2:T5`" })]
    Thrusters {
        /// The whole text.
        text: String,
        /// The right number.
        count: usize,
    },
}

fn suggestion(dof: Option<Dof>) -> String {
    dof.map(|dof| format!(", did you mean `{dof}`?")).unwrap_or_default()
}

impl EffectName {
    /// The place: the whole vehicle for a plain id.
    pub fn place(&self) -> Place {
        Place { dof: self.dof, other: self.other }
    }

    /// The degrees of freedom that it names: none, one or two.
    pub fn dofs(&self) -> impl Iterator<Item = Dof> {
        self.dof.into_iter().chain(self.other)
    }

    /// Whether two names mean the same effect in at least one place.
    pub fn overlaps(&self, other: &EffectName) -> bool {
        let sorted = |name: &EffectName| {
            let mut names = name.thrusters.clone();
            names.sort_unstable();
            names
        };
        let placed = self.dof.is_none() || other.dof.is_none() || self.place() == other.place();
        self.id == other.id && placed && sorted(self) == sorted(other)
    }
}

impl FromStr for EffectName {
    type Err = EffectNameError;

    fn from_str(text: &str) -> Result<EffectName, EffectNameError> {
        let dof_of = |name: &str| {
            Dof::from_name(name).ok_or_else(|| EffectNameError::UnknownDof {
                text: text.to_string(),
                dof: name.to_string(),
                nearest: nearest(name, Dof::ALL.map(Dof::name)).and_then(Dof::from_name),
            })
        };
        let (id, place) = text.split_once('@').map_or((text, None), |(id, place)| (id, Some(place)));
        if id.is_empty() || !id.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') {
            return Err(EffectNameError::Form { text: text.to_string() });
        }
        if let Some((_, count)) = OF_THRUSTERS.into_iter().find(|(known, _)| *known == id) {
            let thrusters: Vec<String> = place.into_iter().flat_map(|p| p.split(':')).map(str::to_string).collect();
            let twice = thrusters.len() == 2 && thrusters[0] == thrusters[1];
            if thrusters.len() != count || thrusters.iter().any(String::is_empty) || twice {
                return Err(EffectNameError::Thrusters { text: text.to_string(), count });
            }
            return Ok(EffectName { id: id.to_string(), dof: None, other: None, thrusters });
        }
        let (dof, other) = match place.map(|p| p.split_once(':').map_or((p, None), |(dof, other)| (dof, Some(other)))) {
            None => (None, None),
            Some((dof, None)) => (Some(dof_of(dof)?), None),
            Some((dof, Some(other))) => (Some(dof_of(dof)?), Some(dof_of(other)?)),
        };
        if other.is_some() && dof == other {
            return Err(EffectNameError::SameDof { text: text.to_string() });
        }
        Ok(EffectName { id: id.to_string(), dof, other, thrusters: Vec::new() })
    }
}

impl fmt::Display for EffectName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.id)?;
        let thrusters = self.thrusters.join(":");
        if !thrusters.is_empty() {
            write!(f, "@{thrusters}")?;
        }
        self.dof.map_or(Ok(()), |dof| write!(f, "@{dof}"))?;
        self.other.map_or(Ok(()), |other| write!(f, ":{other}"))
    }
}

impl Serialize for EffectName {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for EffectName {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<EffectName, D::Error> {
        // A visitor instead of `String` and parse: so the reader of the file knows the position of
        // the text.
        struct Name;
        impl Visitor<'_> for Name {
            type Value = EffectName;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("the name of an effect, `id`, `id@dof`, `id@dof:other` or `id@thruster`")
            }

            fn visit_str<E: Error>(self, text: &str) -> Result<EffectName, E> {
                text.parse().map_err(E::custom)
            }
        }
        deserializer.deserialize_str(Name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_three_forms_read_and_print() {
        for text in ["inertia", "quadratic_drag@surge", "added_mass_coupling@surge:pitch"] {
            let name: EffectName = text.parse().unwrap();
            assert_eq!(name.to_string(), text);
            assert_eq!(crate::model::name_of(&name.id, name.place()), text);
            let json = serde_json::to_string(&name).unwrap();
            assert_eq!(serde_json::from_str::<EffectName>(&json).unwrap(), name);
        }
        let name: EffectName = "cross_drag@sway:yaw".parse().unwrap();
        assert_eq!(name.dofs().collect::<Vec<_>>(), [Dof::Sway, Dof::Yaw]);
    }

    #[test]
    fn thrusters_are_named_as_the_campaign_calls_them() {
        for text in ["thruster_loss@T6", "thruster_loss@port bow", "thruster_swap@T2:T5"] {
            let name: EffectName = text.parse().unwrap();
            assert_eq!((name.to_string(), name.place()), (text.into(), Place::VEHICLE));
        }
        let name = |text: &str| text.parse::<EffectName>().unwrap();
        assert!(name("thruster_swap@T2:T5").overlaps(&name("thruster_swap@T5:T2")));
        assert!(!name("thruster_loss@T2").overlaps(&name("thruster_loss@T5")));
        for text in
            ["thruster_loss", "thruster_loss@T1:T2", "thruster_swap@T1", "thruster_swap@T1:T1", "thruster_loss@"]
        {
            let error = text.parse::<EffectName>().unwrap_err();
            assert!(matches!(error, EffectNameError::Thrusters { .. }), "{text}: {error}");
        }
    }

    #[test]
    fn what_names_no_effect_says_why() {
        let refused = |text: &str| text.parse::<EffectName>().unwrap_err();
        let unknown = refused("linear_drag@sruge");
        assert!(matches!(unknown, EffectNameError::UnknownDof { nearest: Some(Dof::Surge), .. }));
        assert!(unknown.to_string().contains("did you mean `surge`?"), "{unknown}");
        assert!(matches!(refused("linear_drag@"), EffectNameError::UnknownDof { nearest: None, .. }));
        assert!(matches!(refused("cross_drag@sway:sway"), EffectNameError::SameDof { .. }));
        assert!(matches!(refused("cross_drag@sway:yaw:roll"), EffectNameError::UnknownDof { .. }));
        for text in ["", "@surge", "linear drag", "X_u|u|"] {
            assert!(matches!(refused(text), EffectNameError::Form { .. }), "{text}");
        }
    }

    proptest! {
        #[test]
        fn law_any_text_is_refused_or_comes_back(text in "\\PC{0,24}|[a-z]{1,6}@(surge|yaw|heav)(:(roll|sway))?|thruster_(loss|swap)@T[1-9](:T[1-9])?") {
            if let Ok(name) = text.parse::<EffectName>() {
                prop_assert_eq!(name.to_string(), text);
            }
        }
    }
}
