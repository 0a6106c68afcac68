//! Checks of a model file that types cannot express: numbers that are not finite, an impossible
//! noise or covariance, parameters given twice.

use std::path::Path;

use super::super::file::{Source, tie_cycle};
use super::{ModelFile, ModelFileError};

/// Refuses what no fit writes, with its place in `text`.
///
/// # Errors
/// [`ModelFileError::Value`] for the first fault.
pub(super) fn check(file: &ModelFile, text: &str, path: &Path) -> Result<(), ModelFileError> {
    let Err((key, message)) =
        numbers(file).and_then(|()| noise(file)).and_then(|()| covariance(file)).and_then(|()| parameters(file))
    else {
        return Ok(());
    };
    // JSON has no places: only the key is given
    let location = (!super::is_json(path)).then(|| Source::of(path, text).locate_near(&key)).flatten();
    let place = location.map(|at| (at.line, at.column));
    Err(ModelFileError::Value { file: path.to_path_buf(), place, key, message })
}

/// A key and what is wrong with its value.
type Wrong = (String, String);

fn finite(key: impl FnOnce() -> String, value: f64) -> Result<(), Wrong> {
    match value.is_finite() {
        true => Ok(()),
        false => Err((key(), format!("{value} is not a finite number"))),
    }
}

/// Checks that all numbers are finite, standard deviations not negative, and properties of vehicle
/// and water positive.
fn numbers(file: &ModelFile) -> Result<(), Wrong> {
    for (i, p) in file.parameters.iter().enumerate() {
        finite(|| format!("parameter[{i}].value"), p.value)?;
        for (run, value) in &p.per_run {
            finite(|| format!("parameter[{i}].per_run.{run}"), *value)?;
        }
        if let Some(std) = p.std {
            let key = || format!("parameter[{i}].std");
            finite(key, std)?;
            if std < 0.0 {
                return Err((key(), format!("{std:?}: a standard deviation must not be negative")));
            }
        }
    }
    for (channel, range) in &file.envelope {
        for (k, value) in range.iter().enumerate() {
            finite(|| format!("envelope.{channel}[{k}]"), *value)?;
        }
    }
    for (i, thruster) in file.thrusters.iter().enumerate() {
        thruster.validate().map_err(|e| (format!("thruster[{i}]"), e.to_string()))?;
    }
    file.efficiency.validate().map_err(|e| ("efficiency".to_string(), e.to_string()))?;
    file.log.validate().map_err(|e| ("log".to_string(), e.to_string()))?;
    for (i, reading) in file.readings.iter().enumerate() {
        reading.log.validate().map_err(|e| (format!("reading[{i}].log"), e.to_string()))?;
    }
    file.vehicle.validate().map_err(|e| ("vehicle".to_string(), e.to_string()))?;
    file.water.validate().map_err(|e| ("water".to_string(), e.to_string()))
}

fn positive(key: String, value: f64, what: &str) -> Result<(), Wrong> {
    match value.is_finite() && value > 0.0 {
        true => Ok(()),
        false => Err((key, format!("{value:?}: {what} must be a positive number"))),
    }
}

fn deviation(key: String, value: f64) -> Result<(), Wrong> {
    match value.is_finite() && value >= 0.0 {
        true => Ok(()),
        false => Err((key, format!("{value:?}: a standard deviation must be a number that is not negative"))),
    }
}

/// Checks what simulations and plans draw from: deviations of forces and sensors, times and rates.
fn noise(file: &ModelFile) -> Result<(), Wrong> {
    for (channel, instrument) in &file.sensors {
        deviation(format!("sensors.{channel}.noise"), instrument.noise)?;
        positive(format!("sensors.{channel}.rate"), instrument.rate, "a rate")?;
    }
    let Some(noise) = &file.noise else { return Ok(()) };
    for (i, force) in noise.force.iter().enumerate() {
        deviation(format!("noise.force[{i}].rms"), force.rms)?;
        positive(format!("noise.force[{i}].correlation_time"), force.correlation_time, "a correlation time")?;
    }
    for (i, sensor) in noise.sensor.iter().enumerate() {
        deviation(format!("noise.sensor[{i}].std"), sensor.std)?;
        if let Some(std) = sensor.coloured_std {
            deviation(format!("noise.sensor[{i}].coloured_std"), std)?;
        }
        if let Some(time) = sensor.correlation_time {
            positive(format!("noise.sensor[{i}].correlation_time"), time, "a correlation time")?;
        }
    }
    Ok(())
}

/// Relative error of a covariance that the digits of a file may cause.
const ROUNDING: f64 = 1e-6;

/// Checks the covariance: a row and a column for each parameter, or none at all; symmetric, no
/// variance below 0, no correlation beyond 1.
fn covariance(file: &ModelFile) -> Result<(), Wrong> {
    let count = file.parameters.len();
    let size =
        |rows: usize| format!("{rows}, but there are {count} parameters: a covariance has a row and a column for each");
    // an empty one says nothing, as in a file written by hand
    if file.covariance.is_empty() {
        return Ok(());
    }
    if file.covariance.len() != count {
        return Err(("covariance".into(), format!("its number of rows is {}", size(file.covariance.len()))));
    }
    for (i, row) in file.covariance.iter().enumerate() {
        if row.len() != count {
            return Err((format!("covariance[{i}]"), format!("its number of columns is {}", size(row.len()))));
        }
        for (j, value) in row.iter().enumerate() {
            finite(|| format!("covariance[{i}][{j}]"), *value)?;
        }
        if row[i] < 0.0 {
            return Err((format!("covariance[{i}][{i}]"), format!("{:?}: a variance must not be negative", row[i])));
        }
    }
    for (i, row) in file.covariance.iter().enumerate() {
        for (j, value) in row.iter().enumerate().take(i) {
            correlated(&file.covariance, (i, j), *value)?;
        }
    }
    Ok(())
}

/// Checks that an entry is equal on both sides of the diagonal and no correlation exceeds 1, except
/// for rounding.
fn correlated(covariance: &[Vec<f64>], (i, j): (usize, usize), value: f64) -> Result<(), Wrong> {
    let most = (covariance[i][i] * covariance[j][j]).sqrt();
    let other = covariance[j][i];
    let key = format!("covariance[{i}][{j}]");
    if (value - other).abs() > ROUNDING * most.max(value.abs()) {
        return Err((key, format!("{value:?}, but covariance[{j}][{i}] is {other:?}: a covariance must be symmetric")));
    }
    if value.abs() > (1.0 + ROUNDING) * most {
        return Err((
            key,
            format!(
                "{value:?} implies a correlation beyond 1: with these variances at most {most:?} is \
                                  possible"
            ),
        ));
    }
    Ok(())
}

/// Checks that each parameter is given once, and that no tie leads back to itself.
fn parameters(file: &ModelFile) -> Result<(), Wrong> {
    let list = &file.parameters;
    for (i, p) in list.iter().enumerate() {
        if list[..i].iter().any(|other| (&other.effect, &other.name) == (&p.effect, &p.name)) {
            let text = format!("`{}` of `{}` occurs here for the second time: keep one", p.name, p.effect);
            return Err((format!("parameter[{i}].effect"), text));
        }
    }
    match tie_cycle(&file.tied) {
        None => Ok(()),
        Some(i) => Err((format!("tied[{i}].tie"), "this tie leads back to its own parameter: leave one untied".into())),
    }
}
