//! Results do not depend on the number of threads: they are the same to the bit with one and with two.

use std::sync::Arc;

use hydrosysid::discover::{SearchOptions, discover};
use hydrosysid::effects::Coriolis;
use hydrosysid::estimate::filter_error::FilterErrorOptions;
use hydrosysid::estimate::output_error::{OutputErrorFit, OutputErrorOptions, output_error};
use hydrosysid::estimate::{RegressorOptions, least_squares, regressors_of, started};
use hydrosysid::frame::Dof;
use hydrosysid::model::Model;
use hydrosysid::run::{Run, Signal};
use hydrosysid::tank::{Blind, BlindOptions, Hidden, blind};

/// The text that `work` returns with one thread; asserts that it is the same with two.
fn alike(work: impl Fn() -> String + Sync) -> String {
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(&work)
    };
    let one = with(1);
    assert_eq!(one, with(2));
    one
}

/// The bits of numbers as text.
fn bits(values: &[f64]) -> String {
    values.iter().map(|x| format!("{:016x} ", x.to_bits())).collect()
}

fn campaign(duration: f64) -> (Blind, Model, OutputErrorOptions) {
    let hidden = vec![Hidden::new("coulomb_friction@surge", 1.0)];
    let campaign = blind(&BlindOptions { duration, hidden, ..BlindOptions::default() }).expect("the tank sails");
    let model = campaign.model().expect("the baseline is a model");
    (campaign, model, OutputErrorOptions { position: true, ..OutputErrorOptions::default() })
}

#[test]
fn exact_regressors_and_tall_least_squares() {
    // long enough for several blocks of columns and of the fold
    const ROWS: usize = 80_000;
    let time: Arc<[f64]> = (0..ROWS).map(|k| 0.1 * k as f64).collect();
    let mut run = Run::default();
    for (name, size, rate) in [("u", 0.8, 0.21), ("v", 0.2, 0.37), ("r", 0.3, 0.53), ("tau_u", 140.0, 0.29)] {
        let values: Vec<f64> = time.iter().map(|t| size * (0.3 + (rate * t).sin())).collect();
        run.signals.insert(name.into(), Signal::new(time.clone(), values));
    }
    let effects = ["inertia@surge", "linear_drag@surge", "quadratic_drag@surge", "bias@surge", "coriolis_surge"];
    let dofs = [Dof::Surge, Dof::Sway, Dof::Yaw];
    let model = Model::with_effects(&dofs, Coriolis::Free, &effects).expect("a model");
    let found = alike(|| {
        let columns = regressors_of(Dof::Surge, &[&run], &model, RegressorOptions::default()).expect("surge is linear");
        assert_eq!(columns.rows(), ROWS - 1);
        let mut all = columns.columns.iter().map(|c| bits(&c[..c.len().min(20_000)])).collect::<String>();
        let fit = least_squares(&columns.slices(), &columns.rhs).expect("full rank");
        all += &bits(&fit.coefficients);
        all += &bits(&fit.standard_errors);
        all += &bits(&[fit.residual_std, fit.r_squared, fit.condition_number]);
        all
    });
    assert!(found.len() > 1_000);
}

#[test]
fn exact_output_error_bootstrap_and_monte_carlo() {
    let (campaign, model, options) = campaign(40.0);
    let model = started(&model, &campaign.runs);
    let describe = |fit: &OutputErrorFit| {
        let values: Vec<f64> = fit.model.parameters.iter().flat_map(|p| [p.value, p.std.unwrap_or(0.0)]).collect();
        bits(&values) + &bits(&[fit.cost])
    };
    let found = alike(|| {
        let fit = output_error(&model, &campaign.runs, &options).expect("a fit");
        let drawn = fit.bootstrap(0..40, 3, 8.0).expect("enough clusters");
        let refits = fit.monte_carlo_under(&options, 0..4, 5, |_| None);
        let draws = [drawn, refits].iter().flat_map(|d| &d.values).map(|x| bits(x)).collect::<String>();
        describe(&fit) + &draws
    });
    assert!(found.len() > 1_000);
}

#[test]
fn exact_discovery() {
    let (campaign, model, base) = campaign(30.0);
    let options = FilterErrorOptions { base, ..FilterErrorOptions::default() };
    let found = alike(|| {
        let found = discover(&model, &campaign.runs, &[], &options, &SearchOptions::default()).expect("a fit");
        // doubles are printed with all digits, so that equal text means equal bits
        serde_json::to_string(&found).expect("JSON")
    });
    assert!(found.contains("verdict"));
}
