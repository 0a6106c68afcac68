//! The verb `discover`: what the campaign's baseline lacks, if anything.

use super::codes;
use super::error::Error;
use super::file::DiscoverTable;
use super::load::Campaign;
use crate::discover::{self, Discovery, SearchOptions};
use crate::finding::Finding;

/// Looks for what the baseline of a campaign lacks on its runs of free motion.
///
/// # Errors
/// [`Error`] when the baseline cannot be fitted or a run lacks what it reads.
pub fn discover(campaign: &Campaign) -> Result<Discovery, Error> {
    let table = &campaign.file.discover;
    let usual = DiscoverTable::default();
    let mut options = SearchOptions::default();
    // what the file does not ask for is left as the search was calibrated
    if table.level.to_bits() != usual.level.to_bits() {
        options.level = table.level;
    }
    if table.max_effects != usual.max_effects {
        options.most = table.max_effects;
    }
    let runs = campaign.motion(None);
    let fitting = &campaign.options.output_error;
    let mut found = discover::discover(&campaign.model, &runs, &campaign.candidates, fitting, &options)?;
    found.seed = table.seed.unwrap_or(campaign.options.seed);
    let told: Vec<_> = campaign.findings.iter().filter(|f| f.code != codes::NO_VALIDATION.code).cloned().collect();
    if table.families != usual.families {
        found.warnings.push(Finding::new(&codes::FAMILIES, codes::FAMILIES.meaning));
    }
    found.warnings.splice(0..0, told);
    Ok(found)
}
