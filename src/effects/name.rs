//! The name of an effect as a user writes it: `id`, `id@dof` or `id@dof:other`.

use std::fmt;
use std::str::FromStr;

use serde::de::{Deserialize, Deserializer, Error, Visitor};
use serde::{Serialize, Serializer};

use super::Place;
use crate::frame::Dof;
use crate::nearest::nearest;

/// The name of an effect, split into its parts. A plain `id` means every place where the effect applies.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct EffectName {
    /// Id, as in the catalogue or as a user named an effect of his own: letters, digits and `_`.
    pub id: String,
    /// Degree of freedom in whose balance it stands.
    pub dof: Option<Dof>,
    /// The other degree of freedom of a coupling; only ever there with `dof`.
    pub other: Option<Dof>,
}

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
    #[error("{text:?}: `{dof}` is no degree of freedom{}; they are surge, sway, heave, roll, pitch and yaw", suggestion(*.nearest))]
    UnknownDof {
        /// The whole text.
        text: String,
        /// The part that was to be a degree of freedom.
        dof: String,
        /// The nearest that is one.
        nearest: Option<Dof>,
    },
    /// A coupling of a degree of freedom with itself.
    #[error("{text:?}: a coupling is of two different degrees of freedom")]
    SameDof {
        /// The whole text.
        text: String,
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

    /// The degrees of freedom it names, none, one or two.
    pub fn dofs(&self) -> impl Iterator<Item = Dof> {
        self.dof.into_iter().chain(self.other)
    }

    /// Whether two names mean, at one place at least, the same effect.
    pub fn overlaps(&self, other: &EffectName) -> bool {
        self.id == other.id && (self.dof.is_none() || other.dof.is_none() || self.place() == other.place())
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
        let (dof, other) = match place.map(|p| p.split_once(':').map_or((p, None), |(dof, other)| (dof, Some(other)))) {
            None => (None, None),
            Some((dof, None)) => (Some(dof_of(dof)?), None),
            Some((dof, Some(other))) => (Some(dof_of(dof)?), Some(dof_of(other)?)),
        };
        if other.is_some() && dof == other {
            return Err(EffectNameError::SameDof { text: text.to_string() });
        }
        Ok(EffectName { id: id.to_string(), dof, other })
    }
}

impl fmt::Display for EffectName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.id)?;
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
        // A visitor, not `String` and then parse: so the reader of the file knows where the text stood.
        struct Name;
        impl Visitor<'_> for Name {
            type Value = EffectName;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("the name of an effect, `id`, `id@dof` or `id@dof:other`")
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
        fn law_any_text_is_refused_or_comes_back(text in "\\PC{0,24}|[a-z]{1,6}@(surge|yaw|heav)(:(roll|sway))?") {
            if let Ok(name) = text.parse::<EffectName>() {
                prop_assert_eq!(name.to_string(), text);
            }
        }
    }
}
