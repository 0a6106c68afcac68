//! Rehearsal of a plan on its own runs: a parameter that they do not show is held if the model
//! knows it from existing runs.

use super::plan_request::PlanRequest;
use super::plan_source::PlanSource;
use crate::finding::Finding;
use crate::plan::{Course, Manoeuvre, PlanOptions, Predicted, Proposal, Rehearsal, Wish, codes, predict, rehearse};
use crate::wording::listed;

/// A plan is unreliable if more than one in this many of its simulated campaigns cannot be fitted.
const FEW: usize = 20;

/// Simulates and fits campaigns of the runs of `proposal`; `None` if these runs alone show nothing.
pub(super) fn rehearsed(
    (course, source): (&Course, &PlanSource),
    proposal: &Proposal,
    (wishes, options): (&[Wish], &PlanOptions),
    request: &PlanRequest,
    progress: &(dyn Fn() + Sync),
) -> (Option<Rehearsal>, Vec<Finding>) {
    let times = (request.rehearse, request.seed);
    if options.known.is_none() {
        let (found, findings) = rehearse(course, proposal, &source.fitting, times, progress);
        return (Some(found), findings);
    }
    let alone = PlanOptions { known: None, ..options.clone() };
    let runs: Vec<Manoeuvre> = proposal.runs.iter().map(|run| run.sailed.manoeuvre.clone()).collect();
    let Ok(own) = predict(course, &runs, wishes, &alone) else { return (None, Vec::new()) };
    let held: Vec<usize> = own.parameters.iter().filter(|p| is_better_known(course, p)).map(|p| p.parameter).collect();
    let mut course = course.clone();
    let mut names = Vec::new();
    for p in &held {
        course.model.parameters[*p].fixed = true;
        names.push(course.model.parameters[*p].spec.name.clone());
    }
    let told = listed(&names);
    let plan = match held.len() {
        0 => Ok(own),
        n if n == own.parameters.len() => {
            let text = "not rehearsed: the runs of the plan alone show none of the parameters; they help only \
                        together with the existing runs";
            return (None, vec![Finding::new(&codes::REHEARSED_HELD, text)]);
        }
        _ => predict(&course, &runs, wishes, &alone),
    };
    let Ok(plan) = plan else { return (None, Vec::new()) };
    let (found, mut findings) = rehearse(&course, &plan, &source.fitting, times, progress);
    if !held.is_empty() {
        let text = format!(
            "the runs of the plan alone do not show {told}: the rehearsal fixes what the existing runs say of {}",
            if held.len() == 1 { "it" } else { "them" }
        );
        findings.push(Finding::new(&codes::REHEARSED_HELD, text));
    }
    (Some(found), findings)
}

/// Whether the runs of a plan alone give no standard deviation, or one above its size, of a
/// parameter that the model knows better.
fn is_better_known(course: &Course, alone: &Predicted) -> bool {
    let size = alone.value.abs();
    let known = course.model.parameters[alone.parameter].std.filter(|std| *std > 0.0);
    known.is_some_and(|known| alone.std.is_none_or(|std| std > size && std > known))
}

/// Returns the warning of a rehearsal that cannot fit its campaigns, to stand before all else;
/// empty for any other.
pub(super) fn spoilt(rehearsal: Option<&Rehearsal>) -> String {
    match rehearsal {
        Some(r) if r.failed * FEW > r.campaigns => format!(
            "Do not rely on this plan: {} of {} simulated campaigns of it could not be fitted. ",
            r.failed, r.campaigns
        ),
        _ => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plan_whose_campaigns_cannot_be_fitted_is_not_to_be_relied_on() {
        let of = |failed| Rehearsal { campaigns: 20, failed, seed: 1, parameters: Vec::new() };
        assert_eq!(spoilt(None) + &spoilt(Some(&of(0))) + &spoilt(Some(&of(1))), "");
        assert!(spoilt(Some(&of(20))).starts_with("Do not rely on this plan: 20 of 20"));
    }
}
