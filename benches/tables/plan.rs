//! Table of plans: predicted standard deviations compared with those that campaigns of the
//! independent plant reach.
//!
//! `cargo run --release --example plan -- [--campaigns N] [--seed S] [--write FILE]`
//!
//! The plant (`plant/`) shares no code with the planner. For each case it simulates a short
//! campaign, which is fitted as a user would do it, with estimated noise. From that fit a plan is
//! made that brings every parameter to 2 % of its value. The plant simulates the commands of the
//! plan N times, each time with another random force and other sensor noise, and each campaign is
//! fitted by itself. *Predicted* is the standard deviation that the plan predicts, *reached* the
//! root mean square of estimate − truth.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::time::Instant;

use hydrosysid::campaign::{self, Campaign, FitOptions, LoadOptions, Plan, PlanRequest, PlanSource, Want};
use hydrosysid::frame;
use hydrosysid_plant::{Campaign as Sea, Dof, RandomForce, Sailed, Suite, Vehicle};
use rayon::prelude::*;

type Failure = Box<dyn std::error::Error + Send + Sync>;

/// Wanted standard deviation, as a share of the value.
const WANTED: f64 = 0.02;

/// Random force as a share of the commanded one, and its correlation time, s.
const FORCE: RandomForce = RandomForce { share: 0.02, correlation: 1.0 };

/// Vehicle, noise of the sensors in units of the ordinary one, random force.
const CASES: [(&str, f64, RandomForce); 4] = [
    ("laurs", 1.0, RandomForce { share: 0.0, correlation: 0.0 }),
    ("laurs", 1.0, FORCE),
    ("laurs", 5.0, FORCE),
    ("small", 1.0, FORCE),
];

fn main() -> Result<(), Failure> {
    let arguments: Vec<String> = std::env::args().collect();
    let after = |name: &str| arguments.iter().position(|a| a == name).and_then(|k| arguments.get(k + 1));
    let campaigns: usize = after("--campaigns").map_or(Ok(100), |n| n.parse())?;
    let seed: u64 = after("--seed").map_or(Ok(20_260), |n| n.parse())?;
    let mut page = format!(
        "# Plans against campaigns of an independent simulator\n\nMade by `make plan` on the plant (`plant/`), which shares \
         no code with the planner: {campaigns} campaigns of each plan, seed {seed}. A plan asks for {:.0} % of every \
         parameter, from a fit of nine runs of 40 s, six of which train. *Predicted* is the deviation that the plan promised, *reached* the \
         root mean square of estimate − truth over the campaigns (by itself uncertain by {:.0} %), *covered* the share of \
         the fits' own 95 % intervals that cover the truth. All fits are by filter error, noise estimated.\n",
        100.0 * WANTED,
        100.0 / (2.0 * campaigns as f64).sqrt()
    );
    let mut ratios = Vec::new();
    for (k, (vehicle, noise, force)) in CASES.into_iter().enumerate() {
        let case = Case { vehicle, noise, force, seed: seed + 1000 * k as u64 };
        ratios.extend(case.run(campaigns, &mut page)?);
    }
    ratios.sort_by(f64::total_cmp);
    let (least, most) = (ratios[0], ratios[ratios.len() - 1]);
    writeln!(
        page,
        "\nReached over predicted, all parameters together: median {:.2}, from {least:.2} to {most:.2}.",
        ratios[ratios.len() / 2]
    )?;
    print!("{page}");
    if let Some(file) = after("--write") {
        std::fs::write(file, page)?;
    }
    Ok(())
}

/// A vehicle with its sensor noise and its random force.
struct Case {
    vehicle: &'static str,
    noise: f64,
    force: RandomForce,
    seed: u64,
}

/// Of each parameter in one campaign of a plan: estimate − truth, and the standard deviation that
/// the fit reports.
type Errors = BTreeMap<String, (f64, f64)>;

impl Case {
    fn sea(&self) -> Result<Sea, Failure> {
        let vehicle = Vehicle::named(self.vehicle).ok_or("the plant has no such vehicle")?;
        let instruments = Suite { noise: self.noise, ..Suite::default() }.instruments(&Dof::PLANE);
        Ok(Sea { instruments, force: self.force, seed: self.seed, ..Sea::new(vehicle, &Dof::PLANE) })
    }

    /// Writes the section of this case to the page; returns reached over predicted of each parameter.
    fn run(&self, campaigns: usize, page: &mut String) -> Result<Vec<f64>, Failure> {
        let known = Sea { runs: 9, duration: 40.0, ..self.sea()? }.sail()?;
        let (loaded, fit) = fitted(&known, &self.folder("known"))?;
        let rated = known.vehicle.rated;
        let limits = Dof::PLANE.iter().map(|dof| (dof_of(*dof), rated[dof.index()])).collect();
        let request = PlanRequest {
            wants: vec![Want { parameter: None, amount: WANTED, relative: true }],
            limits,
            without_known: true,
            ..PlanRequest::default()
        };
        let begin = Instant::now();
        let plan = campaign::plan(&PlanSource::of_fit(&loaded, &fit), &request, &|| ())?;
        let planned = begin.elapsed().as_secs_f64();
        // the random force is that of the known campaign, whatever the commands are
        let mut sea = self.planned(&known, &plan)?;
        sea.own_forces = self.as_strong(&known, &sea)?;
        let found: Vec<Errors> = (0..campaigns).into_par_iter().filter_map(|k| self.errors(&sea, k).ok()).collect();
        self.table(&plan, &known, planned, (&found, campaigns), page)
    }

