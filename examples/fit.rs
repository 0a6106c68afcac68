//! Fits the model of a campaign and prints the result with its verdict and warnings:
//!
//! ```text
//! cargo run --release --example fit -- demo/pool/hidden/campaign.toml
//! ```
//!
//! This is `hydrosysid fit` as a part of another program. The campaign is that of the README's
//! demo, or your own.

use std::error::Error;
use std::path::Path;

use hydrosysid::campaign::{Campaign, FitOptions, LoadOptions, fit};

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("usage: fit CAMPAIGN.toml")?;
    let campaign = Campaign::load(Path::new(&path), LoadOptions::default())?;
    let found = fit(&campaign, FitOptions::default())?;

    println!("{}", found.sentence);
    for p in &found.parameters {
        // fixed parameters have no standard deviation
        let std = p.std.map_or(String::new(), |std| format!(" ± {std:.3}"));
        println!("{} {} = {:.3}{std} {}", p.effect, p.name, p.value, p.unit);
    }
    for warning in &found.warnings {
        println!("{warning}");
    }
    Ok(())
}
