//! The fit of a real log that no model follows well is where it says: at the top of its likelihood.

use std::process::Command;

use hydrosysid::campaign::{Campaign, LoadOptions};
use hydrosysid::estimate::filter_error::{FilterErrorOptions, cost_of, filter_error};
use hydrosysid::estimate::started;
use hydrosysid::model::Model;
use hydrosysid::run::Role;

use crate::shared;

/// The circles of a small surface craft. Steps of parameters and noise in turns stick there on the way, tens higher in −2 ln L than
/// the top.
#[test]
fn no_parameter_of_a_field_log_leads_higher() {
    let Some(log) = shared::path("realdata/usv-bad-log/derived/boat1_2_circle.csv") else { return };
    let own = std::env::temp_dir().join(format!("hydrosysid-at-the-top-{}", std::process::id()));
    let init = Command::new(env!("CARGO_BIN_EXE_hydrosysid")).arg("init").arg(&log).arg("-o").arg(&own).output();
    assert!(init.expect("the command starts").status.success());
    let campaign = Campaign::load(&own.join("campaign.toml"), LoadOptions::default());
    let _ = std::fs::remove_dir_all(&own);
    let campaign = campaign.expect("it is a campaign");
    let runs = campaign.motion(Some(Role::Train));
    let options = FilterErrorOptions { base: campaign.options.output_error.clone(), ..FilterErrorOptions::default() };
    let fit = filter_error(&started(&campaign.model, &runs), &runs, &options).expect("it can be fitted");
    assert!(fit.converged);
    let cost = |model: &Model| cost_of(model, &runs, (&fit.noise, fit.limit), &options).expect("the runs are whole");
    let here = cost(&fit.model);
    for (k, parameter) in fit.model.parameters.iter().enumerate().filter(|(_, p)| !p.fixed) {
        for by in [-1.0 / 3.0, 1.0 / 3.0] {
            let value = parameter.value + by * parameter.std.expect("it was estimated");
            if (parameter.min..=parameter.max).contains(&value) {
                let mut model = fit.model.clone();
                model.parameters[k].value = value;
                let fall = here - cost(&model);
                // at a top none falls, and the steps end where a hundredth is left
                println!("{} {by:.2}: {fall}", parameter.full_name());
                assert!(fall < 0.1, "{} {by:.2} deviations further: {fall}", parameter.full_name());
            }
        }
    }
}
