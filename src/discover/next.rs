//! The most informative next run: it separates tied names, shows where to look for an effect without a name, or
//! reveals what a campaign in which nothing is missing could not have shown.

use super::residual::Residual;
use super::{ChangedParameter, FoundEffect, Verdict};
use crate::effects::{Coriolis, catalogue, id, separating};
use crate::frame::{Dof, Measured};

/// The next experiment in one sentence; `open`: outputs with a remaining gap, `unseen`: effects that this campaign
/// cannot show.
pub(super) fn experiment(
    verdict: Verdict,
    effects: &[FoundEffect],
    changed: Option<&ChangedParameter>,
    (open, residuals): (&[Measured], &[Residual]),
    unseen: &[String],
) -> Option<String> {
    if let Some(changed) = changed {
        return Some(apart(changed));
    }
    if let Some(tied) = effects.iter().find(|e| !e.also_possible.is_empty()) {
        return Some(separate(tied));
    }
    match verdict {
        Verdict::Unexplained | Verdict::PartlyExplained => Some(look(open, residuals)),
        Verdict::NothingMissing => reveal(unseen),
        Verdict::Explained => None,
    }
}

fn id_of(name: &str) -> &str {
    name.split('@').next().unwrap_or(name)
}

/// Data that show a catalogue effect.
fn shown_by(name: &str) -> Option<String> {
    let known = catalogue(Coriolis::Free);
    known.iter().find(|e| e.about().id == id_of(name)).map(|e| e.about().shown_by.to_string())
}

/// The run that distinguishes a name from the others of its class.
fn separate(tied: &FoundEffect) -> String {
    if tied.id == id::THRUST_DELAY && tied.also_possible == [id::SENSOR_DELAY] {
        return "No run of the vehicle can separate a late thrust from a late log: compare the clocks of command and \
                navigation on the bench."
            .into();
    }
    let rivals = tied.also_possible.join(", ");
    let others: Vec<&str> = tied.also_possible.iter().map(|name| id_of(name)).collect();
    if let Some(run) = separating(id_of(&tied.id), &others) {
        return format!("To separate {} from {rivals}, {run}.", tied.id);
    }
    let shown = |name: &str| shown_by(name).map(|data| format!("{name} is shown by {data}"));
    let each: Vec<String> = std::iter::once(tied.id.as_str())
        .chain(tied.also_possible.iter().map(String::as_str))
        .filter_map(shown)
        .collect();
    match each.is_empty() {
        true => format!("To separate {} from {rivals}, vary the quantities in their formulas one at a time.", tied.id),
        false => format!("To separate {} from {rivals}: {}.", tied.id, each.join("; ")),
    }
}

/// Where to look for an effect that is not in the catalogue: along the quantity that the missing force correlates with.
fn look(open: &[Measured], residuals: &[Residual]) -> String {
    let of = |residual: &&Residual| open.is_empty() || open.iter().any(|m| *m == residual.dof);
    let best = residuals.iter().filter(of).filter_map(|r| Some((r, r.goes_with.first()?)));
    let best = best.max_by(|a, b| a.1.correlation.abs().total_cmp(&b.1.correlation.abs()));
    let (dof, with) = match best {
        Some((residual, with)) => (residual.dof.to_string(), with.quantity.as_str()),
        None => {
            let names: Vec<String> = open.iter().map(ToString::to_string).collect();
            let place = if names.is_empty() { String::new() } else { format!(" in {}", names.join(", ")) };
            return format!(
                "Repeat a run with the same command at another depth, heading or time of day, and see whether the \
                 disagreement{place} repeats: if it does, the vehicle causes it; if not, its surroundings do."
            );
        }
    };
    match with {
        "heading" => format!("The missing force in {dof} depends on the heading: repeat one run on four headings."),
        "depth" => format!("The missing force in {dof} depends on the depth: repeat one run at three depths."),
        "time" => format!(
            "The missing force in {dof} drifts with time: repeat one run at the beginning and at the end of the day, \
             with the supply voltage logged."
        ),
        amplitude if amplitude.starts_with("amplitude") => format!(
            "The missing force in {dof} depends on the amplitude: oscillate at three amplitudes and two periods each."
        ),
        quantity => format!(
            "The missing force in {dof} depends on {quantity}: vary {quantity} over its whole range, slowly and with \
             all else as steady as possible, to see the form of the force."
        ),
    }
}

/// Advice if the commands do not move the vehicle in `dofs`; `None` if `dofs` is empty.
pub(super) fn driven(dofs: &[Dof]) -> Option<String> {
    let names: Vec<String> = dofs.iter().map(ToString::to_string).collect();
    (!dofs.is_empty()).then(|| {
        format!(
            "Drive {} with open-loop commands, in both directions and up to full thrust, in calm water and with a \
             slack tether. If the log already has such runs, its commands are not those that the thrusters received: \
             check their columns, order, signs and scale.",
            names.join(", ")
        )
    })
}

