//! Time of the parts of the pipeline, from a thousand rows to a million: `cargo bench`.
//!
//! Each figure is the median of seven runs. Machines differ and are noisy: read the column of
//! nanoseconds per row, which should not grow with the size, and the ratios of figures of one run.
//! Without `--bench` (as in the tests) the smallest size runs once.

mod planar;
mod timed;

use std::collections::BTreeSet;
use std::hint::black_box;

use hydrosysid::chain::Available;
use hydrosysid::dynamics::Dynamics;
use hydrosysid::estimate::output_error::{OutputErrorOptions, output_error};
use hydrosysid::estimate::{
    IntegralOptions, RegressorOptions, integral_least_squares, least_squares, regressors_of, started,
};
use hydrosysid::frame::Dof;
use hydrosysid::model::Interpolation;
use hydrosysid::run::Run;
use hydrosysid::simulate::{Track, free_run};
use hydrosysid::tank::{BlindOptions, blind};

fn main() {
    let thorough = std::env::args().any(|a| a == "--bench");
    let (sizes, repeats): (&[usize], usize) =
        if thorough { (&[1_000, 10_000, 100_000, 1_000_000], 7) } else { (&[1_000], 1) };
    println!("{:32} {:>9} {:>12} {:>9}", "part", "rows", "median ms", "ns/row");
    for n in sizes {
        let (model, run) = (planar::model(false), planar::run(*n, 0.1, 0.0));
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
    for n in sizes {
        // nine runs at 10 Hz
        let campaign = blind(&BlindOptions { duration: *n as f64 / 90.0, ..BlindOptions::default() });
        let campaign = campaign.expect("the tank sails");
        let model = started(&campaign.model().expect("a model"), &campaign.runs);
        let runs: Vec<&Run> = campaign.runs.iter().collect();
        report("whole fit, integral", *n, repeats, || {
            black_box(integral_least_squares(&runs, &model, IntegralOptions::default()).expect("a fit"));
        });
        let fitting = OutputErrorOptions { position: true, ..OutputErrorOptions::default() };
        report("whole fit, output error", *n, repeats, || {
            black_box(output_error(&model, &campaign.runs, &fitting).expect("a fit"));
        });
    }
}

fn report(part: &str, rows: usize, repeats: usize, work: impl FnMut()) {
    let median = timed::median(repeats, work);
    println!("{part:32} {rows:>9} {:>12.3} {:>9.1}", 1e3 * median, 1e9 * median / rows as f64);
}
