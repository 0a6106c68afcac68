//! What a switch of an effect costs on the page until fit and overlay follow: `cargo bench --bench first_look`.
//!
//! In simulations of the same runs beside it: a number that does not depend on the machine. The quickest of several, since
//! the campaign's own estimator begins to work while the first look is read. It is a check as well, in the tests too, where
//! nothing else runs beside it.

// the tests of the page use more of it
#[allow(dead_code)]
#[path = "../tests/all/served.rs"]
mod served;

use std::time::Instant;

use hydrosysid::campaign::{Campaign, Estimator, FitOptions, LoadOptions, fit, simulate};
use hydrosysid::tank::{BlindOptions, Hidden, write_blind};
use serde_json::json;

use served::Served;

/// Most simulations of all runs whose time a first look may take, its overlay included.
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
