//! The verb `discover`: search for effects that the baseline of a campaign lacks.

use super::codes;
use super::error::Error;
use super::file::DiscoverTable;
use super::first_samples;
use super::fit::{dry_mass, filter_error, is_below};
use super::late_gyro;
use super::lead_in;
use super::load::Campaign;
use super::log_faults::{Fault, faults};
use super::odd_run::OddRun;
use super::reversed_thruster::Reversed;
use super::steps_as_lines;
use super::unexcited;

use crate::discover::{self, Discovery, SearchOptions, Verdict};
use crate::effects::{Family, id};
use crate::estimate::output_error::OutputErrorError;
use crate::finding::Finding;
use crate::frame::Dof;
use crate::model::{Model, Parameter};
use crate::run::{Role, Run, Signal};
use crate::vehicle::Vehicle;
use crate::wording::{digits, measured};

/// Returns the search options of a campaign.
pub(super) fn options(campaign: &Campaign) -> SearchOptions {
    let table = &campaign.file.discover;
    SearchOptions {
        level: table.level,
        most: table.max_effects,
        families: table.families.clone(),
        seed: table.seed.unwrap_or(campaign.options.seed),
    }
}

/// Searches the runs of free motion of a campaign for effects that its baseline lacks.
///
/// # Errors
/// [`Error`] if the baseline cannot be fitted or a run lacks what it reads.
pub fn discover(campaign: &Campaign) -> Result<Discovery, Error> {
    campaign.refuse_bench_alone()?;
    let table = &campaign.file.discover;
    let usual = DiscoverTable::default();
    let options = options(campaign);
    // the candidates include a late thrust
    let mut runs = lead_in::settled(campaign.motion(None), &campaign.model);
    if let Some(finding) = unexcited::at_rest(&runs) {
        return Err(Error::Refused { findings: vec![finding] });
    }
    let (part, resting) = unexcited::taking_part(campaign);
    runs.iter_mut().filter(|run| part.contains(&run.name)).for_each(|run| run.role = Role::Train);
    if part.is_empty() {
        unexcited::refuse(campaign, &campaign.motion(Some(Role::Train)))?;
    }
    let fitting = filter_error::options(campaign);
    let mut faults = faults(&runs, &campaign.model);
    let names_sensors = options.families.contains(&Family::Sensor);
    if names_sensors {
        // among the effects of sensors a gyro lag has a name, a gyro latency has none
        faults.retain(|fault| fault.latency_of_gyro().is_some() || !fault.has_name(&campaign.model));
    }
    // last the latencies of gyros, which a fit has to tell from lags, on logs in which the other
    // faults are mended
    faults.sort_by_key(|fault| fault.latency_of_gyro().is_some());
    faults.retain(|fault| {
        let stands = !names_sensors || !late_gyro::is_smoothed(&campaign.model, &runs, fault, &fitting);
        if stands {
            fault.mend(&mut runs);
        }
        stands
    });
    let reversed = Reversed::shown(campaign, &runs);
    if let Some(reversed) = &reversed {
        reversed.mend(campaign, &mut runs);
    }
    let search =
        |model: &Model, runs: &[Run]| discover::discover(model, runs, &campaign.candidates, &fitting, &options);
    let mut model = campaign.model.clone();
    let mut searched = search(&model, &runs);
    if let Err(OutputErrorError::NotIdentified { parameters, values }) = &searched {
        let said = hold(&mut model, parameters, values);
        searched = search(&model, &runs);
        if let Ok(found) = &mut searched {
            found.warnings.push(said);
        }
    }
    let mut found = searched?;
    let odd = if passes(&found) { Vec::new() } else { OddRun::accused(campaign, &runs) };
    let mut odd_told = Vec::new();
    if !odd.is_empty() {
        let mut turned = runs.clone();
        odd.iter().for_each(|fault| fault.mend(&mut turned));
        if let Some(again) = search(&model, &turned).ok().filter(passes) {
            (runs, odd_told) = (turned, odd);
            found = with_what_was_held(again, &found);
        }
    }
    // if the thrust turns out to be late, first seconds of more runs are left out: they are no
    // evidence of another missing effect
    if let Some(last) = found.model().filter(|last| lead_in::is_late(last) && !lead_in::is_late(&model)) {
        let settled = lead_in::settled(runs.clone(), last);
        let samples =
            |runs: &[Run]| -> usize { runs.iter().flat_map(|run| run.signals.values()).map(Signal::len).sum() };
        if samples(&settled) < samples(&runs) {
            runs = settled;
            found = search(&model, &runs).map(|again| with_what_was_held(again, &found))?;
        }
    }
    let (held, said) = undetermined(&model, &found, &campaign.file.vehicle);
    if let Some(held) = held {
        found = search(&held, &runs).map(|again| with_what_was_held(again, &found))?;
    }
    found.warnings.extend(said);
    if found.steps.first().is_some_and(|baseline| !baseline.fit.converged) {
        let text = "the fit of the baseline did not converge, so what an effect appears to gain may come from the fit \
                    itself";
        found.warnings.push(Finding::new(&codes::NOT_CONVERGED, text));
    }
    if table.families != usual.families {
        let names: Vec<&str> = table.families.iter().map(|family| family.name()).collect();
        let text = format!("only effects of the family {} and the campaign's own were tried", names.join(", "));
        found.warnings.push(Finding::new(&codes::FAMILIES, text));
    }
    let train: Vec<Run> = runs.iter().filter(|run| run.role == Role::Train).cloned().collect();
    let last = found.steps.last().map(|step| &step.fit);
    // the finding of the search about the input replaces that of the logs
    let lines = found.input.is_some()
        || last.is_some_and(|fit| steps_as_lines::refuted(&campaign.findings, fit, &train, &fitting));
    let unsaid = |code: &str| code == codes::NO_VALIDATION.code || lines && code == codes::STEPS_AS_LINES.code;
    let told = campaign.findings.iter().filter(|f| !unsaid(f.code)).cloned();
    let told: Vec<Finding> = told.chain(campaign.brought.iter().cloned()).collect();
    found.warnings.splice(0..0, told);
    if !part.is_empty() {
        let dofs: Vec<&str> = resting.iter().map(|dof| dof.name()).collect();
        found.with_runs_that_took_part(part, &format!("no run of the fit moves {}", dofs.join(", ")));
    }
    let of_log = faults.iter().map(ToString::to_string).chain(odd_told.iter().map(ToString::to_string));
    let told: Vec<String> = of_log.chain(reversed.iter().map(ToString::to_string)).collect();
    let mended = |fault: &String| {
        let text = format!("{fault}; the search worked on the corrected channel, the files are unchanged");
        Finding::new(&codes::CORRECTED, text)
    };
    found.warnings.extend(told.iter().map(mended));
    let tracks = found.steps.last().into_iter().flat_map(|step| &step.fit.filtered.problem.tracks);
    found.warnings.extend(first_samples::findings(tracks));
    let of_odd_runs = odd_told.iter().map(OddRun::finding);
    let of_wiring = reversed.iter().map(Reversed::finding);
    found.log_findings = faults.iter().flat_map(Fault::findings).chain(of_odd_runs).chain(of_wiring).collect();
    if !told.is_empty() {
        let what = if faults.is_empty() && odd_told.is_empty() { "wiring" } else { "log" };
        found.sentence = format!("The {what} is wrong: {}. With that corrected: {}", told.join("; "), found.sentence);
    }
    Ok(found)
}