/// Advice if the model fails only on `runs` beyond the range of the runs of the fit. `None` if there are no such runs.
pub(super) fn take_part(runs: &[&str]) -> Option<String> {
    let one = runs.first()?;
    Some(format!(
        "Include {} in the fit (role = \"train\"), hold out another run, and search again: no run of the fit covers \
         the range of {one}.",
        runs.join(", ")
    ))
}

/// Advice to let the worst of the runs on which alone the model fails take part in the fit.
pub(super) fn show(runs: &[String]) -> Option<String> {
    let one = runs.first()?;
    Some(format!(
        "Include {one} in the fit (role = \"train\"), hold out a similar one, and search again: what acts there does \
         not act in the runs of the fit."
    ))
}

/// Advice for a parameter that changes with time.
fn apart(changed: &ChangedParameter) -> String {
    if !changed.alone && !changed.is_event() {
        return format!(
            "Repeat {} with smaller commands, step by step: the model fits it with different values than the rest, and \
             the amplitude at which they start to differ shows what it lacks.",
            changed.run
        );
    }
    let (effect, _) = changed.parameter.split_once(' ').unwrap_or((&changed.parameter, ""));
    let causes = match effect {
        "drag" => "weed, a lost fairing, a tow",
        "thrust" => "battery or supply, fouled propellers",
        "mass" => "a payload, ballast, water ingress",
        _ => "weed, a payload, a snagged tether, a failed thruster",
    };
    match changed.from {
        Some(_) if let Some(range) = changed.range_in_words().filter(|_| changed.is_event()) => {
            format!("Find out what happened {range} ({causes}), and fit the data logged before and after separately.")
        }
        Some(from) if changed.is_event() => format!(
            "Find out what happened at {from:.0} s of {} ({causes}), and fit the data logged before and after \
             separately.",
            changed.run
        ),
        None if changed.is_event() => format!(
            "Find out what was different in {} (trim, payload, supply, water, a sign or a scale of its log), and leave \
             that run out of the fit.",
            changed.run
        ),
        Some(from) => format!(
            "Find out what happened at {from:.0} s of {} (a payload, weed, a snagged tether, a failed thruster), \
             repeat one run in the state before and one in the state after it, and fit the two separately: {effect} \
             need not be the only thing that changed.",
            changed.run
        ),
        None => format!(
            "Find out what was different in {} (trim, payload, supply, water, a sign or a scale of its log), and \
             repeat that run: {effect} need not be the only thing that changed.",
            changed.run
        ),
    }
}

/// Effects that a campaign in which nothing is missing could not have shown, and the data that would show them.
fn reveal(unseen: &[String]) -> Option<String> {
    const NAMED: usize = 3;
    // an effect that no run can show is no reason for another run
    let names: Vec<&str> = unseen.iter().map(String::as_str).filter(|name| !name.contains(':')).take(NAMED).collect();
    let data = shown_by(names.first()?)?;
    Some(format!(
        "This data cannot separate {} from the terms of the model, whatever the size: {} needs {data}.",
        names.join(", "),
        names[0]
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_commands_do_not_move_is_to_be_driven() {
        assert_eq!(driven(&[]), None);
        let told = driven(&[Dof::Surge, Dof::Yaw]).unwrap();
        assert!(told.starts_with("Drive surge, yaw with open-loop commands") && !told.contains("  "), "{told}");
    }

    fn tied(id: &str, rivals: &[&str]) -> FoundEffect {
        FoundEffect {
            id: id.into(),
            common_name: String::new(),
            dofs: Vec::new(),
            parameters: Vec::new(),
            p_value: 0.0,
            also_possible: rivals.iter().map(|r| (*r).to_string()).collect(),
            evidence: String::new(),
        }
    }

    #[test]
    fn every_verdict_has_its_sentence() {
        let drag = [tied("cubic_drag@surge", &["quadratic_drag@surge"])];
        let said = experiment(Verdict::Explained, &drag, None, (&[], &[]), &[]).unwrap();
        assert!(said.contains("constant speeds"), "{said}");
        let odd = [tied("wave@sway", &["sail@sway"])];
        assert!(experiment(Verdict::Explained, &odd, None, (&[], &[]), &[]).unwrap().contains("wave@sway is shown by"));
        let open = [Measured::Velocity(Dof::Yaw)];
        assert!(experiment(Verdict::Unexplained, &[], None, (&open, &[]), &[]).unwrap().contains("yaw repeats"));
        let unseen = ["drag_asymmetry@surge".to_string()];
        let said = experiment(Verdict::NothingMissing, &[], None, (&[], &[]), &unseen).unwrap();
        assert!(said.contains("drag_asymmetry@surge needs"), "{said}");
        assert_eq!(experiment(Verdict::NothingMissing, &[], None, (&[], &[]), &[]), None);
        assert_eq!(experiment(Verdict::Explained, &[tied("wave@sway", &[])], None, (&[], &[]), &[]), None);
    }
}
