//! A new log is read like the log of the same name in the fit, or else like the campaign's logs
//! with the same columns.

use std::path::{Path, PathBuf};

use hydrosysid::campaign::file::{CampaignFile, ReadOptions};
use hydrosysid::campaign::{ModelFile, Reading, new_logs};

use crate::exported::planar;

/// A planar log, two of whose columns have names that the library does not know.
fn log() -> String {
    let row = |k: usize| {
        let t = 0.1 * k as f64;
        format!(
            "{t:.1},{:.4},{:.4},{:.4},{:.3},0,0\n",
            0.5 + 0.1 * t.sin(),
            0.1 * t.cos(),
            0.2 * t.sin(),
            20.0 * t.cos()
        )
    };
    "clock,ahead,v,r,tau_u,tau_v,tau_r\n".to_string() + &(0..200).map(row).collect::<String>()
}

/// A campaign of three logs, the last with the opposite sign of surge; each run has its own columns.
fn campaign(folder: &Path) -> CampaignFile {
    std::fs::create_dir_all(folder).expect("the folder can be made");
    let mut text =
        "format = 1\n[vehicle]\nmass = 200.0\n[model]\ndofs = ['surge', 'sway', 'yaw']\neffects = ['inertia']\n"
            .to_string();
    for (name, sign) in [("a.csv", 1), ("b.csv", 1), ("c.csv", -1)] {
        std::fs::write(folder.join(name), log()).expect("the log is written");
        text += &format!(
            "[[run]]\nfile = '{name}'\n[run.log.columns]\nt = 'clock'\nu = {{ name = 'ahead', sign = {sign} }}\n"
        );
    }
    let read = ReadOptions::default();
    CampaignFile::from_bytes(text.as_bytes(), &folder.join("campaign.toml"), &read).expect("a campaign")
}

fn folder(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name)
}

/// The model file that a fit of that campaign writes, read again.
fn model() -> ModelFile {
    let columns = |sign: i32| {
        format!("columns = {{ t = 'clock', u = {{ name = 'ahead', sign = {sign} }} }}")
            .parse::<toml::Table>()
            .expect("options")
    };
    let way = |files: &[&str], sign: i32| Reading {
        files: files.iter().map(|f| (*f).to_string()).collect(),
        log: columns(sign).try_into().expect("options"),
    };
    let file = ModelFile { readings: vec![way(&["a.csv", "b.csv"], 1), way(&["c.csv"], -1)], ..planar(&[]) };
    let path = Path::new("model.toml");
    let text = file.to_text(path).expect("a text");
    let again = ModelFile::from_text(&text, path).expect("its own text");
    assert_eq!(again, file);
    again
}

#[test]
fn a_log_is_read_as_that_of_its_name_was_and_else_as_most_with_its_columns() {
    let folder = folder("new_logs");
    let campaign = campaign(&folder);
    std::fs::write(folder.join("new.csv"), log()).expect("the log is written");
    let model = model();
    for like in [None, Some(&campaign)] {
        let forward = |name: &str| {
            let path = folder.join(name);
            let read = new_logs(&model, &[&path], None, like).unwrap_or_else(|e| panic!("{name}: {e}"));
            let doubts: Vec<String> =
                read.findings.iter().filter(|f| f.code == "M230").map(|f| f.message.clone()).collect();
            (read.runs[0].signal("u").expect("it is read").values()[0], doubts)
        };
        assert_eq!(forward("b.csv"), (0.5, Vec::new()));
        assert_eq!(forward("c.csv"), (-0.5, Vec::new()));
        let (value, doubts) = forward("new.csv");
        assert!((value - 0.5).abs() < 1e-12 && doubts.len() == 1, "{doubts:?}");
        assert!(doubts[0].contains("a.csv") && doubts[0].contains("c.csv") && doubts[0].contains("(u)"), "{doubts:?}");
    }
}

/// The message names the column of the campaign that the log lacks, not a missing `t`.
#[test]
fn a_log_with_other_columns_is_refused_by_those_of_the_campaign() {
    let folder = folder("new_logs_other");
    let campaign = campaign(&folder);
    std::fs::write(folder.join("other.csv"), log().replace("ahead", "forward")).expect("the log is written");
    let refused = new_logs(&model(), &[&folder.join("other.csv")], None, Some(&campaign)).expect_err("no such column");
    assert!(refused.to_string().contains("columns.u = 'ahead' is not in the header"), "{refused}");
}

/// Options that the user types replace those of the campaign.
#[test]
fn options_that_are_typed_win_over_those_of_the_campaign() {
    let folder = folder("new_logs_typed");
    let campaign = campaign(&folder);
    let typed = toml::from_str("columns = { t = 'clock', u = { name = 'ahead', scale = 2.0 } }").expect("options");
    let read = new_logs(&model(), &[&folder.join("c.csv")], Some(&typed), Some(&campaign)).expect("it is read");
    assert!((read.runs[0].signal("u").expect("it is read").values()[0] - 1.0).abs() < 1e-12);
    // findings on the model come before those on the log
    let unsettled = ModelFile { converged: false, ..model() };
    assert_eq!(read.under_model(&unsettled, "model.toml").findings[0].code, "M130");
}
