//! The report of a campaign contains every figure that its data allow, made from results only.

use std::path::{Path, PathBuf};

use hydrosysid::campaign::{self, Campaign, Estimator, FitOptions, LoadOptions, Published};
use hydrosysid::report::{Origin, render};
use hydrosysid::report_content::{Results, document, page_of};
use hydrosysid::tank::{BlindOptions, paper_campaign, write_blind};

struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Folder {
        let path = std::env::temp_dir().join(format!("hydrosysid-report-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&path);
        Folder(path)
    }

    fn campaign(&self) -> Campaign {
        Campaign::load(&self.0.join("campaign.toml"), LoadOptions::default()).expect("the tank's campaign loads")
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn holds(page: &str, titles: &[&str]) {
    for title in titles {
        assert!(page.contains(&format!("<span class=\"title\">{title}")), "no figure `{title}`");
    }
    assert!(page.len() < 2_000_000, "{} bytes", page.len());
    let body = page.split("id=\"figure-style\"").next().unwrap_or_default();
    assert!(!body.contains("NaN") && !body.contains(">inf<") && !body.contains(">−inf<"), "a number is broken");
    assert!(!body.contains('`'), "code stands between tags, not between backticks");
}

#[test]
fn a_staged_campaign_shows_towing_beside_propelled_and_the_load_cells() {
    let folder = Folder::new("staged");
    paper_campaign(1, 1.0).unwrap().write(&folder.0).unwrap();
    let page = page_of(&folder.campaign(), None, None, Origin::default()).unwrap();
    let titles = [
        "What the data can separate",
        "The same parameter from other sources",
        "Each run&#39;s own model on every run, surge",
        "Residuals against u",
        "Drag in surge",
        "Drag in yaw",
        "Added mass against the amplitude",
        "Nominal and actual thrust in surge",
    ];
    holds(&page, &titles);
    // the legend of Fig. 8 of the paper, and a stage together with single runs in the forest plot
    for source in
        ["towed", "propelled", "towed, means", "propelled, means", "load cell", "steady clockwise", "surge_1.csv"]
    {
        assert!(page.contains(&format!(">{source}</text>")), "{source}");
    }
}

#[test]
fn a_fit_of_free_motion_shows_noise_single_runs_and_published_values() {
    let folder = Folder::new("blind");
    write_blind(&folder.0, &BlindOptions { duration: 40.0, ..BlindOptions::default() }).unwrap();
    let campaign = folder.campaign();
    let text =
        "format = 1\nconvention = 'sname'\nsource = 'a book'\n[parameters]\n'X_u|u|' = { value = -300.0, std = 9.0 }\n";
    let published = Published::parse(text, Path::new("book.toml"), &campaign).unwrap();
    let page = page_of(&campaign, None, Some(&published), Origin::default()).unwrap();
    let titles = [
        "Noise of the sensors",
        "Whether prediction errors are as expected",
        "What the data can separate",
        "The same parameter from other sources",
        "Each run&#39;s own model on every run, yaw",
        "Residuals against r",
        "Drag in sway",
    ];
    holds(&page, &titles);
    assert!(page.contains(">published</text>") && page.contains("300.0 ± 9.0 kg/m"), "the book beside the estimate");
}

/// If the fit did not converge, every row of a free parameter is marked; if it did, none is.
#[test]
fn deviations_of_a_fit_that_did_not_converge_are_marked_where_they_stand() {
    let folder = Folder::new("unsettled");
    write_blind(&folder.0, &BlindOptions { duration: 20.0, ..BlindOptions::default() }).expect("it sails");
    let campaign = folder.campaign();
    let mut fit =
        campaign::fit(&campaign, FitOptions { estimator: Some(Estimator::Integral) }).expect("it can be fitted");
    let comparison = campaign::compare(&campaign, &fit.model, &fit.envelope).expect("it compares");
    let simulation = campaign::simulate(&campaign, &fit.model, &fit.envelope).expect("it simulates");
    let each_run = campaign::EachRun { format: 1, models: Vec::new(), crossed: Vec::new(), left_out: Vec::new() };
    let marked = |fit: &campaign::Fit| {
        let results = Results {
            campaign: &campaign,
            fit,
            comparison: &comparison,
            simulation: &simulation,
            each_run: &each_run,
            discovery: None,
            published: None,
        };
        render(&document(&results, Origin::default())).matches(">not converged<").count()
    };
    assert_eq!(marked(&fit), 0);
    fit.converged = false;
    assert_eq!(marked(&fit), fit.parameters.iter().filter(|p| !p.fixed).count());
}
