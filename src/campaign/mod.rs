//! A campaign: one vehicle, its runs, and what is asked of them.
//!
//! [`mod@file`] reads and writes its TOML file; [`Campaign`] is that file with its logs read, ready
//! for the analysis. Every verb is a plain function on it ([`fit()`], [`simulate()`], …) and
//! returns a result that serialises as its JSON; the command line and Python call the same
//! functions.

mod adopt;
mod baseline;
mod bench;
mod bench_command;
mod bench_vehicle;
mod between_rows;
mod check;
pub mod codes;
mod columns;
mod compare;
mod components;
mod derived;
mod difference;
mod discover;
mod each_run;
mod error;
mod examine;
mod examine_rows;
pub mod file;
mod first_samples;
mod fit;
mod forces;
mod heading;
mod identifiability;
mod inertia_amplitude;
mod init;
mod late_gyro;
mod lead_in;
mod load;
mod log_faults;
mod logs;
mod model_file;
mod model_noise;
mod monitor;
mod moves;
mod noise;
mod odd_run;
mod own_formulas;
mod plan;
mod plan_rehearsal;
mod plan_request;
mod plan_source;
mod prediction;
mod published;
mod reading;
mod resample;
mod reversed_thruster;
mod same_log;
mod scale;
mod simulate;
mod single_thrusters;
mod steps_as_lines;
mod stream;
mod thrusters;
mod unexcited;
mod vehicles;
mod vertical;
mod window;

pub use adopt::{AdoptError, Adoption, adopt, with_effects, with_input, with_training};
pub use bench::{Bench, BenchThruster, bench};
pub use bench_vehicle::{BenchVehicle, bench_vehicle};
pub use check::{Check, CheckedLog, check_campaign, check_logs};
pub use compare::{Comparison, compare, disagreements};
pub use components::{Components, RunComponents, components};
pub use difference::{Joint, ModelDifference, ParameterDifference, difference, difference_of};
pub use discover::discover;
pub use each_run::{Crossed, EachRun, OwnEstimate, OwnModel, each_run};
pub use error::Error;
pub use examine::examine;
pub use file::Estimator;
pub use fit::{Fit, FitOptions, FitParameter, FitStage, Residuals, described, filters, fit};
pub use forces::nominal;
pub use identifiability::{
    Believable, Correlation, Direction, Group, Identifiability, OtherLength, OtherWindow, ProfileOf,
};
pub use inertia_amplitude::{InertiaAgainstAmplitude, InertiaOfRun};
pub use init::{FirstRows, InitFacts, InitRequest, Learned, Scaffold, first_rows, holds_no_run, init};
pub use load::{Campaign, LoadOptions, Options, names as run_names};
pub use model_file::{ModelFile, ModelFileError, ModelParameter};
pub use model_noise::{ModelForce, ModelNoise, ModelSensor};
pub use monitor::{Monitored, monitor, new_logs};
pub use noise::{ForceFound, HeldBack, Noise, Predicted, SensorFound};
pub use plan::{Plan, PlannedParameter, PlannedRun, plan};
pub use plan_request::{PlanRequest, Want};
pub use plan_source::PlanSource;
pub use published::{Convention, Published, PublishedComparison, PublishedParameter, compare_published};
pub use reading::Reading;
pub use resample::{Refits, Resampler, Resampling, Scatter, resample};
pub use simulate::{Simulated, Simulation, simulate};
pub use single_thrusters::Own;
pub use stream::{fit_streamed, too_large_to_keep};
pub use thrusters::FittedCurve;
pub use vehicles::{KnownVehicle, SuitedModel, VehicleFile, known_vehicles, vehicle};
