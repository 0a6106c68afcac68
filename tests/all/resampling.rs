//! Refits of the staged procedure, and with uncertain thruster curves: their scatter agrees with
//! the standard deviations that a fit reports.

use std::collections::BTreeMap;
use std::path::Path;

use hydrosysid::campaign::file::{CampaignFile, ReadOptions};
use hydrosysid::campaign::{self, Campaign, Estimator, FitOptions, LoadOptions, Resampler, Resampling};
use hydrosysid::log;
use hydrosysid::tank::paper_campaign;

/// The runs of the paper's campaign in surge and yaw, as a campaign read from files.
fn paper() -> Campaign {
    let mut campaign = paper_campaign(7, 1.0).expect("it sails");
    let kept = ["bollard_surge", "steady_surge", "steady_yaw", "surge_", "yaw_", "zigzag"];
    campaign.runs.retain(|run| kept.iter().any(|name| run.name.starts_with(name)));
    let text = "format = 1\n[vehicle]\nmass = 189.0\nweight = 1854.1\nbuoyancy = 1887.5\nlength = 0.575\n[model]\n\
        dofs = ['surge', 'sway', 'yaw']\ncoriolis = 'free'\neffects = ['inertia', 'linear_drag', 'quadratic_drag', \
        'coriolis_yaw', 'restoring_surge', 'bias@surge', 'bias@yaw']\n[[run]]\nfile = 'a.csv'\n";
    let options = ReadOptions { look_for_files: false, ..ReadOptions::default() };
    let file = CampaignFile::from_bytes(text.as_bytes(), Path::new("paper.toml"), &options);
    Campaign::from_runs(file.unwrap_or_else(|e| panic!("{e}")), campaign.runs).unwrap_or_else(|e| panic!("{e}"))
}

fn ratios(campaign: &Campaign, estimator: Estimator, found: &Resampling) -> BTreeMap<String, f64> {
    let fit = campaign::fit(campaign, FitOptions { estimator: Some(estimator) }).unwrap_or_else(|e| panic!("{e}"));
    let of = |one: &campaign::Scatter| {
        let parameter = fit.model.parameters.iter().find(|p| p.term == one.term && p.spec.name == one.name);
        let std = parameter.expect("it was fitted").std.expect("it was fitted");
        (format!("{} {}", one.term, one.name), one.std / std)
    };
    found.parameters.iter().map(of).collect()
}

/// Staged refits of runs that the fitted model generates scatter as the fit reports: load cells,
/// steady runs with a force of their own each, oscillations and zig-zags. The standard deviations
/// of steady stages are increased for their few rows, and 16 draws give a scatter to a fifth; the
/// bounds of drag follow from that. The pooled inertia in yaw has a standard deviation for runs
/// that differ from each other, which generated runs do not; and the model does not drive sway, so
/// that generated zig-zags show k_uv less than those of the tank. The bounds of the others are
/// therefore wide.
#[test]
fn staged_refits_of_made_runs_scatter_as_the_fit_says() {
    let campaign = paper();
    let found =
        campaign::resample(&campaign, Estimator::Staged, Resampler::MonteCarlo, 16).unwrap_or_else(|e| panic!("{e}"));
    assert!(found.draws >= 14 && found.method == Resampler::MonteCarlo, "{found:?}");
    let again =
        campaign::resample(&campaign, Estimator::Staged, Resampler::MonteCarlo, 3).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(
        again,
        campaign::resample(&campaign, Estimator::Staged, Resampler::MonteCarlo, 3).unwrap_or_else(|e| panic!("{e}"))
    );
    let ratios = ratios(&campaign, Estimator::Staged, &found);
    assert!(ratios.len() >= 8, "{ratios:?}");
    for (name, ratio) in &ratios {
        let bounds = if name.contains("drag") { 0.4..1.6 } else { 0.05..5.0 };
        assert!(bounds.contains(ratio), "{name}: {ratio} of {ratios:?}");
    }
    for one in &found.parameters {
        // such data are made to show bias; for drag in yaw, whose two laws compensate each other,
        // it is a tenth
        assert!((one.mean - one.value).abs() < 4.0 * one.std + 0.15 * one.value.abs(), "{one:?}");
    }
}

#[test]
fn staged_bootstrap_draws_runs_kind_by_kind_and_says_where_they_are_too_few() {
    let campaign = paper();
    let found = campaign::resample(&campaign, Estimator::Staged, Resampler::Bootstrap, 16);
    match found {
        Ok(found) => {
            assert!(found.draws >= 10 && found.parameters.len() >= 8, "{found:?}");
            for (name, ratio) in ratios(&campaign, Estimator::Staged, &found) {
                assert!((0.2..5.0).contains(&ratio), "{name}: {ratio}");
            }
        }
        Err(error) => panic!("{error}"),
    }
    let mut few = campaign;
    let mut kept = 0;
    few.runs.retain(|run| {
        kept += usize::from(run.name.starts_with("steady_surge"));
        !run.name.starts_with("steady_surge") || kept <= 2
    });
    let error = campaign::resample(&few, Estimator::Staged, Resampler::Bootstrap, 5).expect_err("two rows");
    assert!(error.is_wrong_use() && error.to_string().contains("--monte-carlo"), "{error}");
}

