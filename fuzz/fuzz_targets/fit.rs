//! The whole way from bytes to parameters: a campaign, the line `#### log`, one log. Without that line all is the log,
//! and the campaign a planar vehicle. Whatever they hold: a fit of finite numbers, or an error that says why not.

#![no_main]

use std::path::Path;

use hydrosysid::campaign::file::{CampaignFile, ReadOptions};
use hydrosysid::campaign::{self, Campaign, Estimator, FitOptions};
use hydrosysid::log;
use hydrosysid::run::Run;
use hydrosysid_fuzz::within_memory;
use libfuzzer_sys::fuzz_target;

const PLANAR: &str = r#"
format = 1
[vehicle]
name = "fuzz"
mass = 189.0
volume = 0.19
[model]
dofs = ["surge", "sway", "yaw"]
effects = ["inertia", "linear_drag", "quadratic_drag", "coriolis_surge", "coriolis_sway"]
"#;
const MARK: &[u8] = b"\n#### log\n";

fuzz_target!(|data: &[u8]| within_memory(|| work(data)));

fn work(data: &[u8]) {
    let at = data.windows(MARK.len()).position(|w| w == MARK);
    let (text, bytes) = at.map_or((PLANAR.as_bytes(), data), |at| (&data[..at], &data[at + MARK.len()..]));
    let options = ReadOptions { look_for_files: false, ..ReadOptions::default() };
    let Ok(file) = CampaignFile::from_bytes(text, Path::new("campaign.toml"), &options) else { return };
    let needed = log::required(&file.model.dofs);
    let Ok(read) = log::read_from(bytes, "log.csv", &file.log, &needed) else { return };
    let kind = file.runs.first().map(|run| run.kind).unwrap_or_default();
    let run = Run { name: "log.csv".into(), kind, gaps: read.gaps, signals: read.signals, ..Run::default() };
    let Ok(loaded) = Campaign::from_runs(file, vec![run]) else { return };
    // what many steps are asked of takes long by right
    if bytes.len() > 1 << 14 {
        return;
    }
    for estimator in [Estimator::Integral, Estimator::OutputError, Estimator::Staged] {
        match campaign::fit(&loaded, FitOptions { estimator: Some(estimator) }) {
            Ok(fit) => assert!(fit.parameters.iter().all(|p| p.value.is_finite()), "{:?}", fit.parameters),
            Err(error) => assert!(!error.to_string().is_empty()),
        }
    }
}
