//! Axes of a DVL in a table of ROS messages: its own (forward, starboard, down) or those of ROS
//! (forward, port, up).
//!
//! ```text
//! k = Σ Δz ∫w / Σ (∫w)²        k ≈ 1: w is down;  k ≈ −1: w is up
//! ```
//!
//! The depth z of any log over the same time decides.

use super::reading::Understood;
use super::ros;
use super::values::{STEP, ratio};
use crate::log::LogOptions;
use crate::log::options::BodyFrame;
use crate::run::Signal;

/// Sets the axes of the velocities, or remarks which ones are assumed.
pub fn settle(logs: &mut [Understood]) {
    for k in 0..logs.len() {
        let Some(field) = ros::of_dvl(&logs[k].headers).map(str::to_string) else { continue };
        let usual = LogOptions::default().body_frame;
        let has = logs[k].log.as_ref().is_some_and(|log| log.signals.contains_key("w"));
        if !has || logs[k].options.body_frame != usual || logs[k].given.body_frame != usual {
            continue;
        }
        let told = logs.iter().find_map(|other| turns(&logs[k], other).map(|turns| (turns, other.shown.clone())));
        match told {
            Some((turns, shown)) if turns < 0.0 => {
                logs[k].options.body_frame = BodyFrame::Flu;
                let why =
                    format!("{field:?} decreases where the depth of {shown} grows: forward, port, up, the axes of ROS");
                logs[k].guess("body_frame", why);
            }
            Some((_, shown)) => {
                let why = format!("{field:?} grows with the depth of {shown}: forward, starboard, down");
                logs[k].remarks.push(format!("guessed: body_frame = \"frd\": {why}"));
            }
            None => logs[k].remarks.push(format!(
                "guessed: body_frame = \"frd\", with doubt: {field:?} and the like are assumed to be in the axes of a \
                 DVL, forward, starboard, down (body_frame = \"flu\" if they are those of ROS: forward, port, up)"
            )),
        }
    }
}

/// The ratio k: change of the depth in `other` over the integral of w in `this`, over the time that
/// both cover.
fn turns(this: &Understood, other: &Understood) -> Option<f64> {
    let (own, other) = (this.log.as_ref()?, other.log.as_ref()?);
    let (w, z) = (own.signals.get("w")?, other.signals.get("z")?);
    let ahead = match (own.origin, other.origin) {
        (Some(own), Some(other)) => other - own,
        (None, None) => 0.0,
        _ => return None,
    };
    let time: Vec<f64> = z.time().iter().map(|t| t + ahead).collect();
    ratio(&Signal::new(time.into(), z.values().to_vec()), w, 1.0, STEP)
}
