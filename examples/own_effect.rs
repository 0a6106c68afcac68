//! A user-defined effect, in a fit and in a search:
//!
//! ```text
//! cargo run --release --example own_effect
//! ```
//!
//! A vehicle near the surface makes waves: in addition to its quadratic drag there is a drag with
//! the fourth power of the speed. The effect is a formula, which the fit, the simulator and the
//! search use. The logs are simulated here without the library.

use std::error::Error;
use std::sync::Arc;

use hydrosysid::discover::{Discovery, SearchOptions, discover};
use hydrosysid::effects::{About, Coriolis, Effect, Family, Instant, ParameterSpec, Place, Scope, Six};
use hydrosysid::estimate::filter_error::{FilterErrorFit, FilterErrorOptions, filter_error};
use hydrosysid::frame::Dof;
use hydrosysid::model::{Interpolation, Model};
use hydrosysid::run::{Role, Run, Signal};
use hydrosysid::symbolic::Expr;
use hydrosysid::units::Dimension;

/// `X −= d u³ |u|`.
#[derive(Debug)]
struct WaveDrag;

impl Effect for WaveDrag {
    fn about(&self) -> About<'_> {
        About {
            id: "wave_drag",
            family: Family::Body,
            scope: Scope::Each(&[Dof::Surge]),
            formula: "−d u³ |u|",
            meaning: "Drag of the waves that a vehicle near the surface makes.",
            source: "this example",
            shown_by: "high speed",
        }
    }

    fn parameters(&self, _: Place) -> Vec<ParameterSpec> {
        // at least 0: drag dissipates power
        vec![ParameterSpec::linear("d_wave", Dimension::FORCE.over(Dimension::VELOCITY.power(4))).at_least(0.0)]
    }

    fn wrench<'g>(&self, at: &Instant<'g>, _: Place, theta: &[Expr<'g>], _: &[Expr<'g>], wrench: &mut Six<'g>) {
        let u = at.nu_r[0];
        wrench[0] -= theta[0] * u * u * u * u.abs();
    }
}

/// A log of 60 s at 10 Hz: 12 u̇ = τ − 8 u|u| − 6 u³|u| in steps of 1 ms, with the speed rounded to 1 mm/s.
fn logged(name: &str, role: Role, pace: f64) -> Run {
    let time: Vec<f64> = (0..600).map(|k| 0.1 * f64::from(k)).collect();
    let command = |t: f64| 14.0 * (pace * t).sin() + 6.0 * (2.7 * pace * t).cos();
    let mut u = 0.0_f64;
    let speed = time.iter().map(|t| {
        let now = (1000.0 * u).round() / 1000.0;
        for k in 0..100 {
            let tau = command(t + 0.001 * f64::from(k));
            u += 0.001 * (tau - 8.0 * u * u.abs() - 6.0 * u.powi(3) * u.abs()) / 12.0;
        }
        now
    });
    let speed: Vec<f64> = speed.collect();
    let tau: Vec<f64> = time.iter().map(|t| command(*t)).collect();
    let mut run = Run { name: name.into(), role, ..Run::default() };
    run.signals.insert("u".into(), Signal::new(time.clone().into(), speed));
    run.signals.insert("tau_u".into(), Signal::new(time.into(), tau));
    run
}

/// The result of a search over two runs and a held-out one, and of a fit with the effect in the model.
///
/// # Errors
/// Those of the model, the search and the fit.
pub fn found_and_fitted() -> Result<(Discovery, FilterErrorFit), Box<dyn Error>> {
    let runs =
        [logged("slow", Role::Train, 0.2), logged("quick", Role::Train, 0.45), logged("held out", Role::Validate, 0.3)];
    let mut model = Model::with_effects(&[Dof::Surge], Coriolis::Tied, &["inertia", "linear_drag", "quadratic_drag"])?;
    model.input = Interpolation::Linear;
    let options = FilterErrorOptions::default();

    // the user-defined effect is a candidate in addition to those of the catalogue
    let own: (Arc<dyn Effect>, Place) = (Arc::new(WaveDrag), Place::at(Dof::Surge));
    let found = discover(&model, &runs, std::slice::from_ref(&own), &options, &SearchOptions::default())?;

    model.add(own.0, own.1)?;
    Ok((found, filter_error(&model, &runs[..2], &options)?))
}

fn main() -> Result<(), Box<dyn Error>> {
    let (found, fit) = found_and_fitted()?;
    println!("{}", found.sentence);
    for p in &fit.model.parameters {
        println!("{} {} = {:.3} ± {:.3}", p.term, p.spec.name, p.value, p.std.unwrap_or(f64::NAN));
    }
    Ok(())
}
