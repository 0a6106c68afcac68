//! Loss of thrust by interaction, η_inter: thrusters that run together, in the flow about a hull,
//! give less than the sum of their single forces.
//!
//! ```text
//! τ_measured = η_inter τ_nom,     η̂ = Σ τ_nom τ_measured / Σ τ_nom²
//! ```
//!
//! η_inter is one scalar for each degree of freedom and group of running thrusters, by least
//! squares of the force of load cells on the nominal force (N, or N·m). Source: Avila, Donha and
//! Adamowski, *Ocean Engineering* 60 (2013) 81-94, Table 2.

use std::fmt;

use serde::de::{MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

use super::efficiency::EfficiencyError;
use crate::frame::Dof;
use crate::least_squares::{LeastSquaresError, least_squares};

/// One entry of η_inter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Interaction {
    /// Degree of freedom.
    pub dof: Dof,
    /// Names of the running thrusters; an empty list means any.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub thrusters: Vec<String>,
    /// η_inter, 1.
    pub value: f64,
    /// Its standard deviation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub std: Option<f64>,
}

/// The entries of η_inter: in a campaign either `{ surge = 0.97, … }` or a list of [`Interaction`].
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
#[serde(transparent)]
pub struct InteractionTable(pub Vec<Interaction>);

impl InteractionTable {
    /// η_inter of a degree of freedom while the named thrusters run: the entry of exactly this
    /// group, else that of any group, else 1.
    pub fn value(&self, dof: Dof, running: &[&str]) -> f64 {
        let same = |entry: &&Interaction| {
            entry.thrusters.len() == running.len()
                && entry.thrusters.iter().all(|name| running.contains(&name.as_str()))
        };
        let mut of_dof = self.0.iter().filter(|entry| entry.dof == dof);
        let any = || self.0.iter().find(|entry| entry.dof == dof && entry.thrusters.is_empty());
        of_dof.find(|entry| !entry.thrusters.is_empty() && same(entry)).or_else(any).map_or(1.0, |entry| entry.value)
    }

    /// Checks the entries.
    ///
    /// # Errors
    /// A value that is not positive and finite; two entries of one degree of freedom and group.
    pub fn validate(&self) -> Result<(), EfficiencyError> {
        for (i, entry) in self.0.iter().enumerate() {
            if !(entry.value.is_finite() && entry.value > 0.0) {
                return Err(EfficiencyError::BadInteraction { dof: entry.dof, value: entry.value });
            }
            let group = |entry: &Interaction| {
                let mut names = entry.thrusters.clone();
                names.sort_unstable();
                (entry.dof, names)
            };
            if self.0[..i].iter().any(|other| group(other) == group(entry)) {
                return Err(EfficiencyError::SameGroup { dof: entry.dof, thrusters: entry.thrusters.clone() });
            }
        }
        Ok(())
    }
}

impl<'de> Deserialize<'de> for InteractionTable {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<InteractionTable, D::Error> {
        // by hand, because an untagged enum would report a misspelt key as "matches no variant"
        struct Table;
        impl<'de> Visitor<'de> for Table {
            type Value = InteractionTable;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number per degree of freedom, or a list of { dof, thrusters, value }")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<InteractionTable, A::Error> {
                let mut entries = vec![];
                while let Some((dof, value)) = map.next_entry()? {
                    entries.push(Interaction { dof, thrusters: vec![], value, std: None });
                }
                Ok(InteractionTable(entries))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<InteractionTable, A::Error> {
                let mut entries = vec![];
                while let Some(entry) = list.next_element()? {
                    entries.push(entry);
                }
                Ok(InteractionTable(entries))
            }
        }
        deserializer.deserialize_any(Table)
    }
}

/// A fitted η_inter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InteractionFit {
    /// η_inter, 1.
    pub value: f64,
    /// Its standard deviation, valid if the residuals are independent.
    pub std: f64,
    /// Standard deviation of the residual, N or N·m.
    pub residual_std: f64,
    /// Number of rows.
    pub rows: usize,
}

