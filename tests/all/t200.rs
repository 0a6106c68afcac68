//! The thruster's curve on real bollard-pull data: Blue Robotics T200, six supply voltages, 201 rows each.

use hydrosysid::thrust::bollard::{Bollard, CurveOptions, DeadBand};
use hydrosysid::thrust::fit::{CurveFit, DirectionFit, fit_curve};

use crate::shared;

/// Command, force and supply voltage of the rows at these supply voltages; `None` where the data is not at hand.
struct Table {
    command: Vec<f64>,
    force: Vec<f64>,
    supply: Vec<f64>,
}

const VOLTAGES: [f64; 6] = [10.0, 12.0, 14.0, 16.0, 18.0, 20.0];

fn table(voltages: &[f64]) -> Option<Table> {
    let file = shared::path("realdata/t200-thruster/derived/t200_bollard.csv")?;
    let mut reader = csv::Reader::from_path(file).expect("a readable file");
    let mut table = Table { command: vec![], force: vec![], supply: vec![] };
    for row in reader.deserialize() {
        let row: std::collections::HashMap<String, f64> = row.expect("a row of numbers");
        let supply = row["supply_V"];
        if voltages.iter().any(|v| (v - supply).abs() < 0.5) {
            table.command.push((row["pwm_us"] - 1500.0) / 400.0);
            table.force.push(row["force_N"]);
            table.supply.push(supply);
        }
    }
    assert_eq!(table.command.len(), 201 * voltages.len());
    Some(table)
}

fn fit(table: &Table, deadband: DeadBand) -> CurveFit {
    let rows = Bollard { command: &table.command, force: &table.force, supply: Some(&table.supply) };
    fit_curve(&rows, &CurveOptions { deadband, ..CurveOptions::default() }).expect("an ordinary thruster")
}

fn agree(value: f64, printed: f64, digits: f64) {
    assert!((value - printed).abs() <= 0.5 * digits + 1e-9, "{value} against {printed} as printed");
}

#[test]
fn regress_curve_at_16_volts() {
    let Some(table) = table(&[16.0]) else { return };
    // published with the data: one digit after the point, two of the root mean square of 100 residuals
    let rms = |side: DirectionFit| side.residual_std * 0.98_f64.sqrt();
    let plain = fit(&table, DeadBand::Given(0.0));
    for (side, a, b, residual) in [(plain.forward, 37.4, 16.5, 0.69), (plain.reverse, 28.4, 13.7, 0.60)] {
        agree(side.a.value, a, 0.1);
        agree(side.b.value, b, 0.1);
        agree(rms(side), residual, 0.01);
    }
    let banded = fit(&table, DeadBand::Given(0.08));
    for (side, a, b, residual) in [(banded.forward, 30.2, 30.1, 0.31), (banded.reverse, 22.5, 24.4, 0.32)] {
        agree(side.a.value, a, 0.1);
        agree(side.b.value, b, 0.1);
        agree(rms(side), residual, 0.01);
    }
}

#[test]
fn regress_dead_band_at_every_voltage() {
    // found by this fit: 0.115 at 10 V down to 0.028 at 20 V, where the real curve's shape leaves little to gain
    let found = [0.115, 0.103, 0.094, 0.087, 0.065, 0.028];
    for (voltage, found) in VOLTAGES.into_iter().zip(found) {
        let Some(table) = table(&[voltage]) else { return };
        let (plain, fitted) = (fit(&table, DeadBand::Given(0.0)), fit(&table, DeadBand::Fitted));
        agree(fitted.deadband.value, found, 0.001);
        let squares = |fit: &CurveFit| fit.forward.residual_std.powi(2) + fit.reverse.residual_std.powi(2);
        assert!(squares(&fitted) < squares(&plain), "{voltage} V");
        fitted.curve.validate().expect("an ordinary thruster");
        for wanted in [-20.0, -1.0, 0.5, 15.0, 25.0] {
            let command = fitted.curve.inverse(wanted);
            // rounding only
            assert!((fitted.curve.force(command.voltage) - wanted).abs() < 1e-12 * 25.0);
        }
    }
}

#[test]
fn regress_supply_exponent() {
    let Some(table) = table(&VOLTAGES) else { return };
    let with = fit(&table, DeadBand::Fitted);
    let exponent = with.exponent.expect("six voltages");
    // force at full command grows from 28.7 N at 10 V to 65.9 N at 20 V: ln 2.296/ln 2 = 1.20; over all commands less
    assert!((0.9..1.2).contains(&exponent.value), "{exponent:?}");
    let blind = Bollard { command: &table.command, force: &table.force, supply: None };
    let options = CurveOptions { deadband: DeadBand::Fitted, ..CurveOptions::default() };
    let blind = fit_curve(&blind, &options).expect("an ordinary thruster");
    // ignoring the battery is an error of tens of per cent
    assert!(blind.forward.residual_std > 5.0 * with.forward.residual_std);
}
