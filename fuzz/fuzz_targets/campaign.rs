//! The campaign file: whatever the bytes, a campaign that is written and read again as it is, or errors that each name
//! their place.

#![no_main]

use std::path::Path;

use hydrosysid::campaign::file::{CampaignFile, ReadOptions};
use hydrosysid_fuzz::within_memory;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| within_memory(|| read(data)));

fn read(data: &[u8]) {
    let options = ReadOptions { look_for_files: false, ..ReadOptions::default() };
    let path = Path::new("campaign.toml");
    match CampaignFile::from_bytes(data, path, &options) {
        Err(errors) => {
            assert!(!errors.errors.is_empty());
            assert!(errors.to_string().contains("campaign.toml"));
        }
        Ok(campaign) => {
            let text = campaign.to_toml().expect("what was read can be written");
            let again = CampaignFile::from_bytes(text.as_bytes(), path, &options).expect("and read");
            assert_eq!(CampaignFile { source: None, ..again }, CampaignFile { source: None, ..campaign });
        }
    }
}
