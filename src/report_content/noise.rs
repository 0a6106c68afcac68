//! The part of the report about noise: the random force on the vehicle, the noise of each sensor,
//! and whether prediction errors are as large as expected.

use super::Results;
use crate::campaign::{ForceFound, Noise, Predicted, SensorFound};
use crate::frame::{Dof, Measured};
use crate::report::{Cell, Column, Table};

/// The random forces; `None` if there are none, or the estimator has no noise model.
pub(super) fn of_forces(results: &Results<'_>) -> Option<Table> {
    results.fit.noise.as_ref().and_then(|noise| forces(&noise.force, results.fit.converged))
}

/// The noise of the sensors; `None` if the estimator has no noise model.
pub(super) fn of_sensors(results: &Results<'_>) -> Option<Table> {
    results.fit.noise.as_ref().map(sensors)
}

fn columns(names: &[&str]) -> Vec<Column> {
    names.iter().map(|name| Column::new(*name, "")).collect()
}

fn number(value: Option<f64>) -> Cell {
    value.map_or(Cell::Empty, |value| Cell::Number { value, digits: 3 })
}

fn forces(all: &[ForceFound], converged: bool) -> Option<Table> {
    let row = |f: &ForceFound| {
        let estimate = |value, std: f64| Cell::Estimate { value, std: Some(std).filter(|s| *s > 0.0) };
        let mut row = vec![
            Cell::from(f.dof.to_string().as_str()),
            estimate(f.rms, f.std),
            Cell::from(crate::report::unit(f.unit).as_str()),
            estimate(f.correlation_time, f.correlation_time_std),
            number(f.share_of_thrust.map(|s| 100.0 * s)),
        ];
        if !converged {
            row.push(Cell::from(super::NOT_CONVERGED));
        }
        row
    };
    let names = ["degree of freedom", "rms ± std", "unit", "correlation time, s", "% of thrust", "deviation"];
    (!all.is_empty()).then(|| Table {
        title: "Random force".into(),
        columns: columns(if converged { &names[..5] } else { &names }),
        rows: all.iter().map(row).collect(),
        note:
            "A first-order Gauss-Markov process in each degree of freedom: turbulence, tether, thrusters that deviate \
             from their curve."
                .into(),
    })
}

/// Unit of a channel of a log.
fn unit(channel: &str) -> &'static str {
    let velocity = Dof::ALL.into_iter().find(|dof| dof.velocity() == channel);
    velocity.map_or_else(|| Measured::Function(channel.into()), Measured::from).unit()
}

fn sensors(noise: &Noise) -> Table {
    let white = match noise.innovations_white {
        true => "Innovations are white: the noise model explains what the model leaves.",
        false => "Innovations are not white: they contain something that the noise model does not explain.",
    };
    let held_back = noise.held_back.map_or(String::new(), |h| format!(" Here {}.", h.sentence()));
    let row = |s: &SensorFound| {
        let [low, high] = s.typical.map_or([None, None], |t| t.map(Some));
        let mut row = vec![Cell::from(s.channel.as_str())];
        row.extend([Some(s.std), s.stated, low, high, s.coloured_std].map(number));
        row.extend([Cell::from(unit(&s.channel)), number(s.correlation_time)]);
        row
    };
    let names = ["channel", "found", "stated", "typical from", "to", "correlated part", "unit", "correlation time, s"];
    Table {
        title: "Noise of the sensors".into(),
        columns: columns(&names),
        rows: noise.sensors.iter().map(row).collect(),
        note: format!("Standard deviations. {white}{held_back}"),
    }
}

/// Predictions with their errors, run by run; those one sample ahead are left out, because the
/// noise was fitted to them.
pub(super) fn predictions(noise: &Noise) -> Option<Table> {
    let row = |p: &Predicted| {
        let ahead = p.ahead.map_or("free run".to_string(), |seconds| format!("{seconds} s"));
        vec![
            Cell::from(p.run.as_str()),
            Cell::from(p.dof.to_string().as_str()),
            Cell::from(ahead.as_str()),
            number(Some(p.rms)),
            number(Some(p.expected)),
            Cell::from(noise.unit_in(p.dof)),
        ]
    };
    let rows: Vec<Vec<Cell>> = noise.prediction.iter().filter(|p| p.ahead != Some(0.0)).map(row).collect();
    (!rows.is_empty()).then(|| Table {
        title: "Whether prediction errors are as expected".into(),
        columns: columns(&["run", "degree of freedom", "ahead", "rms error", "expected", "unit"]),
        rows,
        note: "An error far above the expected one: the model lacks something that no noise explains.".into(),
    })
}
