//! The fit of a real log that no model describes well is at the maximum of its likelihood.

use std::process::Command;

use hydrosysid::campaign::{Campaign, LoadOptions};
use hydrosysid::estimate::filter_error::{FilterErrorOptions, cost_of, filter_error};
use hydrosysid::estimate::started;
use hydrosysid::model::Model;
use hydrosysid::run::Role;

use crate::shared;

/// Circles of a small surface craft: a change of any parameter by a third of its standard deviation
/// lowers −2 ln L by less than 0.1. Alternating steps of parameters and noise get stuck on the way,
/// at −2 ln L tens above the optimum.
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
                // at the optimum no change lowers the cost; the iteration ends with about 0.01 left
                println!("{} {by:.2}: {fall}", parameter.full_name());
                assert!(fall < 0.1, "{} {by:.2} deviations further: {fall}", parameter.full_name());
            }
        }
    }
}
