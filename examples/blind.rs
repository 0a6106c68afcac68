//! The table of hits, misses and false names: discovery on campaigns in which effects are hidden.
//!
//! `cargo run --release --example blind -- [--seeds N] [--write FILE] [--only NAME]`
//!
//! Each row is a kind of campaign, judged over seeds and both vehicles. *Exact*: a member of the true class is named
//! for each hidden effect and nothing else. *Listed*: each hidden effect is named or stands in `also_possible`. Judged
//! are campaigns whose held-out gap, after the baseline's own best refit, is at least 1.5 times the noise in some degree
//! of freedom; the others count as too small to see. Intervals are Wilson's, 95 %.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::time::Instant;

use hydrosysid::discover::{Discovery, SearchOptions, Verdict, discover};
use hydrosysid::estimate::output_error::OutputErrorOptions;
use hydrosysid::tank::{Blind, BlindOptions, CraftKind, Hidden, blind};

/// Held-out gap over noise from which on an effect has to be found.
const VISIBLE: f64 = 1.5;

/// Effects hidden one at a time.
const SINGLE: &[&str] = &[
    "coriolis_yaw",
    "coriolis_surge",
    "coriolis_sway",
    "linear_drag@yaw",
    "quadratic_drag@sway",
    "cubic_drag@surge",
    "drag_asymmetry@surge",
    "coulomb_friction@surge",
    "mixed_drag@yaw:surge",
    "cross_drag@yaw:sway",
    "linear_cross_damping@yaw:sway",
    "added_mass_coupling@sway:yaw",
    "fluid_memory@surge",
    "bias@surge",
    "thrust_lag",
    "thrust_delay",
    "thrust_deadband@surge",
    "thrust_saturation@surge",
    "thrust_advance_loss@surge",
    "thrust_reverse_loss@surge",
    "thrust_interaction_loss@yaw",
    "thruster_fault@surge",
    "supply_voltage",
    "thrust_crosstalk@yaw:surge",
    "current",
    "tether_spring",
    "tether_drag@surge",
    "wave@surge",
    "sensor_gyro_bias",
    "sensor_gyro_scale",
    "sensor_compass_magnetic",
    "sensor_compass_deviation",
    "sensor_dvl_lever_arm",
    "sensor_dvl_misalignment",
    "sensor_dvl_scale",
];

/// Two at once, of different families.
const PAIRS: &[[&str; 2]] = &[
    ["coriolis_yaw", "thrust_lag"],
    ["current", "drag_asymmetry@surge"],
    ["tether_spring", "thrust_reverse_loss@surge"],
    ["thrust_delay", "cross_drag@yaw:sway"],
    ["sensor_dvl_lever_arm", "bias@surge"],
    ["coulomb_friction@surge", "sensor_gyro_bias"],
    ["thruster_fault@surge", "linear_drag@yaw"],
    ["supply_voltage", "mixed_drag@yaw:surge"],
];

/// In no catalogue, with the neighbouring forms that are right names for them.
const OUTSIDE: &[(&str, &[&str])] = &[
    ("vortex_shedding", &[]),
    ("sloshing", &["fluid_memory@surge"]),
    ("power_drag@surge", &["cubic_drag@surge", "linear_drag@surge", "coulomb_friction@surge"]),
];

/// What is asked of the command.
struct Arguments {
    seeds: u64,
    write: Option<String>,
    only: Option<String>,
}

fn arguments() -> Result<Arguments, String> {
    let mut found = Arguments { seeds: 20, write: None, only: None };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let mut value = || words.next().ok_or(format!("{word} needs a value"));
        match word.as_str() {
            "--seeds" => found.seeds = value()?.parse().map_err(|_| "--seeds takes a whole number".to_string())?,
            "--write" => found.write = Some(value()?),
            "--only" => found.only = Some(value()?),
            other => return Err(format!("unknown argument {other}: --seeds N, --write FILE, --only NAME")),
        }
    }
    Ok(found)
}

