//! Published parameters of a vehicle as commented priors.

use std::fmt::Write;
use std::path::Path;

use super::quoted;
use crate::campaign::published::Published;
use crate::campaign::vehicles::KnownVehicle;
use crate::effects::{Coriolis, id};
use crate::frame::Dof;
use crate::model::Model;

/// Relative standard deviation that is assumed for a published parameter without one. Authors
/// differ by about as much on the drag and the added mass of one small vehicle.
const SPREAD: f64 = 0.3;

/// `[[parameter]]` tables of the published parameters that act in `dofs`, each line a comment.
pub fn of(known: &KnownVehicle, dofs: &[Dof]) -> String {
    let Some(table) = &known.file.published else { return String::new() };
    let model = Model::new(dofs, Coriolis::Tied);
    let read = Published::of_vehicle(&table.to_string(), Path::new(&known.id), &known.file.vehicle, &model);
    let published = match read {
        Ok(published) => published,
        Err(error) => return format!("# The published parameters of this vehicle cannot be read: {error}\n"),
    };
    let mut text = format!(
        "\n# Published parameters of this vehicle ({}) as priors: uncomment those that you trust.\n# `hydrosysid \
         compare CAMPAIGN --params {}` compares all of them with your logs.\n",
        published.source, known.id
    );
    for (term, name, value, std) in published.values() {
        let stands =
            |(id, place): (&str, &str)| id::BALANCE.contains(&id) && dofs.iter().any(|dof| dof.name() == place);
        if !term.split_once('@').is_some_and(stands) {
            continue;
        }
        let (std, why) = match std {
            Some(std) => (std, "published"),
            None => (three_digits(SPREAD * value.abs()), "30 % of the value: no deviation is published"),
        };
        let _ = writeln!(
            text,
            "# [[parameter]]\n# effect = {}   # {name}\n# value = {value:?}\n# std = {std:?}   # {why}",
            quoted(term)
        );
    }
    text
}

/// `x` rounded to three digits: an assumed value has no more.
fn three_digits(x: f64) -> f64 {
    format!("{x:.2e}").parse().unwrap_or(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_assumed_has_three_digits() {
        assert_eq!(three_digits(5.957_999).to_string(), "5.96");
        assert_eq!(three_digits(0.177_6).to_string(), "0.178");
    }
}