/// Fits η_inter of one degree of freedom and group: `measured` by load cells on `nominal`, both N
/// or both N·m.
///
/// # Errors
/// Lists of different length, values that are not finite, fewer than 2 rows, a nominal force of
/// zero throughout.
pub fn fit_interaction(nominal: &[f64], measured: &[f64]) -> Result<InteractionFit, EfficiencyError> {
    EfficiencyError::check(("nominal force", nominal), ("measured force", measured), 2)?;
    let fit = least_squares(&[nominal], measured).map_err(|error| EfficiencyError::NotIdentifiable {
        needs: match error {
            LeastSquaresError::NoVariance { .. } => "a measured force other than zero",
            _ => "a nominal force other than zero",
        },
    })?;
    Ok(InteractionFit {
        value: fit.coefficients[0],
        std: fit.standard_errors[0],
        residual_std: fit.residual_std,
        rows: nominal.len(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::thrust::noise::Noise;

    #[derive(Deserialize)]
    struct Holder {
        eta_inter: InteractionTable,
    }

    fn read(text: &str) -> Result<InteractionTable, toml::de::Error> {
        toml::from_str::<Holder>(text).map(|holder| holder.eta_inter)
    }

    #[test]
    fn both_spellings_are_read() {
        let short = read("eta_inter = { surge = 0.97, sway = 0.9 }").unwrap();
        assert!((short.value(Dof::Sway, &["T6", "T8"]) - 0.9).abs() <= 0.0);
        assert!((short.value(Dof::Yaw, &[]) - 1.0).abs() <= 0.0);
        let long = read(
            "eta_inter = [{ dof = 'surge', thrusters = ['T5', 'T6'], value = 0.97, std = 0.01 },\n\
             { dof = 'surge', value = 0.905 }]",
        )
        .unwrap();
        assert!((long.value(Dof::Surge, &["T6", "T5"]) - 0.97).abs() <= 0.0, "order does not count");
        assert!((long.value(Dof::Surge, &["T5", "T6", "T2", "T8"]) - 0.905).abs() <= 0.0);
        long.validate().unwrap();
    }

    #[test]
    fn what_cannot_be_read_or_be_is_named() {
        assert!(read("eta_inter = { drift = 0.9 }").unwrap_err().message().contains("drift"));
        assert!(read("eta_inter = [{ dof = 'surge', vale = 1 }]").unwrap_err().message().contains("vale"));
        assert!(read("eta_inter = 0.9").unwrap_err().message().contains("a number per degree of freedom"));
        let negative = read("eta_inter = { surge = -0.9 }").unwrap();
        assert!(matches!(negative.validate(), Err(EfficiencyError::BadInteraction { dof: Dof::Surge, .. })));
        let twice = "eta_inter = [{ dof = 'yaw', thrusters = ['A', 'B'], value = 1.0 }, \
                     { dof = 'yaw', thrusters = ['B', 'A'], value = 0.9 }]";
        assert!(matches!(read(twice).unwrap().validate(), Err(EfficiencyError::SameGroup { dof: Dof::Yaw, .. })));
    }

    #[test]
    fn paper_profile_gives_its_efficiency_back() {
        // the paper's bollard profile 263.27 sin(2πt/24) + 296.80 N with Table 2's 0.905, at 10 Hz
        // for two periods
        let nominal: Vec<f64> =
            (0..480).map(|k| 263.27 * (std::f64::consts::TAU * 0.1 * f64::from(k) / 24.0).sin() + 296.80).collect();
        let mut noise = Noise::new(2);
        let measured: Vec<f64> = nominal.iter().map(|f| 0.905 * f + 5.0 * noise.normal()).collect();
        let fit = fit_interaction(&nominal, &measured).unwrap();
        // by hand: σ/sqrt(Σ τ²) = 5/sqrt(480 (296.8² + 263.27²/2)) = 6.5e-4
        assert!((fit.std - 6.5e-4).abs() < 0.5e-4, "{fit:?}");
        assert!((fit.value - 0.905).abs() < 3.0 * fit.std, "three standard deviations, seed fixed: {fit:?}");
        assert!((fit.residual_std - 5.0).abs() < 0.6, "5/sqrt(2·480) is 0.16, four of them");
    }

    #[test]
    fn lists_that_do_not_fit_are_refused() {
        assert!(matches!(fit_interaction(&[1.0], &[1.0]), Err(EfficiencyError::TooFewRows { rows: 1, needed: 2 })));
        assert!(matches!(fit_interaction(&[1.0, 2.0], &[1.0]), Err(EfficiencyError::Lengths { .. })));
        assert!(matches!(
            fit_interaction(&[1.0, f64::NAN], &[1.0, 2.0]),
            Err(EfficiencyError::NotFinite { row: 2, .. })
        ));
        assert!(matches!(fit_interaction(&[0.0; 3], &[1.0; 3]), Err(EfficiencyError::NotIdentifiable { .. })));
    }
}
