//! Codes of the findings from building a campaign, fitting and comparing.

use crate::finding::{Code, codes};

codes! {
    TWICE = "M001" "channel-twice" Error "Two logs of one run hold the same channel: leave it out of one of them with `columns`, or make them two runs.";
    NO_FORCE = "M002" "missing-column" Error "A run has no force for a degree of freedom of the model: neither its own column, nor thruster forces or commands that give it.";
    NO_THRUSTER = "M003" "thruster-missing" Error "A run logs thruster commands or forces but no [[thruster]] table says where they push.";
    THRUSTER_COLUMN = "M004" "missing-column" Error "A run logs some of the thrusters but not all of them.";
    NO_PULSE = "M005" "unit" Error "A command in us needs the thruster's `neutral` and `span`.";
    NOTHING_LEFT = "M006" "empty-window" Error "No sample is left of a run after `from`, `to` and `where`.";
    NOT_ON_CHANNEL = "M007" "missing-column" Error "The model or an option reads a channel that a run does not have.";
    VERTICAL = "M019" "vertical" Error "A run goes through a pitch of 90 degrees, where Euler angles are singular, and does not log what a quaternion needs, namely phi, theta and psi at the same instants, in every run. Log them, or cut the stretch with where = \"abs(theta) < 1.4\".";
    NO_TRAINING = "M008" "no-training-run" Error "No run takes part in the fit: at least one needs role = \"train\".";
    BENCH_ALONE = "M014" "bench-only" Error "Every run is of a thruster on a bench; such runs show nothing of a vehicle. `hydrosysid fit` estimates the thruster's curve, dead time and lag from them; for everything else add runs of the vehicle.";
    NO_KIND = "M015" "no-run-of-its-kind" Error "No run is of a kind from which the estimator can estimate a parameter of the model, so nothing is estimated. Add runs of the kinds that the message names, correct `kind` in the [[run]] tables, or choose another estimator.";
    NOT_STREAMED = "M010" "not-streamed" Error "A fit with --stream keeps no log in memory, and this run requests something that needs the whole log.";
    BENCH = "M220" "bench" Warning "A bench run shows nothing of its thruster: it needs a command that changes and at least 50 rows of `force`.";
    BOLLARD = "M011" "bollard-table" Error "A bollard table gives no curve of a thruster: it needs a command and a force in each row, in each direction at least three rows in which only this thruster is driven, and thrust that grows with the command.";
    SHARED_INERTIAS = "M012" "shared-inertias" Error "Integral least squares cannot estimate inertias that the balances of several degrees of freedom share (tied Coriolis): the noise of the velocities is larger than their change within a row. Use estimator = \"filter_error\", longer rows, or coriolis = \"free\".";
    NOT_EXCITED = "M013" "not-excited" Error "In every run of the fit a modelled degree of freedom has no command and no motion beyond noise, so nothing about it can be estimated. Leave it out of `dofs`, fix its parameters, or add a run that moves it.";
    RESAMPLE = "M009" "resample" Error "Resampling would make more than a thousand samples of each logged one: the rate or the unit of time is wrong.";

    NOT_CONVERGED = "M101" "not-converged" Warning "The estimation stopped before it converged: the start values may be far off, or some parameters are nearly collinear.";
    UNPHYSICAL = "M102" "non-physical" Warning "An estimate is physically impossible: drag dissipates, and virtual mass is not below the dry mass. A sign, a frame or a scale of thrust is wrong, or the data do not determine it.";
    AT_BOUND = "M103" "at-bound" Warning "An estimate is at its bound: its standard error means nothing.";
    LEFT_OUT = "M107" "run-left-out" Warning "A run is left out of the fit, because the estimator cannot use runs of \
                                              its kind.";
    CORRECTED = "M110" "log-corrected" Warning "A channel is logged in a wrong unit, with a wrong sign, in a wrong frame or late; the discovery worked on the corrected channel. Set the correction in [log].";
    NEVER_SHOWN = "M111" "excitation" Warning "No run of the fit moves a modelled degree of freedom enough to show its inertia and drag.";
    NO_INERTIA = "M112" "inertia-not-determined" Warning "The runs do not determine an inertia: in steady or gliding motion force and drag balance each other whatever the mass. The discovery fixes it at its prior value, or keeps it at or above the dry mass.";
    UNSEEN = "M145" "held-unseen" Warning "A parameter has no effect that the runs of free motion could show, so the discovery fixed it at its value, or fixed an inertia near where the search ended. Add a run that excites it, or fix it yourself with [[parameter]] fixed = true.";

    DIFFERENT = "M117" "models-differ" Warning "Two models of a vehicle differ by more than chance: the vehicle, its load or the tests have changed.";

    OTHER_TERMS = "M113" "other-terms" Note "Two models do not have the same terms: the terms of one absorb what it lacks, so common parameters need not agree.";
    SAME_DATA = "M114" "same-data" Note "Two models come from one campaign: their errors may be correlated, and the test of their difference errs on the side of no difference.";
    NOT_PUBLISHED = "M115" "not-published" Note "Parameters that a file of published ones does not contain are taken from the campaign's own model.";
    NO_COMPONENTS = "M120" "no-components" Warning "The forces of a balance cannot be shown over time: it depends on a state or a memory that no sensor logs.";

    NOT_APART = "M121" "not-told-apart" Warning "The data does not separate some parameters: each alone is uncertain, but their combination is known. Add the run that the message names, fix one of them, or use the model only where their combination matters.";
    HALVES = "M122" "halves-differ" Warning "The first and the second halves of the runs give different values of a parameter: something changes during a run (battery, tether, trim), or the parameter stands in for an effect that the model lacks. `hydrosysid discover` looks for it.";
    SEGMENT_LENGTH = "M123" "depends-on-segments" Warning "An estimate depends on the length of the segments after which the fit restarts its simulation: the model lacks something slow, or the motion is unstable.";
    WINDOW = "M127" "depends-on-window" Warning "An estimate by rows depends on how many samples a row spans: noise of the velocities enters the regressors, or the model lacks something slow. Longer windows suffer less from noise; output error keeps noise out of the regressors.";
    CORIOLIS_WORKS = "M124" "coriolis-works" Warning "Free Coriolis coefficients do work on the vehicle, which inertia never does: they contain lift or a missing effect. Tie them to the inertias (coriolis = \"tied\"), or add the effect.";
    INERTIA_AMPLITUDE = "M125" "inertia-against-amplitude" Warning "The inertia of a degree of freedom depends on the Keulegan-Carpenter number of the runs: one value does not hold for all amplitudes. Add the effect added_mass_amplitude, or use the model only at the amplitudes of the fit. If the message says that something else is missing, look for that first: the inertia compensates for it.";
    MORE_MISSING = "M128" "far-above-noise" Warning "With these parameters the fitted runs are still off by several times the noise of their sensors: the model lacks something, the parameters compensate for it in part, and neither they nor their standard errors can be trusted. `hydrosysid discover` looks for what is missing.";
    NOT_EXAMINED = "M129" "not-examined" Warning "The closer examination (--thorough) was left out: the simulation diverges with these estimates. Deal with the other findings on the fit first.";
    MODEL_UNSETTLED = "M130" "model-not-converged" Warning "The fit that wrote this model file did not converge: its values, their standard errors and its noise are those at which the search happened to stop, and results from them mean nothing. Run `hydrosysid check` on the campaign, fit it again, and use the model once its fit converges.";
    NO_SCALE = "M140" "no-scale" Warning "Nothing in the campaign fixes an absolute force: the scale of the thrust is free and so is everything else, and any multiple of the estimates fits as well. Fix one inertia, weight or scale of thrust, or give it a prior.";
    SAME_LOG = "M141" "same-log" Warning "Two runs share rows of a log: these count twice, or judge a fit in which they take part. Leave one run out, or separate them with `from` and `to`.";
    CONTRADICTED = "M142" "log-contradicts-itself" Warning "Sensors of one vehicle contradict each other in most of the runs: a channel has a wrong unit, the wrong sign or frame, or is delayed; or the thrusters push opposite to what [[thruster]] says. The fit takes the log as it is, and the fault biases its parameters and their standard errors. Correct it in [log], or correct position and axis in [[thruster]]; `hydrosysid discover` corrects a log in memory, or names what is wrong with it.";
    FEW_STRETCHES = "M143" "few-stretches" Warning "Residuals are correlated, and the data have too few independent stretches to estimate by how much for each parameter. The standard errors are those of white residuals, widened by what the stretches show together: treat them as rough. Longer or more runs improve this.";
    MIXED_REFERENCES = "M146" "mixed-references" Error "Some runs of free motion log velocities through the water and some over ground: one model can use only one of the two. Leave u, v, w of the others out of [log.columns], or fit them separately.";
    LACKING = "M144" "effect-lacking" Warning "Prediction errors are as expected, yet the innovations match the signature of a catalogue effect that the model does not have: the parameters are biased by it. Their standard errors include the shift that the likeliest such effect would cause, except for an effect of the thrust whose measured curves are uncertain themselves and carried along. `hydrosysid discover` looks for its name; if it finds none that passes all its tests, take the standard errors as a lower bound.";
    NEAR_VERTICAL = "M126" "near-vertical" Warning "A run comes near a pitch of 90 degrees without logging what a quaternion needs (phi, theta and psi at the same instants, in every run): roll and yaw cannot be separated there, and what depends on them is poorly known.";

    FIRST_SAMPLE = "M223" "first-sample" Note "One of the first three samples of a channel is off those after it by more than three times the usual change. No state is known before a log begins, so such an outlier could not be rejected later: it is left out.";
    FORCE_SOURCE = "M201" "force-source" Note "Thruster forces take precedence over voltages, and voltages over wrenches; this says which were used.";
    NO_HEADING = "M221" "no-heading" Warning "North and east are logged, but the heading is neither modelled nor logged: they show nothing of surge and sway, and are not used. Log psi.";
    TWO_CLOCKS = "M222" "two-clocks" Warning "Logs of one run have different clocks, one that starts at its own zero and one with wall-clock stamps, and their offset is unknown: give it as `clock_offset` of the log in the [[run]].";
    READ_ALIKE = "M230" "read-alike" Warning "A new log has the same columns as logs of the campaign that are not all read in the same way, and it is unknown which of them it resembles: it is read as most of them are. If that is wrong, say how it is read with --log.";
    NO_VALIDATION = "M202" "no-validation-run" Note "No run has role = \"validate\": results shown for training runs are optimistic.";
    LOOSE = "M204" "not-determined" Note "An estimate is no larger than its standard deviation: this data hardly shows it.";
    COLUMN = "M206" "column-candidate" Note "A further column of the log looks like a force of a standard form: the discovery tries it along with the catalogue.";
    FAMILIES = "M205" "families" Note "The search was restricted to some families of effects: the missing effect may belong to another.";
    HARMLESS = "M211" "harmless" Note "A parameter is not resolved, and its term carries hardly any force: its value does not matter on runs like these.";
    MUNK = "M212" "munk-moment" Note "The coefficient of u v in yaw compared with the difference of the virtual masses, which are equal in an ideal fluid: shown, not judged.";
    NOT_BOUNDED = "M213" "not-bounded" Note "The likelihood of a parameter does not fall off on both sides: the data give a bound on one side at most, and estimate ± standard error means little.";
    BY_QUATERNION = "M215" "by-quaternion" Note "A run comes near a pitch of 90 degrees, where Euler angles are singular: internally, the attitude is a unit quaternion, and the simulated attitude is compared with the logged one by the rotation between them.";
    STREAMED = "M214" "streamed" Note "Integral least squares read the logs piece by piece and kept none of them, because of --stream or because they exceed 64 MiB; its standard errors allow for correlation within clusters of rows.";
    STEPS_AS_LINES = "M216" "steps-as-lines" Note "Commands hold their values over several rows and then step, but input = \"linear\" interpolates between two samples: the force then acts up to a row too early or too late. Set input = \"hold\" in [model] or in the [[run]].";
    MEASURED_DEFLECTION = "M226" "measured-deflection" Note "The angle of a fin, or the speed of a propeller, changes from row to row where commands are held: it was measured, not commanded, and is interpolated between the rows. If it is a command, log it as one: a value that stays, and steps.";
    SCALE_BY_PRIOR = "M227" "scale-by-prior" Note "No run commands a known force, so any multiple of all masses, drags and forces gives the same motion: their common scale comes from the prior of one of them. Standard errors include that of the scale; ratios, speeds and turn rates do not depend on it.";
    LOSSES_OF_BOLLARD = "M224" "losses-of-bollard" Note "Estimators of free motion cannot use load cells: the loss of thrust by interaction is estimated from the bollard runs, as in stage (i) of the procedure, and held fixed.";
    OWN_VALUES = "M225" "own-values" Note "A parameter has its own value in every run. In a run that took no part in the fit it is estimated from the first half of that run: only the second half is a fair test of the model.";
    NOT_AT_START = "M203" "start" Note "The paper's (14) is not available: no linear regressor for all parameters, so std_paper is absent.";
}

/// Returns the codes of all modules, for `hydrosysid explain`.
pub fn everywhere() -> impl Iterator<Item = &'static Code> {
    crate::log::codes::ALL
        .iter()
        .chain(crate::procedure::codes::ALL)
        .chain(crate::check::codes::ALL)
        .chain(&crate::compare::CODES)
        .chain(crate::envelope::ALL)
        .chain(crate::discover::CODES)
        .chain(crate::plan::codes::ALL)
        .chain(crate::monitor::ALL)
        .chain(ALL)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn codes_are_unique_in_the_house() {
        let codes: BTreeSet<_> = everywhere().map(|c| c.code).collect();
        assert_eq!(codes.len(), everywhere().count());
    }
}
