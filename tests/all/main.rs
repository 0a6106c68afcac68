//! All integration tests in one binary, which is linked once: one module for each topic.
//! `cargo test --test all NAME` runs those of a topic.

mod exported;
#[path = "../../benches/tables/findings"]
#[allow(dead_code)] // the page of the example shows more
mod findings_table {
    pub mod estimates;
    pub mod faults;
    pub mod judge;
    pub mod table;
}
mod ode_reference;
#[path = "../../examples/own_effect.rs"]
#[allow(dead_code)] // its `main`
mod own_effect_example;
mod served;
mod shared;
mod surge;
mod swim;
#[path = "../../benches/tables/staged/table.rs"]
#[allow(dead_code)] // the page of the example shows more
mod table;

mod adopt;
mod answers;
mod any_bytes;
mod at_the_top;
mod attitude;
mod badlogs;
mod bench_vehicle;
mod beyond_the_fit;
mod bollard_runs;
mod bollard_tables;
mod book;
mod campaign_file;
mod changed_logs;
mod check;
mod cli;
mod columns;
mod current;
mod discovery;
mod each_run;
mod endless;
mod escaping;
mod examples;
mod export;
mod export_c_header;
mod export_gazebo;
mod export_losses;
mod export_range;
mod export_tables;
mod export_thrusters;
mod export_urdf;
mod export_uuv;
mod findings;
mod forces;
mod glider;
mod half_a_sample;
mod heading_and_path;
mod heading_in_degrees;
mod held_commands;
mod identifiability;
mod init;
mod lacking;
mod late;
mod laws;
mod laws_of_motion;
mod log_faults;
mod log_kinds;
mod log_signatures;
mod log_spec;
mod monitor;
mod multirate;
mod new_logs;
mod nothing_estimated;
mod observe;
mod ode_ref;
mod ode_vehicle;
mod one_word;
mod output_error;
mod outputs;
mod paper;
mod periods_and_instants;
mod plan;
mod plant;
mod poses;
mod pushed;
mod refusals;
mod regressor;
mod report;
mod resampling;
mod results;
mod rooms;
mod same_numbers;
mod sampled_input;
mod six_degrees;
mod skipped;
mod staged;
mod stages;
mod strd;
mod t200;
mod terminal;
mod threads;
mod through_water;
mod tied_inertias;
mod ties;
mod told_in_other_words;
mod undriven;
mod unexcited;
mod unsettled;
mod upright;
mod velocity_sign;
mod view;
mod wiring;