    /// The campaign with the plan's commands and the vehicle of the known campaign.
    fn planned(&self, known: &Sailed, plan: &Plan) -> Result<Sea, Failure> {
        let given: Vec<Vec<(Dof, Vec<f64>)>> = plan
            .commands
            .iter()
            .map(|run| {
                let of = |dof: &Dof| Some((*dof, run.signal(dof.force())?.values().to_vec()));
                Dof::PLANE.iter().filter_map(of).collect()
            })
            .collect();
        let duration = plan.runs.iter().map(|run| run.length).fold(0.0, f64::max);
        let (runs, vehicle) = (given.len(), known.vehicle.clone());
        Ok(Sea { vehicle, spread: 0.0, given, runs, duration, ..self.sea()? })
    }

    /// Random forces for `sea`, as shares of its commands, that are as strong as those of `known`.
    fn as_strong(&self, known: &Sailed, sea: &Sea) -> Result<Vec<(Dof, RandomForce)>, Failure> {
        if self.force.share == 0.0 {
            return Ok(Vec::new());
        }
        let trial = sea.sail()?;
        let pairs = known.truth.force.iter().zip(&trial.truth.force);
        Ok(pairs
            .map(|(wanted, is)| {
                (wanted.dof, RandomForce { share: self.force.share * wanted.rms / is.rms, ..self.force })
            })
            .collect())
    }

    /// Simulates and fits campaign `k`.
    fn errors(&self, sea: &Sea, k: usize) -> Result<Errors, Failure> {
        let sailed = Sea { seed: self.seed + 1 + k as u64, ..sea.clone() }.sail()?;
        let folder = self.folder(&k.to_string());
        let (_, fit) = fitted(&sailed, &folder)?;
        std::fs::remove_dir_all(&folder)?;
        let own = fit.model.parameters.iter().filter_map(|p| {
            let truth = sailed.truth.value(&p.term)?;
            Some((p.term.clone(), (p.value - truth, p.std?)))
        });
        Ok(own.collect())
    }

    fn folder(&self, name: &str) -> PathBuf {
        let case = format!("hydrosysid-plan-{}-{}-{name}-{}", self.vehicle, self.seed, std::process::id());
        std::env::temp_dir().join(case)
    }

    fn table(
        &self,
        plan: &Plan,
        known: &Sailed,
        planned: f64,
        (found, campaigns): (&[Errors], usize),
        page: &mut String,
    ) -> Result<Vec<f64>, Failure> {
        let (noise, share) = (self.noise, 100.0 * self.force.share);
        writeln!(page, "\n## Vehicle `{}`, {noise} × the ordinary noise, random force of {share} %\n", self.vehicle)?;
        let names: Vec<&str> = plan.runs.iter().map(|run| run.name.as_str()).collect();
        writeln!(
            page,
            "Runs of {:.0} s, {} out of {} candidates, chosen in {planned:.1} s: {}. {} of {campaigns} fits failed.\n",
            plan.runs.first().map_or(0.0, |run| run.length),
            plan.runs.len(),
            plan.candidates,
            names.join(", "),
            campaigns - found.len()
        )?;
        writeln!(
            page,
            "| parameter | true | wanted | predicted | reached | reached/predicted | bias/predicted | covered |"
        )?;
        writeln!(page, "|---|--:|--:|--:|--:|--:|--:|--:|")?;
        let mut ratios = Vec::new();
        for p in &plan.parameters {
            let term = match p.dof {
                Some(dof) => format!("{}@{dof}", p.effect),
                None => p.effect.clone(),
            };
            let errors: Vec<(f64, f64)> = found.iter().filter_map(|errors| errors.get(&term).copied()).collect();
            let (Some(truth), Some(predicted), false) = (known.truth.value(&term), p.std, errors.is_empty()) else {
                continue;
            };
            let count = errors.len() as f64;
            let reached = (errors.iter().map(|(e, _)| e * e).sum::<f64>() / count).sqrt();
            let bias = errors.iter().map(|(e, _)| e).sum::<f64>() / count;
            let covered = errors.iter().filter(|(e, std)| e.abs() < 1.96 * std).count() as f64 / count;
            ratios.push(reached / predicted);
            writeln!(
                page,
                "| {} `{term}` | {truth:.4} | {:.2e} | {predicted:.2e} | {reached:.2e} | {:.2} | {:+.2} | {:.0} % |",
                p.name.replace('|', "\\|"),
                p.wanted.unwrap_or(f64::NAN),
                reached / predicted,
                bias / predicted,
                100.0 * covered
            )?;
        }
        Ok(ratios)
    }
}

fn fitted(sailed: &Sailed, folder: &Path) -> Result<(Campaign, campaign::Fit), Failure> {
    sailed.write(folder)?;
    let loaded = Campaign::load(&folder.join("campaign.toml"), LoadOptions::default())?;
    let fit = campaign::fit(&loaded, FitOptions::default())?;
    Ok((loaded, fit))
}

/// The degree of freedom of `hydrosysid` for that of the plant.
fn dof_of(dof: Dof) -> frame::Dof {
    frame::Dof::ALL[dof.index()]
}