/// Counts of one row.
#[derive(Default)]
struct Row {
    campaigns: usize,
    judged: usize,
    exact: usize,
    listed: usize,
    false_names: usize,
    explained_wrongly: usize,
    closed: Vec<f64>,
    seconds: Vec<f64>,
    answers: BTreeMap<String, usize>,
}

impl Row {
    fn add(&mut self, campaign: &Blind, answer: &Discovery, allowed: &[&str], seconds: f64) {
        self.campaigns += 1;
        self.seconds.push(seconds);
        let gap = ratio(answer, 0);
        let names: Vec<&str> = answer.effects.iter().map(|e| e.id.as_str()).collect();
        let class = |hidden: &str, k: usize| {
            let effect = &answer.effects[k];
            effect.id == hidden
                || effect.also_possible.iter().any(|n| n == hidden)
                || allowed.contains(&effect.id.as_str())
        };
        let matched = campaign.hidden.iter().filter(|h| (0..names.len()).any(|k| class(h, k))).count();
        let wrong = (0..names.len()).filter(|k| !campaign.hidden.iter().any(|h| class(h, *k))).count();
        if !campaign.hidden.is_empty() && gap < VISIBLE {
            return;
        }
        self.judged += 1;
        let exact = matched == campaign.hidden.len() && wrong == 0 && names.len() <= campaign.hidden.len();
        self.exact += usize::from(exact);
        self.listed += usize::from(matched == campaign.hidden.len());
        self.false_names += wrong;
        self.explained_wrongly += usize::from(wrong > 0 && answer.verdict == Verdict::Explained);
        if gap > 3.0 {
            let last = ratio(answer, answer.gap.len() - 1);
            self.closed.push(((gap - last) / (gap - 1.0)).min(1.0));
        }
        if !exact {
            let listed = if names.is_empty() { format!("{:?}", answer.verdict) } else { names.join(" + ") };
            *self.answers.entry(listed).or_default() += 1;
        }
    }

    fn print(&self, name: &str) -> String {
        let share = |n: usize| {
            let (low, high) = wilson(n, self.judged);
            format!("{n}/{} ({:.0}–{:.0} %)", self.judged, 100.0 * low, 100.0 * high)
        };
        let mut answers: Vec<_> = self.answers.iter().collect();
        answers.sort_by(|a, b| b.1.cmp(a.1));
        let other = answers.iter().take(3).map(|(n, c)| format!("{c}× {n}")).collect::<Vec<_>>().join("; ");
        format!(
            "| {name} | {} | {} | {} | {} | {} | {:.2} | {other} |\n",
            self.campaigns,
            share(self.exact),
            share(self.listed),
            self.false_names,
            median(&self.closed).map_or("–".into(), |c| format!("{:.0} %", 100.0 * c)),
            median(&self.seconds).unwrap_or(0.0),
        )
    }

    fn absorb(&mut self, other: &Row) {
        self.campaigns += other.campaigns;
        self.judged += other.judged;
        self.exact += other.exact;
        self.listed += other.listed;
        self.false_names += other.false_names;
        self.explained_wrongly += other.explained_wrongly;
        self.closed.extend(&other.closed);
        self.seconds.extend(&other.seconds);
    }
}

/// Largest held-out gap over noise after step `k`.
fn ratio(answer: &Discovery, k: usize) -> f64 {
    let step = &answer.gap[k];
    step.held_out_rms.iter().map(|(dof, rms)| rms / step.noise_floor[dof]).fold(0.0, f64::max)
}

fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied()
}

/// Wilson's 95 % interval of a share.
fn wilson(hits: usize, of: usize) -> (f64, f64) {
    if of == 0 {
        return (0.0, 1.0);
    }
    let (n, z) = (of as f64, 1.96f64);
    let p = hits as f64 / n;
    let centre = (p + z * z / (2.0 * n)) / (1.0 + z * z / n);
    let half = z / (1.0 + z * z / n) * (p * (1.0 - p) / n + z * z / (4.0 * n * n)).sqrt();
    ((centre - half).max(0.0), (centre + half).min(1.0))
}