/// Holds the parameters that the runs of free motion do not show (runs of another kind may):
/// `m_uq of added_mass_coupling@surge:pitch, …`. Returns the finding.
///
/// An inertia without a given value is not fixed: it gets a prior at the value at which the search
/// ended, with that value as standard deviation. It is in every balance of its degree of freedom,
/// and without it nothing that acts there has a scale. A missing effect may show it: a Munk moment
/// of known masses.
fn hold(model: &mut Model, unseen: &[String], values: &[f64]) -> Finding {
    let mut held = Vec::new();
    for p in &mut model.parameters {
        let Some(ended) = unseen.iter().position(|name| *name == p.full_name()).map(|k| values[k]) else { continue };
        if p.effect == id::INERTIA && !p.given && ended > 0.0 {
            (p.value, p.prior) = (ended, Some((ended, ended)));
            held.push(format!("{} of `{}` near {} {}", p.spec.name, p.term, digits(ended), p.spec.dimension));
        } else {
            p.fixed = true;
            held.push(format!("{} of `{}` at {} {}", p.spec.name, p.term, p.value, p.spec.dimension));
        }
    }
    let text = format!(
        "no run of free motion shows {}: the search held {}; add a run that excites the motion it multiplies",
        unseen.join(", "),
        held.join(", ")
    );
    Finding::new(&codes::UNSEEN, text)
}

