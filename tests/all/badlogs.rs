//! Odd and bad logs: every file of the corpus has the outcome that its index promises.

use std::path::Path;

use hydrosysid::finding::Finding;
use hydrosysid::log::options::Missing;
use hydrosysid::log::{self, LogFile, LogOptions, PLANAR};
use hydrosysid::run::Signal;
use serde_json::Value;

use crate::shared;

/// Compares the outcome of one file with the promise of the index.
fn judge(folder: &Path, name: &str, promise: &Value) -> Result<(), String> {
    let options: LogOptions = match promise.get("options") {
        Some(options) => serde_json::from_value(options.clone()).map_err(|e| e.to_string())?,
        None => LogOptions::default(),
    };
    let outcome = log::read(folder.join(name), &options, &PLANAR);
    let expect = promise["expect"].as_str().unwrap_or_default();
    let log = match (expect, outcome) {
        ("error", Err(e)) => {
            let first = e.findings().first().ok_or_else(|| format!("no finding: {e}"))?;
            return finding_is(first, &promise["error"], name);
        }
        ("error", Ok(_)) => return Err("accepted".into()),
        (_, Err(e)) => return Err(format!("refused: {e}")),
        (_, Ok(log)) => log,
    };
    for channel in log.signals.values() {
        if !channel.values().iter().chain(channel.time()).all(|x| x.is_finite()) {
            return Err("a value is not finite".into());
        }
    }
    if expect == "accept" && !log.warnings.is_empty() {
        return Err(format!("warns: {:?}", log.warnings));
    }
    if expect == "accept_with_warning" {
        let kind = promise["warning"]["kind"].as_str();
        let warning = log.warnings.iter().find(|w| Some(w.kind) == kind);
        let warning = warning.ok_or_else(|| format!("no {kind:?} among {:?}", log.warnings))?;
        finding_is(warning, &promise["warning"], name)?;
    }
    result_is(folder, &log, &promise["result"])
}

fn finding_is(finding: &Finding, promise: &Value, name: &str) -> Result<(), String> {
    let wrong = |what: &str| Err(format!("{what}: {finding:?}"));
    if Some(finding.kind) != promise["kind"].as_str() {
        return wrong("kind");
    }
    if promise.get("line").is_some() && finding.line != promise["line"].as_u64() {
        return wrong("line");
    }
    if promise.get("column").is_some() && finding.column.as_deref() != promise["column"].as_str() {
        return wrong("column");
    }
    let message = finding.message.to_lowercase();
    let strings = promise["message_contains"].as_array().into_iter().flatten().filter_map(Value::as_str);
    match strings.chain([name]).find(|s| !message.contains(&s.to_lowercase())) {
        Some(missing) => wrong(&format!("message lacks {missing:?}")),
        None => Ok(()),
    }
}

fn result_is(folder: &Path, log: &LogFile, promise: &Value) -> Result<(), String> {
    if let Some(rows) = promise["rows"].as_u64()
        && log.rows as u64 != rows
    {
        return Err(format!("{} rows", log.rows));
    }
    if let Some(segments) = promise["segments"].as_u64()
        && log.segments() as u64 != segments
    {
        return Err(format!("{} segments", log.segments()));
    }
    if let Some(dt) = promise["dt_median"].as_f64() {
        let step = log::check::time::usual_step(&log.time).unwrap_or(f64::NAN);
        let tolerance = promise["dt_tol"].as_f64().unwrap_or(0.0);
        if (step - dt).abs() > tolerance || log.time.windows(2).any(|w| (w[1] - w[0] - dt).abs() > tolerance) {
            return Err(format!("step {step}"));
        }
    }
    for column in promise["columns"].as_array().into_iter().flatten().filter_map(Value::as_str) {
        if column != "t" && !log.signals.contains_key(column) {
            return Err(format!("no {column}"));
        }
    }
    for (key, rtol) in [("equal_to", 0.0), ("close_to", promise["rtol"].as_f64().unwrap_or(0.0))] {
        let Some(other) = promise[key].as_str() else { continue };
        let good = log::read(folder.join(other), &LogOptions::default(), &PLANAR).map_err(|e| e.to_string())?;
        for name in PLANAR.into_iter().filter(|n| *n != "t") {
            let (a, b) = (&log.signals[name], &good.signals[name]);
            let close = |(x, y): (&f64, &f64)| x.to_bits() == y.to_bits() || (x - y).abs() <= rtol * y.abs();
            if a.len() != b.len() || !a.time().iter().zip(b.time()).chain(a.values().iter().zip(b.values())).all(close)
            {
                return Err(format!("{name} differs from {other}"));
            }
        }
    }
    Ok(())
}

#[test]
fn every_file_of_the_corpus_has_its_promised_outcome() {
    let Some(folder) = shared::path("badlogs") else { return };
    let index: Value = serde_json::from_str(&std::fs::read_to_string(folder.join("index.json")).unwrap()).unwrap();
    let mut wrong = Vec::new();
    for entry in index["files"].as_array().unwrap() {
        let name = entry["file"].as_str().unwrap();
        for (promise, which) in [(entry, "default"), (&entry["with_options"], "with options")] {
            if promise.is_object()
                && let Err(what) = judge(&folder, name, promise)
            {
                wrong.push(format!("{name}, {which}: {what}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// An accepted log, written and read again, is bit for bit the same, and writing it again gives the
/// same bytes.
#[test]
fn what_is_accepted_converts_without_loss() {
    let Some(folder) = shared::path("badlogs") else { return };
    let index: Value = serde_json::from_str(&std::fs::read_to_string(folder.join("index.json")).unwrap()).unwrap();
    let sparse = LogOptions { missing: Missing::NoSample, ..LogOptions::default() };
    let mut converted = 0;
    for entry in index["files"].as_array().unwrap() {
        let path = folder.join(entry["file"].as_str().unwrap());
        for options in [None, entry["with_options"].get("options")] {
            let options = options.map_or_else(LogOptions::default, |o| serde_json::from_value(o.clone()).unwrap());
            let Ok(read) = log::read(&path, &options, &[]) else { continue };
            let (mut bytes, mut again) = (Vec::new(), Vec::new());
            log::write_log(&read, &mut bytes).unwrap();
            let back = log::read_from(&bytes[..], "converted.csv", &sparse, &["t"]).unwrap();
            let bits = |log: &LogFile| -> Vec<(String, Vec<u64>)> {
                let of = |s: &Signal| s.time().iter().chain(s.values()).map(|x| x.to_bits()).collect();
                log.signals.iter().map(|(name, s)| (name.clone(), of(s))).collect()
            };
            assert_eq!(bits(&back), bits(&read), "{}", path.display());
            log::write_log(&back, &mut again).unwrap();
            assert!(bytes == again, "{}", path.display());
            converted += 1;
        }
    }
    assert!(converted >= 40, "{converted}");
}
