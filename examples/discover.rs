//! Searches for effects that the model of a campaign lacks:
//!
//! ```text
//! cargo run --release --example discover -- demo/pool/hidden/campaign.toml
//! ```
//!
//! It prints the verdict, the missing effects and the alternatives that the data also allow,
//! effects that improve the model but are not named, and the errors of the predictions of held-out
//! runs before and after.

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
