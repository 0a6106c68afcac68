//! The `[efficiency]` table: what is lost between the thrust of the bollard and the thrust of the vehicle under way.
//!
//! ```text
//! τ = η_inter η_adv τ_nom          η_adv = slope |v_a| + intercept
//! ```
//!
//! Source: Avila, Donha and Adamowski, *Ocean Engineering* 60 (2013) 81-94, eqs. (16) and (17).

use std::fmt;

use serde::de::value::SeqAccessDeserializer;
use serde::de::{Deserializer, MapAccess, SeqAccess, Visitor};
use serde::ser::Serializer;
use serde::{Deserialize, Serialize};

use super::is_default;
use crate::frame::Dof;

/// Known losses of thrust; what is absent is 1.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct EfficiencyTable {
    /// Interaction efficiencies: in the file `{ surge = 0.97 }`, or a list of tables `{dof, thrusters, value}`.
    #[serde(with = "interactions", skip_serializing_if = "Vec::is_empty")]
    pub eta_inter: Vec<Interaction>,
    /// Loss with speed of advance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub eta_adv: Option<AdvanceLoss>,
}

/// The interaction efficiency of one degree of freedom and group of thrusters.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Interaction {
    /// Degree of freedom.
    pub dof: Dof,
    /// Names of the thrusters that run together; all when empty.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub thrusters: Vec<String>,
    /// η_inter, 1.
    pub value: f64,
}

/// η_adv = slope |v_a| + intercept.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AdvanceLoss {
    /// Change of efficiency with speed, s/m; negative for a loss.
    pub slope: f64,
    /// Efficiency at rest, 1.
    pub intercept: f64,
    /// Speeds between which the line was measured, m/s.
    pub valid: [f64; 2],
    /// Which speed is meant.
    #[serde(default, skip_serializing_if = "is_default")]
    pub advance: Advance,
}

/// The speed of advance v_a of a thruster.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Advance {
    /// The vehicle's own speed in the degree of freedom: the paper's choice, and the only one when no thruster is
    /// described; hence the default.
    #[default]
    Vehicle,
    /// The water's speed along each thruster's axis.
    Axis,
}

/// A table by degree of freedom, or a list where groups of thrusters are told apart.
mod interactions {
    use super::*;

    pub fn serialize<S: Serializer>(list: &[Interaction], serializer: S) -> Result<S::Ok, S::Error> {
        let distinct = (1..list.len()).all(|i| list[..i].iter().all(|other| other.dof != list[i].dof));
        if distinct && list.iter().all(|i| i.thrusters.is_empty()) {
            serializer.collect_map(list.iter().map(|i| (i.dof, i.value)))
        } else {
            serializer.collect_seq(list)
        }
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<Interaction>, D::Error> {
        struct Either;
        impl<'de> Visitor<'de> for Either {
            type Value = Vec<Interaction>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a table such as { surge = 0.97 }, or a list of tables {dof, thrusters, value}")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Vec<Interaction>, A::Error> {
                let mut list = Vec::new();
                while let Some((dof, value)) = map.next_entry()? {
                    list.push(Interaction { dof, thrusters: Vec::new(), value });
                }
                list.sort_by_key(|i| i.dof);
                Ok(list)
            }

            fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<Vec<Interaction>, A::Error> {
                Vec::deserialize(SeqAccessDeserializer::new(seq))
            }
        }
        deserializer.deserialize_any(Either)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_forms_read_and_come_back() {
        for text in [
            "eta_inter = { yaw = 0.9, surge = 0.97 }\neta_adv = { slope = -0.1946, intercept = 0.9967, valid = [0, 1] }",
            "eta_inter = [{ dof = 'surge', thrusters = ['T5', 'T6'], value = 1 }, { dof = 'surge', value = 0.97 }]",
        ] {
            let table: EfficiencyTable = toml::from_str(text).unwrap();
            assert_eq!(table.eta_inter[0].dof, Dof::Surge);
            assert_eq!(toml::from_str::<EfficiencyTable>(&toml::to_string(&table).unwrap()).unwrap(), table);
        }
    }
}
