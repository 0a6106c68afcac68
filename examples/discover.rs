//! Names what the model of a campaign lacks:
//!
//! ```text
//! cargo run --release --example discover -- demo/pool/hidden/campaign.toml
//! ```
//!
//! The verdict, the effects that were missing with the others that these data allow, what helped and is no name, and how
//! far predictions of the runs that took no part are off before and after.

use std::error::Error;
use std::path::Path;

use hydrosysid::campaign::{Campaign, LoadOptions, discover};

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("usage: discover CAMPAIGN.toml")?;
    let campaign = Campaign::load(Path::new(&path), LoadOptions::default())?;
    let found = discover(&campaign)?;

    println!("{}", found.sentence);
    for effect in &found.effects {
        println!("missing: {}; these data also allow: {}", effect.id, effect.also_possible.join(", "));
    }
    for other in &found.behaves_like {
        println!("something {}", other.told());
    }
    for step in &found.gap {
        let errors: Vec<String> = step.held_out_rms.iter().map(|(of, rms)| format!("{of} {rms:.4}")).collect();
        println!("held-out error with {}: {}", step.added.as_deref().unwrap_or("the baseline"), errors.join(", "));
    }
    Ok(())
}
