//! Time of the pipeline's parts, from a thousand rows to a million: `cargo bench`.
//!
//! Each figure is the median of seven runs. Machines differ and are noisy: what is meant to be read is the column of
//! nanoseconds a row, which should be flat, and the ratios of the rows in one run. Without `--bench` (as in the tests)
//! the smallest size runs once.

use std::collections::BTreeSet;
use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

use hydrosysid::chain::Available;
use hydrosysid::dynamics::Dynamics;
use hydrosysid::effects::Coriolis;
use hydrosysid::estimate::output_error::{OutputErrorOptions, output_error};
use hydrosysid::estimate::{RegressorOptions, least_squares, regressors_of, started};
use hydrosysid::frame::Dof;
use hydrosysid::model::{Interpolation, Model};
use hydrosysid::run::{Run, Signal};
use hydrosysid::simulate::{Track, free_run};
use hydrosysid::tank::{BlindOptions, blind};

fn main() {
    let thorough = std::env::args().any(|a| a == "--bench");
    let (sizes, repeats): (&[usize], usize) =
        if thorough { (&[1_000, 10_000, 100_000, 1_000_000], 7) } else { (&[1_000], 1) };
    println!("{:32} {:>9} {:>12} {:>9}", "part", "rows", "median ms", "ns/row");
    for n in sizes {
        let (model, run) = planar(*n);
        let options = RegressorOptions::default();
        report("columns of surge, trapezoid", *n, repeats, || {
            black_box(regressors_of(Dof::Surge, &[&run], &model, options).expect("surge can be regressed"));
        });
        let columns = regressors_of(Dof::Surge, &[&run], &model, options).expect("surge can be regressed");
        report("least squares, 2 columns", *n, repeats, || {
            black_box(least_squares(&columns.slices()[..2], &columns.rhs).expect("full rank"));
        });
        let channels = run.signals.keys().cloned().collect();
        let available = Available { channels, ..Available::default() };
        let dynamics =
            Dynamics::compile(&model, &available, &BTreeSet::from(["u".into(), "v".into(), "r".into()]), &[]);
        let track =
            Track::new(&run, 0, &dynamics, &model.values(), Interpolation::Linear, 1.0).expect("the run is complete");
        report("RK4, planar", *n, repeats, || {
            black_box(free_run(&dynamics, &track, &model.values(), &[0.0; 4], 0, n - 1));
        });
    }
    let campaign = blind(&BlindOptions::default()).expect("the tank sails");
    let model = started(&campaign.model().expect("a model"), &campaign.runs);
    let fitting = OutputErrorOptions { position: true, ..OutputErrorOptions::default() };
    let rows = campaign.runs.iter().map(|r| r.signals["u"].len()).sum();
    report("whole output-error fit", rows, repeats, || {
        black_box(output_error(&model, &campaign.runs, &fitting).expect("a fit"));
    });
}

fn report(part: &str, rows: usize, repeats: usize, mut work: impl FnMut()) {
    let mut times: Vec<f64> = (0..repeats)
        .map(|_| {
            let begin = Instant::now();
            work();
            begin.elapsed().as_secs_f64()
        })
        .collect();
    times.sort_by(f64::total_cmp);
    let median = times[times.len() / 2];
    println!("{part:32} {rows:>9} {:>12.3} {:>9.1}", 1e3 * median, 1e9 * median / rows as f64);
}

/// A planar model and a run of `n` samples at 10 Hz in which everything moves.
fn planar(n: usize) -> (Model, Run) {
    let effects = ["inertia", "linear_drag", "quadratic_drag", "coriolis_surge", "coriolis_sway", "coriolis_yaw"];
    let mut model = Model::with_effects(&[Dof::Surge, Dof::Sway, Dof::Yaw], Coriolis::Tied, &effects).expect("planar");
    for (dof, [m, linear, quadratic]) in
        [("surge", [842.0, 82.0, 309.0]), ("sway", [1100.0, 120.0, 450.0]), ("yaw", [186.0, 12.8, 95.3])]
    {
        model.set(&format!("inertia@{dof}"), m);
        model.set(&format!("linear_drag@{dof}"), linear);
        model.set(&format!("quadratic_drag@{dof}"), quadratic);
    }
    let time: Arc<[f64]> = (0..n).map(|k| 0.1 * k as f64).collect();
    let mut run = Run::default();
    let signals: [(&str, f64, f64, f64); 6] = [
        ("u", 0.5, 0.3, 0.21),
        ("v", 0.0, 0.2, 0.37),
        ("r", 0.0, 0.3, 0.53),
        ("tau_u", 180.0, 140.0, 0.22),
        ("tau_v", 0.0, 60.0, 0.31),
        ("tau_r", 0.0, 40.0, 0.47),
    ];
    for (name, offset, amplitude, rate) in signals {
        let values: Vec<f64> = time.iter().map(|t| offset + amplitude * (rate * t).sin()).collect();
        run.signals.insert(name.into(), Signal::new(time.clone(), values));
    }
    (model, run)
}