/// A campaign with a thruster table of 5 % noise and one run of a vehicle that the thruster drives:
/// the uncertainty of the drag comes from the thrust curve more than from the log.
fn with_a_table() -> std::path::PathBuf {
    let folder = std::env::temp_dir().join(format!("hydrosysid-resampling-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a temporary folder");
    let mut noise = hydrosysid::tank::Noise::new(3, 1);
    let force = |v: f64| if v < 0.0 { -20.0 * v * v + 10.0 * v } else { 30.0 * v * v + 12.0 * v };
    let mut table = String::from("V1,force\n");
    for k in (-12..=12).filter(|k| *k != 0) {
        let v = f64::from(k) / 12.0;
        table += &format!("{v},{}\n", force(v) + 1.5 * noise.normal());
    }
    std::fs::write(folder.join("pull.csv"), table).expect("it can be written");
    let command = |t: f64| 0.2 + 0.7 * (std::f64::consts::TAU * t / 15.0).sin();
    let (mut u, h) = (0.0, 0.005);
    let mut run = hydrosysid::run::Run { name: "motion".into(), ..Default::default() };
    let (mut time, mut speed, mut volts) = (Vec::new(), Vec::new(), Vec::new());
    for k in 0..=24000 {
        let t = h * f64::from(k);
        if k % 40 == 0 {
            time.push(t);
            speed.push(u + 1e-3 * noise.normal());
            volts.push(command(t));
        }
        let slope = |t: f64, u: f64| (force(command(t)) - 10.0 * u - 40.0 * u * f64::abs(u)) / 50.0;
        let k1 = slope(t, u);
        let k2 = slope(t + 0.5 * h, u + 0.5 * h * k1);
        u += h * k2;
    }
    let time: std::sync::Arc<[f64]> = time.into();
    run.signals.insert("u".into(), hydrosysid::run::Signal::new(time.clone(), speed));
    run.signals.insert("V1".into(), hydrosysid::run::Signal::new(time, volts));
    log::write(&run, folder.join("motion.csv")).expect("it can be written");
    let text = "format = 1\n[vehicle]\nmass = 40.0\n[model]\ndofs = ['surge']\neffects = ['inertia', 'linear_drag', \
        'quadratic_drag']\n[[thruster]]\nname = 'aft'\nposition = [-0.5, 0.0, 0.0]\naxis = [1.0, 0.0, 0.0]\n\
        bollard = 'pull.csv'\n[[run]]\nfile = 'motion.csv'\nkind = 'free'\n";
    std::fs::write(folder.join("campaign.toml"), text).expect("it can be written");
    folder
}

/// Refits draw the thrust curve as well. The curve causes most of the standard deviation here, so
/// that refits without it scatter by a fraction.
#[test]
fn refits_draw_the_curves_of_thrusters() {
    let folder = with_a_table();
    let campaign =
        Campaign::load(&folder.join("campaign.toml"), LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    let mut known = campaign.clone();
    known.curves.clear();
    for (estimator, method, draws) in [
        (Estimator::FilterError, Resampler::Bootstrap, 400),
        (Estimator::FilterError, Resampler::MonteCarlo, 100),
        (Estimator::OutputError, Resampler::Bootstrap, 400),
        (Estimator::OutputError, Resampler::MonteCarlo, 100),
        (Estimator::Integral, Resampler::Bootstrap, 200),
        (Estimator::Integral, Resampler::MonteCarlo, 100),
    ] {
        let refits = |campaign: &Campaign| {
            campaign::resample(campaign, estimator, method, draws).unwrap_or_else(|e| panic!("{e}"))
        };
        let (found, without) = (refits(&campaign), refits(&known));
        let (with, without) = (ratios(&campaign, estimator, &found), ratios(&campaign, estimator, &without));
        let drag = with.keys().find(|name| name.starts_with("quadratic")).expect("it is there").clone();
        // 100 draws give a standard deviation to 7 %; the curvature of the curve and the few
        // stretches add to that
        assert!((0.7..1.4).contains(&with[&drag]), "{estimator:?} {method:?}: {with:?}");
        assert!(without[&drag] < 0.6 * with[&drag], "{estimator:?} {method:?}: {without:?} against {with:?}");
    }
    std::fs::remove_dir_all(folder).expect("it is there");
}
