//! Time of the pipeline's parts, from a thousand rows to a million: `cargo bench`.
//!
//! Each figure is the median of seven runs. Machines differ and are noisy: what is meant to be read is the column of
//! nanoseconds a row, which should be flat, and the ratios of the rows in one run. Without `--bench` (as in the tests)
//! the smallest size runs once.

mod planar;

use std::collections::BTreeSet;
use std::hint::black_box;
use std::time::Instant;

use hydrosysid::chain::Available;
use hydrosysid::dynamics::Dynamics;
use hydrosysid::estimate::output_error::{OutputErrorOptions, output_error};
use hydrosysid::estimate::{RegressorOptions, least_squares, regressors_of, started};
use hydrosysid::frame::Dof;
use hydrosysid::model::Interpolation;
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
