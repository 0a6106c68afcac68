//! A run in which a command has the opposite sign to the other runs, for example because a wire was
//! reversed for a day.
//!
//! ```text
//! τ → −τ   in the run in which it acts the wrong way, if at least as many runs show the right way
//!          and the search then leaves nothing unexplained
//! ```
//!
//! A controller that moves the command looks the same: so the likelihood decides, and only if
//! something is unexplained otherwise.

use super::load::Campaign;
use super::log_faults::{Fault, reports};
use crate::check::{codes::SIGN_DISAGREES, together};
use crate::discover::LogFinding;
use crate::frame::Dof;
use crate::run::Run;

/// A force that has the opposite sign in one run.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct OddRun {
    run: String,
    channel: String,
}

impl OddRun {
    /// Returns the forces whose sign the checks find wrong in some runs, and right in at least as
    /// many others.
    pub fn accused(campaign: &Campaign, runs: &[Run]) -> Vec<OddRun> {
        // a fault of a force that is calculated from thrusters is a fault of one of them
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

    /// Reverses the channel in its run; the files stay unchanged.
    pub fn mend(&self, runs: &mut [Run]) {
        let fault = Fault::Factor { channel: self.channel.clone(), factor: -1.0 };
        runs.iter_mut().filter(|run| run.name == self.run).for_each(|run| fault.mend(std::slice::from_mut(run)));
    }

    /// Returns the fault as an entry of the discovery's result.
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
