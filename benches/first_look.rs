//! Time from a switch of an effect on the page to the fit and overlay that follow:
//! `cargo bench --bench first_look`.
//!
//! It is given as a multiple of the time of a simulation of the same runs, so that it does not
//! depend on the machine. The quickest of several is taken, since the campaign's own estimator
//! starts while the first look is read. The bench also asserts a limit; it does so among the tests
//! too, where nothing else runs at the same time.

// the tests of the page use more of it
#[allow(dead_code)]
#[path = "../tests/all/served.rs"]
mod served;

use std::time::Instant;

use hydrosysid::campaign::{Campaign, Estimator, FitOptions, LoadOptions, fit, simulate};
use hydrosysid::tank::{BlindOptions, Hidden, write_blind};
use serde_json::json;

use served::Served;

/// Maximum time of a first look with its overlay, in simulations of all runs.
const SIMULATIONS: f64 = 20.0;

fn main() {
    let options =
        BlindOptions { hidden: vec![Hidden::new("coriolis_yaw".to_string(), 1.0)], ..BlindOptions::default() };
    let served = Served::new("bench", |folder| {
        write_blind(folder, &options).expect("the tank sails");
    });
    let campaign = Campaign::load(&served.folder.join("campaign.toml"), LoadOptions::default()).expect("it loads");
    let fitted = fit(&campaign, FitOptions { estimator: Some(Estimator::Integral) }).expect("it fits");
    let (mut follows, mut simulates) = (f64::INFINITY, f64::INFINITY);
    for switched in [true, false, true, false] {
        served.done("/api/effect", &json!({"name": "bias@yaw", "on": switched}));
        let looked = served.looked();
        served.done("/api/stop", &json!({"name": "fit"}));
        follows = f64::min(follows, looked["seconds"].as_f64().expect("it says how long it took"));
        let begun = Instant::now();
        simulate(&campaign, &fitted.model, &fitted.envelope).expect("it is simulated");
        simulates = f64::min(simulates, begun.elapsed().as_secs_f64());
    }
    let simulations = follows / simulates;
    println!("a first look: {simulations:.1} simulations of its runs, at most {SIMULATIONS}");
    assert!(simulations < SIMULATIONS, "{follows} s, a simulation {simulates} s: {simulations}");
}
