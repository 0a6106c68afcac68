//! Fits the model of a campaign and says whether to believe it:
//!
//! ```text
//! cargo run --release --example fit -- demo/pool/hidden/campaign.toml
//! ```
//!
//! What `hydrosysid fit` prints, as a program of one's own would use it. The campaign is that of the README's demo, or yours.

use std::error::Error;
use std::path::Path;

use hydrosysid::campaign::{Campaign, FitOptions, LoadOptions, fit};

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("usage: fit CAMPAIGN.toml")?;
    let campaign = Campaign::load(Path::new(&path), LoadOptions::default())?;
    let found = fit(&campaign, FitOptions::default())?;

    println!("{}", found.sentence);
    for p in &found.parameters {
        // held parameters have no deviation
        let std = p.std.map_or(String::new(), |std| format!(" ± {std:.3}"));
        println!("{} {} = {:.3}{std} {}", p.effect, p.name, p.value, p.unit);
    }
    for warning in &found.warnings {
        println!("{warning}");
    }
    Ok(())
}
