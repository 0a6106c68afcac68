//! Tables for people of the random force, the noise of the sensors and the prediction errors.

use super::output::Output;
use super::table::{estimated, number, size, table};
use crate::campaign::{Noise, Predicted};
use crate::frame::Dof;

/// Prints the tables of a fit: forces, sensors, and prediction errors with their expected size.
/// Standard deviations are marked unless the fit `converged`.
pub(super) fn print(noise: &Noise, converged: bool, output: &Output) {
    forces(noise, converged, output);
    sensors(noise, output);
    let rows: Vec<Vec<String>> =
        Dof::ALL.into_iter().flat_map(|dof| [2.0, 8.0].map(|ahead| row(noise, dof, ahead))).flatten().collect();
    if !rows.is_empty() {
        output.print(&table(&["ahead", "dof", "rms error", "expected", "unit", ""], &rows));
    }
    output.print(match noise.innovations_white {
        true => "innovations are white",
        false => "innovations are not white: they contain something that the noise model does not explain",
    });
    if let Some(held_back) = &noise.held_back {
        output.print(&held_back.sentence());
    }
}

fn forces(noise: &Noise, converged: bool, output: &Output) {
    let rows: Vec<Vec<String>> = noise
        .force
        .iter()
        .map(|f| {
            let share = f.share_of_thrust.map_or(String::new(), |s| size(100.0 * s));
            let time = estimated(f.correlation_time, Some(f.correlation_time_std), converged);
            let remark = if f.only_intensity { "only rms² times time is known" } else { "" };
            vec![
                f.dof.to_string(),
                estimated(f.rms, Some(f.std), converged),
                f.unit.replace('*', " "),
                time,
                share,
                remark.into(),
            ]
        })
        .collect();
    if !rows.is_empty() {
        output.print(&table(&["random force", "rms", "unit", "correlation, s", "% of thrust", ""], &rows));
    }
}

fn sensors(noise: &Noise, output: &Output) {
    let told = |x: Option<f64>| x.map(size).unwrap_or_default();
    let rows: Vec<Vec<String>> = noise
        .sensors
        .iter()
        .map(|s| {
            let typical = s.typical.map_or(String::new(), |[low, high]| format!("{} to {}", size(low), size(high)));
            let coloured = s.coloured_std.zip(s.correlation_time);
            let coloured = coloured.map_or(String::new(), |(std, time)| format!("{} over {} s", size(std), size(time)));
            vec![s.channel.clone(), size(s.std), told(s.stated), typical, coloured]
        })
        .collect();
    output.print(&table(&["sensor noise", "found", "stated", "typical", "correlated"], &rows));
}

/// A row for the predictions of all runs together.
fn row(noise: &Noise, dof: Dof, ahead: f64) -> Option<Vec<String>> {
    let of: Vec<&Predicted> = noise.prediction.iter().filter(|p| p.dof == dof && p.ahead == Some(ahead)).collect();
    let mean = |f: &dyn Fn(&Predicted) -> f64| (of.iter().map(|p| f(p).powi(2)).sum::<f64>() / of.len() as f64).sqrt();
    let (rms, expected) = (mean(&|p| p.rms), mean(&|p| p.expected));
    let verdict = if !rms.is_finite() {
        "diverges".into()
    } else if rms > 1.2 * expected {
        format!("{} times", number(rms / expected))
    } else {
        "as expected".into()
    };
    let unit = noise.unit_in(dof).to_string();
    (!of.is_empty()).then(|| vec![format!("{ahead} s"), dof.to_string(), size(rms), size(expected), unit, verdict])
}

/// The error of a free simulation that the noise model predicts, for one run and degree of freedom.
pub(super) fn expected(noise: Option<&Noise>, run: &str, dof: Option<Dof>) -> Option<f64> {
    let of = |p: &&Predicted| p.run == run && Some(p.dof) == dof && p.ahead.is_none();
    noise?.prediction.iter().find(of).map(|p| p.expected)
}

/// Whether a run is predicted 8 s ahead with an error within `times` the expected one in every
/// degree of freedom.
pub(super) fn follows_ahead(noise: Option<&Noise>, run: &str, times: f64) -> bool {
    let ahead = |p: &&Predicted| p.run == run && p.ahead == Some(8.0);
    let mut ahead = noise.iter().flat_map(|noise| &noise.prediction).filter(ahead).peekable();
    ahead.peek().is_some() && ahead.all(|p| p.rms <= times * p.expected)
}

/// Prints the prediction errors of each run, for each time ahead.
pub(super) fn by_run(noise: &Noise, output: &Output) {
    let ahead = |p: &Predicted| match p.ahead {
        None => "free".to_string(),
        Some(0.0) => "1 sample".into(),
        Some(seconds) => format!("{seconds} s"),
    };
    let row = |p: &Predicted| {
        vec![p.run.clone(), p.dof.to_string(), ahead(p), size(p.rms), size(p.expected), noise.unit_in(p.dof).into()]
    };
    let rows: Vec<Vec<String>> = noise.prediction.iter().map(row).collect();
    if !rows.is_empty() {
        output.print(&table(&["run", "dof", "ahead", "rms error", "expected", "unit"], &rows));
    }
}
