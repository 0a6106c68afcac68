//! A run in which a command has the opposite sign of what it has in the others: a wire that was turned for a day.
//!
//! ```text
//! τ → −τ   in the run by which it acts the wrong way, where more runs say the right way, and where the search then leaves nothing
//! ```
//!
//! A controller that moves the command looks like that, too: so the likelihood decides, and only where something is left without it.

use super::load::Campaign;
use super::log_faults::{Fault, reports};
use crate::check::{codes::SIGN_DISAGREES, together};
use crate::discover::LogFinding;
use crate::frame::Dof;
use crate::run::Run;

/// A force whose sign is another one in one run.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct OddRun {
    run: String,
    channel: String,
}

impl OddRun {
    /// Those that the checks of the logs accuse, by fewer runs than find the sign right.
    pub fn accused(campaign: &Campaign, runs: &[Run]) -> Vec<OddRun> {
        // what is wrong with a force that thrusters make is wrong with one of them
        if !campaign.file.thrusters.is_empty() {
            return Vec::new();
        }
        let mut reports = reports(runs, &campaign.model);
        together::weigh(&mut reports, &[]);
        let is_force = |channel: &String| Dof::ALL.iter().any(|dof| dof.force() == channel.as_str());
        let told = reports.into_iter().flat_map(|report| report.findings);
        let odd = told.filter(|finding| finding.code == SIGN_DISAGREES.code);
        odd.filter_map(|finding| Some(OddRun { run: finding.run?, channel: finding.column.filter(is_force)? }))
            .collect()
    }

    /// Turns the channel in its run; the files stay as they are.
    pub fn mend(&self, runs: &mut [Run]) {
        let fault = Fault::Factor { channel: self.channel.clone(), factor: -1.0 };
        runs.iter_mut().filter(|run| run.name == self.run).for_each(|run| fault.mend(std::slice::from_mut(run)));
    }

    /// The fault as the discovery tells it.
    pub fn finding(&self) -> LogFinding {
        LogFinding { kind: "sign".into(), channel: self.channel.clone(), factor: -1.0, message: self.to_string() }
    }
}

impl std::fmt::Display for OddRun {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let OddRun { run, channel } = self;
        write!(f, "in {run} {channel} acts the wrong way, and in the other logs the right way")
    }
}
