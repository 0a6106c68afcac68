//! The table of plans held against what simulated campaigns reach.
//!
//! `cargo run --release --example plan -- [--campaigns N] [--seed S] [--write FILE]`
//!
//! For each vehicle of the virtual tank a plan is proposed that brings every parameter to 3 % of its value; N campaigns
//! of its runs are simulated with noise and fitted from their own start. *Reached* is the root mean square of estimate −
//! truth.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::time::Instant;

use hydrosysid::estimate::output_error::OutputErrorOptions;
use hydrosysid::frame::Dof;
use hydrosysid::plan::{Course, GridOptions, PlanOptions, Wish, propose, rehearse, usual};
use hydrosysid::tank::{BlindOptions, CraftKind, blind};

/// Wanted deviation, as a share of the value.
const WANTED: f64 = 0.03;

/// Noise of the sensors in units of the ordinary one, and vehicle.
const CASES: [(CraftKind, f64); 3] = [(CraftKind::Large, 1.0), (CraftKind::Large, 5.0), (CraftKind::Small, 1.0)];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().collect();
    let after = |name: &str| arguments.iter().position(|a| a == name).and_then(|k| arguments.get(k + 1));
    let campaigns: usize = after("--campaigns").map_or(Ok(200), |n| n.parse())?;
    let seed: u64 = after("--seed").map_or(Ok(20_260), |n| n.parse())?;
    let mut page = format!(
        "# Plans against simulated campaigns\n\nWritten by `make plan`: {campaigns} campaigns of each plan, seed {seed}. \
         Wanted: {:.0} % of every parameter. *Predicted* is the plan's, *reached* the root mean square of estimate − \
         truth over the campaigns, *covered* the share of the fits' own 95 % intervals that hold the truth. Fits \
         are on segments of 8 s, not joined.\n",
        100.0 * WANTED
    );
    let mut worst: f64 = 1.0;
    for (craft, noise) in CASES {
        worst = worst.max(case(craft, noise, campaigns, seed, &mut page)?);
    }
    writeln!(page, "\nThe worst ratio of reached to predicted, or of predicted to reached, is {worst:.3}.")?;
    print!("{page}");
    if let Some(file) = after("--write") {
        std::fs::write(file, page)?;
    }
    Ok(())
}

/// One vehicle under one noise; the worst ratio.
fn case(
    craft: CraftKind,
    noise: f64,
    campaigns: usize,
    seed: u64,
    page: &mut String,
) -> Result<f64, Box<dyn std::error::Error>> {
    let made = blind(&BlindOptions { seed: 5, craft, duration: 20.0, ..BlindOptions::default() })?;
    let mut instruments = usual(&made.truth);
    for sensor in instruments.values_mut() {
        sensor.noise *= noise;
    }
    let length = made.vehicle.characteristic_length().unwrap_or(1.0);
    let course = Course { model: made.truth, instruments, length };
    let force = match craft {
        CraftKind::Large => [335.0, 170.0, 110.0],
        CraftKind::Small => [15.0, 11.0, 1.2],
    };
    let fitting = OutputErrorOptions::default();
    let options = PlanOptions {
        fitting: fitting.clone(),
        limits: BTreeMap::from([(Dof::Surge, force[0]), (Dof::Sway, force[1]), (Dof::Yaw, force[2])]),
        most: 12,
        grid: GridOptions { length: 60.0, ..GridOptions::default() },
        ..PlanOptions::default()
    };
    let wish = |p: usize| Wish { parameter: p, std: WANTED * course.model.parameters[p].value.abs() };
    let wishes: Vec<Wish> = course.model.free().into_iter().map(wish).collect();
    let begin = Instant::now();
    let plan = propose(&course, &wishes, &options)?;
    let planned = begin.elapsed();
    let (found, _) = rehearse(&course, &plan, &fitting, (campaigns, seed), &|| {});
    let name = format!("{craft:?}").to_lowercase();
    writeln!(page, "\n## The {name} vehicle, {noise} × the ordinary noise\n")?;
    writeln!(
        page,
        "Runs of 60 s, {} out of {} candidates, chosen in {:.1} s: {}. {} fits failed.\n",
        plan.runs.len(),
        plan.candidates,
        planned.as_secs_f64(),
        plan.runs.iter().map(|run| run.sailed.manoeuvre.name.clone()).collect::<Vec<_>>().join(", "),
        found.failed
    )?;
    writeln!(page, "| parameter | value | wanted | predicted | reached | ratio | bias/std | covered |")?;
    writeln!(page, "|---|--:|--:|--:|--:|--:|--:|--:|")?;
    let mut worst: f64 = 1.0;
    for p in &found.parameters {
        let told = &course.model.parameters[p.parameter];
        let wanted = WANTED * told.value.abs();
        worst = worst.max(p.ratio()).max(1.0 / p.ratio());
        writeln!(
            page,
            "| {} `{}` | {:.4} | {wanted:.3e} | {:.3e} | {:.3e} | {:.3} | {:+.2} | {:.1} % |",
            told.spec.name.replace('|', "\\|"),
            told.term,
            told.value,
            p.predicted,
            p.reached,
            p.ratio(),
            p.bias / p.predicted,
            100.0 * p.covered
        )?;
    }
    Ok(worst)
}
