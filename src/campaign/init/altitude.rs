//! Height above the bottom beside a depth: the altitude of a DVL is not read as depth if another
//! log has a depth.

use super::reading::Understood;
use super::words;

/// Whether `z` is read from a column that is called an altitude, and not because the user said so.
fn is_altitude(this: &Understood) -> bool {
    let named = this.options.columns.get("z").is_some_and(|source| {
        words::of(&source.name).words.iter().any(|word| ["altitude", "alt"].contains(&word.as_str()))
    });
    named && !this.given.columns.contains_key("z")
}

/// Removes `z` columns that are altitudes if another log has a depth.
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
