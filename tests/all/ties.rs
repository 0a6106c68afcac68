//! Tied parameters: one parameter for two effects, from the campaign through the fit to the model
//! file and back.

use std::path::Path;

use hydrosysid::campaign::file::{CampaignFile, ReadOptions};
use hydrosysid::campaign::{self, Campaign, Estimator, FitOptions, ModelFile};
use hydrosysid::effects::Coriolis;
use hydrosysid::frame::Dof;
use hydrosysid::model::Model;
use hydrosysid::run::Run;
use hydrosysid::tank::{Basin, Law, Measured, Noise, Pilot, Sensor, Sine, Trial};

const DRAG: f64 = 180.0;

/// Runs of a hull that is as high as it is wide, so that sway and heave have the same quadratic drag.
fn runs() -> Vec<Run> {
    let dofs = [Dof::Sway, Dof::Heave];
    let mut model = Model::with_effects(&dofs, Coriolis::Tied, &["inertia", "quadratic_drag"]).expect("a model");
    for (name, value) in [("inertia@sway", 150.0), ("inertia@heave", 170.0)] {
        assert!(model.set(name, value));
    }
    for dof in dofs {
        assert!(model.set(&format!("quadratic_drag@{dof}"), DRAG));
    }
    let sensors = dofs.map(|dof| Sensor::new(dof.velocity(), 10.0, 0.004)).into();
    let basin = Basin { sensors, ..Basin::default() };
    let mut draw = Noise::new(3, 1);
    (0..3)
        .map(|k| {
            let mut sine = || Sine { amplitude: draw.between(30.0, 60.0), period: draw.between(5.0, 15.0), phase: 0.0 };
            let laws = dofs.map(|dof| (dof, Law::Sines(0.0, vec![sine(), sine()])));
            let (pilot, start) = (Pilot::new(laws.to_vec()), Measured::default());
            let trial = Trial { name: format!("run{k}"), duration: 60.0, pilot, start, ..Trial::default() };
            basin.sail(&model, &trial, k, 5).expect("it sails")
        })
        .collect()
}

fn campaign(more: &str) -> Campaign {
    let text = format!(
        "format = 1\n[model]\ndofs = ['sway', 'heave']\neffects = ['inertia', 'quadratic_drag']\n{more}[[run]]\nfile = 'a.csv'\n"
    );
    let options = ReadOptions { look_for_files: false, ..ReadOptions::default() };
    let file = CampaignFile::from_bytes(text.as_bytes(), Path::new("tied.toml"), &options);
    Campaign::from_runs(file.unwrap_or_else(|e| panic!("{e}")), runs()).unwrap_or_else(|e| panic!("{e}"))
}

/// A tied parameter has one value from both balances, within four standard deviations of the truth,
/// and a smaller standard deviation than each of two free parameters.
#[test]
fn a_tied_parameter_is_found_from_both_balances() {
    let tied = campaign("[[parameter]]\neffect = 'quadratic_drag@heave'\ntie = 'quadratic_drag@sway'\n");
    let apart = campaign("");
    for estimator in [Estimator::OutputError, Estimator::Integral] {
        let fitted = |campaign: &Campaign| {
            let options = FitOptions { estimator: Some(estimator) };
            campaign::fit(campaign, options).unwrap_or_else(|e| panic!("{e}"))
        };
        let (one, two) = (fitted(&tied), fitted(&apart));
        assert_eq!((one.parameters.len(), two.parameters.len()), (3, 4));
        let drag = |fit: &campaign::Fit, dof: &str| {
            let index = fit.model.parameter_of(&format!("quadratic_drag@{dof}")).expect("it is there");
            (fit.model.parameters[index].value, fit.model.parameters[index].std.expect("it was fitted"))
        };
        let (value, std) = drag(&one, "heave");
        assert_eq!(value.to_bits(), drag(&one, "sway").0.to_bits());
        assert!((value - DRAG).abs() < 4.0 * std, "{}: {value} ± {std}", estimator.name());
        if estimator == Estimator::OutputError {
            let [a, b] = ["sway", "heave"].map(|dof| drag(&two, dof).1);
            assert!(std < a.min(b), "{std} of both, {a} and {b} of each");
        }
    }
}

#[test]
fn a_model_file_keeps_the_tie() {
    let tied = campaign("[[parameter]]\neffect = 'quadratic_drag@heave'\ntie = 'quadratic_drag@sway'\n");
    let fit = campaign::fit(&tied, FitOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    for name in ["tied.toml", "tied.json"] {
        let path = std::env::temp_dir().join(format!("hydrosysid-{}-{name}", std::process::id()));
        let text = ModelFile::of(&tied, &fit).to_text(&path).unwrap_or_else(|e| panic!("{e}"));
        std::fs::write(&path, text).expect("it can be written");
        let read = ModelFile::read(&path).unwrap_or_else(|e| panic!("{e}"));
        let model = read.model(&[], &path).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(model.parameter_of("quadratic_drag@heave"), model.parameter_of("quadratic_drag@sway"));
        assert_eq!(model.values(), fit.model.values());
        std::fs::remove_file(&path).expect("it is there");
    }
}
