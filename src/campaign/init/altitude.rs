//! A height above the bottom beside a depth: the altitude of a DVL is no depth where another log has one.

use super::reading::Understood;
use super::words;

/// Whether `z` is taken from a column that is called an altitude, and nobody has said so.
fn is_altitude(this: &Understood) -> bool {
    let named = this.options.columns.get("z").is_some_and(|source| {
        words::of(&source.name).words.iter().any(|word| ["altitude", "alt"].contains(&word.as_str()))
    });
    named && !this.given.columns.contains_key("z")
}

/// Takes altitudes back where another log has a depth.
pub fn settle(logs: &mut [Understood]) {
    let depth = |log: &Understood| log.log.as_ref().is_some_and(|l| l.signals.contains_key("z")) && !is_altitude(log);
    if !logs.iter().any(depth) {
        return;
    }
    for log in logs.iter_mut().filter(|log| is_altitude(log)) {
        if let Some(source) = log.options.columns.remove("z") {
            log.reasons.remove("columns.z");
            let text = format!("{:?} is a height above the bottom; another log has the depth", source.name);
            log.remarks.push(text);
        }
    }
}