/// Whether a search leaves nothing unexplained.
fn passes(found: &Discovery) -> bool {
    matches!(found.verdict, Verdict::NothingMissing | Verdict::Explained)
}

/// Returns a repeated search with the findings of an earlier one about parameters that it held.
fn with_what_was_held(mut again: Discovery, earlier: &Discovery) -> Discovery {
    again.warnings.extend(earlier.warnings.iter().filter(|w| w.code == codes::UNSEEN.code).cloned());
    again
}

/// Relative standard deviation above which an inertia is not known: in quasi-steady motion force
/// and drag balance each other, whatever the mass.
const UNKNOWN: f64 = 0.3;

/// Returns the findings about inertias that the runs do not determine, and the model in which they
/// are held if a value is known beforehand: free, they would take up what is missing.
///
/// These are inertias of the baseline with a wide standard deviation, and inertias below the dry
/// mass, which no vehicle has, at the end of the search. The latter are kept at or above the dry
/// mass. None is held if the commands do not move the vehicle in a degree of freedom whose inertia
/// seems to be known: holding cannot mend that.
fn undetermined(model: &Model, found: &Discovery, vehicle: &Vehicle) -> (Option<Model>, Vec<Finding>) {
    let (Some(first), Some(last)) = (found.steps.first(), found.steps.last()) else { return (None, Vec::new()) };
    let inertia = |p: &&Parameter| p.effect == id::INERTIA && !p.fixed && p.prior.is_none();
    let loose = |p: &&Parameter| p.std.is_some_and(|std| std > UNKNOWN * p.value.abs());
    let light = |p: &Parameter| dry_mass(p, vehicle).filter(|dry| is_below(p, *dry) && p.min < *dry);
    let mut held = model.clone();
    let (mut any, mut said) = (false, Vec::new());
    // a baseline far from the truth leaves an inertia undetermined that the explained model
    // determines
    let known_at_last = |p: &&Parameter| {
        let at_last = last.fit.model.parameters.iter().find(|q| q.term == p.term && q.spec.name == p.spec.name);
        found.verdict == Verdict::Explained && at_last.is_some_and(|q| !loose(&q))
    };
    let baseline = || first.fit.model.parameters.iter().filter(inertia);
    let is_astray = |dof: &Dof| baseline().filter(|p| !loose(p)).any(|p| p.place.dof == Some(*dof));
    let holds = !found.moved_otherwise.iter().any(is_astray);
    let wide = baseline().filter(loose);
    let wide = wide.filter(|p| !known_at_last(p)).map(|p| (p, None));
    let below = last.fit.model.parameters.iter().filter(inertia).filter_map(|p| Some((p, Some(light(p)?))));
    for (p, dry) in wide.chain(below) {
        let known = held.parameters.iter_mut().find(|k| k.term == p.term && k.spec.name == p.spec.name);
        let unit = p.spec.dimension;
        let mut text = format!(
            "{} of `{}` cannot be identified from these runs: {} {unit}",
            p.spec.name,
            p.term,
            measured(p.value, p.std.unwrap_or(f64::NAN))
        );
        text += match dry {
            None => "; this needs motion that accelerates under a known force",
            Some(_) => " is below the dry mass, which is impossible",
        };
        match (known.filter(|k| holds && !k.fixed), dry) {
            (Some(known), Some(dry)) => {
                (known.min, known.value, any) = (dry, known.value.max(dry), true);
                text += &format!("; it was kept at or above {dry:.4} {unit}");
            }
            (Some(known), None) if known.value > 0.0 => {
                (known.fixed, any) = (true, true);
                text += &format!("; it was held at {:.4} {unit}", known.value);
            }
            _ => {}
        }
        said.push(Finding::new(&codes::NO_INERTIA, text));
    }
    (any.then_some(held), said)
}