/// Runs one row: all seeds, both vehicles.
fn row(seeds: u64, allowed: &[&str], options: impl Fn(u64, CraftKind) -> BlindOptions) -> Row {
    let mut row = Row::default();
    for craft in [CraftKind::Large, CraftKind::Small] {
        for seed in 1..=seeds {
            let campaign = match blind(&options(seed, craft)) {
                Ok(campaign) => campaign,
                Err(reason) => {
                    eprintln!("seed {seed}: {reason}");
                    continue;
                }
            };
            let Ok(model) = campaign.model() else { continue };
            let fitting = OutputErrorOptions { position: true, ..OutputErrorOptions::default() };
            let begin = Instant::now();
            match discover(&model, &campaign.runs, &[], &fitting, &SearchOptions::default()) {
                Ok(answer) => row.add(&campaign, &answer, allowed, begin.elapsed().as_secs_f64()),
                Err(reason) => eprintln!("seed {seed}: {reason}"),
            }
        }
    }
    row
}

fn hidden(names: &[&str], size: f64) -> Vec<Hidden> {
    names.iter().map(|n| Hidden::new(*n, size)).collect()
}

fn main() -> Result<(), String> {
    let asked = arguments()?;
    let seeds = asked.seeds;
    let wanted = |name: &str| asked.only.as_ref().is_none_or(|only| name.contains(only.as_str()));
    let heading = "| hidden | campaigns | exact | named or listed | false names | gap closed | s | otherwise |\n\
                   |---|---|---|---|---|---|---|---|\n";
    let mut text = format!(
        "# Discovery on campaigns in which effects are hidden\n\nMade by `make blind`, {seeds} seeds a vehicle, two \
         vehicles. How a row is judged: the heading of `examples/blind.rs`.\n"
    );
    let mut section = |title: &str, rows: Vec<(String, Row)>| {
        if rows.is_empty() {
            return;
        }
        let mut pooled = Row::default();
        let _ = write!(text, "\n## {title}\n\n{heading}");
        for (name, row) in &rows {
            text += &row.print(name);
            pooled.absorb(row);
        }
        text += &pooled.print("**all**");
        let _ = writeln!(
            text,
            "\nWrong name with the verdict `explained`: {} of {}.",
            pooled.explained_wrongly, pooled.judged
        );
        eprintln!("{title}: done");
    };
    let base = |seed, craft| BlindOptions { seed, craft, ..BlindOptions::default() };
    let mut rows = Vec::new();
    for (name, colour, disturbance) in
        [("white noise", 0.0, 0.0), ("coloured noise, 0.8", 0.8, 0.0), ("random force", 0.0, 0.02)]
    {
        if wanted("null") {
            let options = |s, c| BlindOptions { colour, disturbance, ..base(s, c) };
            rows.push((name.to_string(), row(seeds, &[], options)));
        }
    }
    section("Nothing hidden: every name is a false alarm", rows);
    let single = |size: f64| {
        let rows = SINGLE.iter().filter(|n| wanted(n));
        rows.map(|n| {
            let found = row(seeds, &[], |s, c| BlindOptions { hidden: hidden(&[n], size), ..base(s, c) });
            eprintln!("{}", found.print(n).trim_end());
            ((*n).to_string(), found)
        })
        .collect::<Vec<_>>()
    };
    section("One effect, size 1", single(1.0));
    section("One effect, size 0.3", single(0.3));
    let pairs = PAIRS.iter().filter(|p| wanted(&p.join(" + ")));
    let pairs =
        pairs.map(|p| (p.join(" + "), row(seeds, &[], |s, c| BlindOptions { hidden: hidden(p, 1.0), ..base(s, c) })));
    section("Two effects", pairs.collect());
    let outside = OUTSIDE.iter().filter(|(n, _)| wanted(n));
    let outside = outside.map(|(n, allowed)| {
        ((*n).to_string(), row(seeds, allowed, |s, c| BlindOptions { hidden: hidden(&[n], 1.0), ..base(s, c) }))
    });
    section("Not in the catalogue (a neighbouring form counts as right)", outside.collect());
    match asked.write {
        Some(path) => std::fs::write(&path, text).map_err(|e| format!("{path}: {e}")),
        None => {
            println!("{text}");
            Ok(())
        }
    }
}
