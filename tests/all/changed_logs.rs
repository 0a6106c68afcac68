//! Logs of a campaign of the plant, changed after they were written.

use std::path::Path;

/// Replaces the text of every CSV in `folder` by what `change` makes of it.
pub fn change_logs(folder: &Path, change: impl Fn(&str) -> String) {
    for log in std::fs::read_dir(folder).expect("it was written").map(|entry| entry.expect("it is there").path()) {
        if log.extension().is_some_and(|kind| kind == "csv") {
            let text = std::fs::read_to_string(&log).expect("it was written");
            std::fs::write(&log, change(&text)).expect("it can be written");
        }
    }
}

/// `text` without the velocities ahead and across.
pub fn without_velocities(text: &str) -> String {
    let poses = text.replacen("u [m/s],v [m/s]", "nothing,nothing_either", 1);
    assert_ne!(text, poses, "the velocities have their columns");
    poses
}
