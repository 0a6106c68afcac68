//! Forces over time in `simulate --forces` and in the report: each term follows its formula, and
//! the total Newton's law.

#![allow(clippy::unwrap_used)] // tests, and the small functions they share

use std::path::{Path, PathBuf};
use std::process::Command;

use hydrosysid::campaign::{self, Campaign, FitOptions, LoadOptions, ModelFile};
use hydrosysid::frame::Dof;
use hydrosysid::log::{LogOptions, read};
use hydrosysid::report::{Block, Chart, Label, Origin};
use hydrosysid::report_content::{Results, document};
use hydrosysid::tank::{BlindOptions, write_blind};

/// A noise-free campaign of the tank in its own folder.
fn campaign(name: &str) -> (PathBuf, Campaign) {
    let folder = std::env::temp_dir().join(format!("hydrosysid-forces-{name}-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    write_blind(&folder, &BlindOptions { noise: 0.0, duration: 20.0, ..BlindOptions::default() }).unwrap();
    let campaign = Campaign::load(&folder.join("campaign.toml"), LoadOptions::default()).unwrap();
    (folder, campaign)
}

fn greatest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |m, x| m.max(x.abs()))
}

/// Columns of a file of forces: time, and values by name.
fn columns(file: &Path) -> (Vec<f64>, std::collections::BTreeMap<String, Vec<f64>>) {
    let log = read(file, &LogOptions::default(), &["t"]).unwrap();
    (log.time.to_vec(), log.signals.into_iter().map(|(name, s)| (name, s.values().to_vec())).collect())
}

#[test]
fn law_forces_add_up_to_the_total_at_every_sample() {
    let (folder, campaign) = campaign("command");
    let fit = campaign::fit(&campaign, FitOptions::default()).unwrap();
    let path = folder.join("model.toml");
    std::fs::write(&path, ModelFile::of(&campaign, &fit).to_text(&path).unwrap()).unwrap();
    let forces = folder.join("forces");
    let done = Command::new(env!("CARGO_BIN_EXE_hydrosysid"))
        .args(["simulate".as_ref(), folder.join("campaign.toml").as_os_str(), "--model".as_ref(), path.as_os_str()])
        .args(["--forces".as_ref(), forces.as_os_str(), "-q".as_ref()])
        .output()
        .unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let value = |name: String| fit.model.value(&name).unwrap();
    let mut files = 0;
    for run in &campaign.runs {
        for dof in [Dof::Surge, Dof::Sway, Dof::Yaw] {
            let file = forces.join(format!("{}_{dof}.csv", run.name.trim_end_matches(".csv")));
            let (time, table) = columns(&file);
            files += 1;
            let (velocity, total) = (&table[dof.velocity()], &table["total"]);
            assert_eq!(time.len(), run.signal(dof.velocity()).unwrap().len(), "{}", run.name);
            let size = table.values().map(|column| greatest(column)).fold(0.0, f64::max);
            let linear = value(format!("linear_drag@{dof}"));
            let quadratic = value(format!("quadratic_drag@{dof}"));
            for k in 0..time.len() {
                let terms = table.iter().filter(|(name, _)| *name != "total" && *name != dof.velocity());
                let sum: f64 = terms.map(|(_, force)| force[k]).sum();
                // sums of a handful of doubles
                assert!((sum - total[k]).abs() <= 1e-13 * size, "{} {dof}: {sum} {}", run.name, total[k]);
                let v = velocity[k];
                let drag = table[&format!("linear_drag@{dof}")][k] + table[&format!("quadratic_drag@{dof}")][k];
                let expected = -linear * v - quadratic * v * v.abs();
                assert!((drag - expected).abs() <= 1e-12 * size, "{} {dof}: {drag} {expected}", run.name);
            }
            // the integral of the total is the change of momentum; the tolerance is for trapezoids
            // of 0.1 s on motions of some seconds
            let steps = || (1..time.len()).map(|k| time[k] - time[k - 1]).enumerate();
            let brought: f64 = steps().map(|(k, h)| 0.5 * h * (total[k] + total[k + 1])).sum();
            let moved: f64 = steps().map(|(k, h)| 0.5 * h * (total[k].abs() + total[k + 1].abs())).sum();
            let momentum = value(format!("inertia@{dof}")) * (velocity[velocity.len() - 1] - velocity[0]);
            assert!((brought - momentum).abs() <= 0.01 * moved, "{} {dof}: {brought} {momentum}", run.name);
        }
    }
    assert_eq!(files, 3 * campaign.runs.len());
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn the_report_shows_the_forces_where_the_vehicle_moves() {
    let (folder, campaign) = campaign("report");
    let fit = campaign::fit(&campaign, FitOptions::default()).unwrap();
    let comparison = campaign::compare(&campaign, &fit.model, &fit.envelope).unwrap();
    let simulation = campaign::simulate(&campaign, &fit.model, &fit.envelope).unwrap();
    let results = Results {
        campaign: &campaign,
        fit: &fit,
        comparison: &comparison,
        simulation: &simulation,
        each_run: &campaign::each_run(&campaign, &fit),
        discovery: None,
        published: None,
    };
    let origin = Origin { version: String::new(), command: String::new(), inputs: Vec::new(), seed: None };
    let document = document(&results, origin);
    let section = document.sections.iter().find(|s| s.heading == "Forces").unwrap();
    let figures: Vec<_> = section
        .blocks
        .iter()
        .filter_map(|b| if let Block::Figure(figure) = b { Some(figure) } else { None })
        .filter(|figure| figure.title.ends_with(": forces"))
        .collect();
    assert!(!figures.is_empty(), "the longest run moves");
    for figure in figures {
        let Chart::Curves(curves) = &figure.chart else { panic!("{} is no curve", figure.title) };
        let named = |name: &str| curves.panels[0].series.iter().find(|s| s.name == Label::from(name));
        let total = named("total").unwrap();
        assert!(named("thrust").is_some() && total.y.len() > 100, "{}", figure.title);
        for (k, sum) in total.y.iter().enumerate() {
            let terms = curves.panels[0].series.iter().filter(|s| s.name != total.name);
            let terms: Vec<f64> = terms.map(|s| s.y[k]).collect();
            assert!((terms.iter().sum::<f64>() - sum).abs() <= 1e-12 * greatest(&terms).max(1.0), "{}", figure.title);
        }
    }
    std::fs::remove_dir_all(folder).unwrap();
}
