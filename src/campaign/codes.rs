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
    VERTICAL = "M019" "vertical" Error "A run goes through a pitch of 90 degrees, where Euler angles are singular, and does not log what a quaternion needs: phi, theta and psi at the same instants, in every run. Log them, or cut the stretch with where = \"abs(theta) < 1.4\".";
    NO_TRAINING = "M008" "no-training-run" Error "No run takes part in the fit: at least one needs role = \"train\".";
    BENCH_ALONE = "M014" "bench-only" Error "Every run is of a thruster on a bench, which tells of that thruster and nothing of a vehicle. `hydrosysid fit` finds its curve, dead time and lag; for everything else add runs of the vehicle.";
    NO_KIND = "M015" "no-run-of-its-kind" Error "No run is of a kind that the estimator finds a parameter of the model from, so that nothing is estimated. Add runs of the kinds that the message names, mend `kind` in the [[run]] tables, or ask for another estimator.";
    NOT_STREAMED = "M010" "not-streamed" Error "A fit by --stream keeps no log, and this run asks for something that needs it whole.";
    BENCH = "M220" "bench" Warning "A bench run shows nothing of its thruster: it needs a command that changes and at least 50 rows of `force`.";
    BOLLARD = "M011" "bollard-table" Error "A bollard table gives no curve of a thruster: it needs a command and a force in each row, at least three rows each way in which this thruster alone is driven, and thrust that grows with the command.";
    SHARED_INERTIAS = "M012" "shared-inertias" Error "Integral least squares finds no inertias that the balances of several degrees of freedom can share (tied Coriolis): the noise of the velocities is larger than their change in a row. Use estimator = \"filter_error\", longer rows, or coriolis = \"free\".";
    NOT_EXCITED = "M013" "not-excited" Error "Every run of the fit leaves a modelled degree of freedom without a command and without motion beyond noise, and nothing of it can be found. Leave it out of `dofs`, hold its parameters, or add a run that moves it.";
    RESAMPLE = "M009" "resample" Error "Resampling would make more than a thousand samples of each: the rate or the unit of time is wrong.";

    NOT_CONVERGED = "M101" "not-converged" Warning "The estimation stopped before it converged: the start may be far off, or some parameters are nearly tied.";
    UNPHYSICAL = "M102" "non-physical" Warning "An estimate that no vehicle has: drag dissipates and virtual mass is not below the dry mass. A sign, a frame or a scale of thrust is wrong, or the data do not determine it.";
    AT_BOUND = "M103" "at-bound" Warning "An estimate stands at its bound: its standard deviation does not count.";
    LEFT_OUT = "M107" "run-left-out" Warning "A run takes no part, because the estimator cannot use runs of its kind.";
    CORRECTED = "M110" "log-corrected" Warning "A channel is logged in a wrong unit, with a wrong sign, in a wrong frame or late; the discovery worked on the mended channel. Say it in [log].";
    NEVER_SHOWN = "M111" "excitation" Warning "No run of the fit moves a modelled degree of freedom enough to show its inertia and drag.";
    NO_INERTIA = "M112" "inertia-not-determined" Warning "The runs do not determine an inertia: in steady or gliding motion force and drag balance each other whatever the mass. The discovery holds it at the value that is known beforehand, or keeps it at or above the dry mass.";
    UNSEEN = "M145" "held-unseen" Warning "A parameter changes nothing that the runs of free motion could show, so that the discovery held it at its value, or an inertia near where the search ended. Add a run that moves it, or hold it yourself with [[parameter]] fixed = true.";

    DIFFERENT = "M117" "models-differ" Warning "Two models of a vehicle differ by more than chance: the vehicle, its load or the tests have changed.";

    OTHER_TERMS = "M113" "other-terms" Note "Two models do not have the same terms: what one of them lacks the others take over, so that common parameters need not agree.";
    SAME_DATA = "M114" "same-data" Note "Two models come from one campaign: their errors may be alike, and the test of their difference errs on the side of no difference.";
    NOT_PUBLISHED = "M115" "not-published" Note "Parameters that a file of published ones does not hold are taken from the own model.";
    NO_COMPONENTS = "M120" "no-components" Warning "The forces of a balance cannot be shown over time: it hangs on a state or a memory that no sensor logs.";

    NOT_APART = "M121" "not-told-apart" Warning "The data does not separate some parameters: each alone is uncertain, their combination is known. Add the run that the message names, hold one of them, or use the model only where their combination counts.";
    HALVES = "M122" "halves-differ" Warning "The first and the second halves of the runs give different values of a parameter: something changes in the course of a run (battery, tether, trim), or the parameter stands in for an effect that the model lacks. `hydrosysid discover` looks for it.";
    SEGMENT_LENGTH = "M123" "depends-on-segments" Warning "An estimate depends on how long the fit simulates before it starts anew: the model lacks something slow, or the motion is unstable.";
    WINDOW = "M127" "depends-on-window" Warning "An estimate by rows depends on how many samples a row spans: noise of the velocities stands in its columns, or the model lacks something slow. Longer windows suffer less from noise; output error does not put noise into columns.";
    CORIOLIS_WORKS = "M124" "coriolis-works" Warning "Free Coriolis coefficients do work on the vehicle, which inertia never does: lift or a missing effect is in them. Tie them to the inertias (coriolis = \"tied\"), or name the effect.";
    INERTIA_AMPLITUDE = "M125" "inertia-against-amplitude" Warning "The inertia of a degree of freedom follows the Keulegan-Carpenter number of the runs: one number does not hold for all amplitudes. Add the effect added_mass_amplitude, or use the model only at the amplitudes of the fit. Where the message says that something else is missing, look for that first: the inertia makes up for it.";
    MORE_MISSING = "M128" "far-above-noise" Warning "With these parameters the fitted runs are still off by several times the noise of their sensors: the model lacks something, the parameters have taken over what they could of it, and neither they nor their deviations mean what they seem to. `hydrosysid discover` looks for what is missing.";
    NOT_EXAMINED = "M129" "not-examined" Warning "The closer look (--thorough) was left out: the simulation runs away with the estimates. What else is said of the fit comes first.";
    MODEL_UNSETTLED = "M130" "model-not-converged" Warning "The fit that wrote this model file did not converge: its values, their deviations and its noise are where the search happened to stop, and what is made of them means nothing. Look at what `hydrosysid check` says of the campaign, fit it anew, and use the model once its fit converges.";
    NO_SCALE = "M140" "no-scale" Warning "Nothing in the campaign tells an absolute force: the scale of the thrust is free and so is everything else, and any multiple of the estimates fits as well. Hold one inertia, weight or scale of thrust, or give it a prior.";
    SAME_LOG = "M141" "same-log" Warning "Two runs share rows of a log: it counts twice, or judges a fit that it takes part in. Leave one of them out, or cut them apart with `from` and `to`.";
    CONTRADICTED = "M142" "log-contradicts-itself" Warning "Sensors of one vehicle contradict each other in most of the runs: a channel has a wrong unit, the wrong sign or frame, or comes late; or the thrusters push the other way than [[thruster]] places them. The fit takes the log at its word, and its parameters and their deviations make up for the fault. Say what is wrong in [log], or mend position and axis in [[thruster]]; `hydrosysid discover` mends a log in memory, or names what is wrong with it.";
    FEW_STRETCHES = "M143" "few-stretches" Warning "Residuals are correlated, and the data have too few stretches that are independent of each other to tell by how much for each parameter. Deviations are those of white residuals, widened by what the stretches show together: take them as rough. Longer runs, or more of them, tell more.";
    MIXED_REFERENCES = "M146" "mixed-references" Error "Some runs of free motion log velocities through the water and some over ground: one model takes one of them. Leave u, v, w of the others out of [log.columns], or fit them apart.";
    LACKING = "M144" "effect-lacking" Warning "Predictions err as expected, and all the same the innovations follow what an effect of the catalogue would do that the model does not have: the parameters are biased by it, and their deviations include how far they move where the likeliest such effect is in the model, save one of the thrust where its measured curves are uncertain themselves and carried along. `hydrosysid discover` looks for its name; where it finds none that stands all its tests, take the deviations for a lower bound.";
    NEAR_VERTICAL = "M126" "near-vertical" Warning "A run comes near a pitch of 90 degrees without logging what a quaternion needs (phi, theta and psi at the same instants, in every run): roll and yaw are not told apart there, and what hangs on them is poor.";

    FIRST_SAMPLE = "M223" "first-sample" Note "One of the first three samples of a channel is off those after it by more than three times what is usual there. Nothing is known of a state before a log begins, so that nothing could hold such an outlier back later: it takes no part.";
    FORCE_SOURCE = "M201" "force-source" Note "Thruster forces win over voltages, and voltages over wrenches; this says which were used.";
    NO_HEADING = "M221" "no-heading" Warning "North and east are logged and the heading is neither modelled nor logged: they say nothing of surge and sway, and take no part. Log psi.";
    TWO_CLOCKS = "M222" "two-clocks" Warning "Logs of one run are on different clocks, one that counts from its own zero and one with stamps of a wall clock, and nothing says how far they are apart: `clock_offset` of the log in the [[run]] does.";
    READ_ALIKE = "M230" "read-alike" Warning "A new log has the columns of logs of the campaign that are not all read in one way, and nothing says which of them it is like: it is read as most of those are. Say how it is read with --log where that is wrong.";
    NO_VALIDATION = "M202" "no-validation-run" Note "No run has role = \"validate\": what is shown for training runs flatters the model.";
    LOOSE = "M204" "not-determined" Note "An estimate is no larger than its standard deviation: this data hardly shows it.";
    COLUMN = "M206" "column-candidate" Note "A further column of the log has a standard form as a force: the discovery tries it beside the catalogue.";
    FAMILIES = "M205" "families" Note "The search was restricted to some families of effects: what is missing may be of another.";
    HARMLESS = "M211" "harmless" Note "A parameter is not resolved, and its term carries hardly any force: what it is does not matter on runs like these.";
    MUNK = "M212" "munk-moment" Note "The coefficient of u v in yaw beside the difference of the virtual masses, which an ideal fluid makes equal: shown, not judged.";
    NOT_BOUNDED = "M213" "not-bounded" Note "The likelihood of a parameter does not rise on both sides: the data gives a bound on one side at most, and estimate ± deviation means little.";
    BY_QUATERNION = "M215" "by-quaternion" Note "A run comes near a pitch of 90 degrees, where Euler angles are singular: inside, the attitude is a unit quaternion, and the simulated attitude is compared with the logged one by the turn between them.";
    STREAMED = "M214" "streamed" Note "Integral least squares read the logs piece by piece and kept none of them, as --stream asks or because they are more than 64 MiB; its deviations allow for correlation within clusters of rows.";
    STEPS_AS_LINES = "M216" "steps-as-lines" Note "Commands hold their values over several rows and then step, but input = \"linear\" reads a slope between two samples: the force then acts up to a row too early or too late. Say input = \"hold\" in [model] or in the [[run]].";
    MEASURED_DEFLECTION = "M226" "measured-deflection" Note "The angle of a fin, or the turns of a propeller, goes on from row to row where commands are held: it was measured, not ordered, and is read on lines between the rows. Where it is an order, log it as one: a value that stays, and steps.";
    SCALE_BY_PRIOR = "M227" "scale-by-prior" Note "No run commands a known force, so that any multiple of all masses, drags and forces moves alike: their common scale is what is known beforehand of one of them. Deviations hold that of the scale; ratios, speeds and turns do not hang on it.";
    LOSSES_OF_BOLLARD = "M224" "losses-of-bollard" Note "Estimators of free motion cannot read load cells: the loss of thrust by interaction is taken from the bollard runs, as stage (i) of the procedure finds it, and held.";
    OWN_VALUES = "M225" "own-values" Note "A parameter has a value of its own in every run. In a run that took no part in the fit it comes from the first half of that run: its second half judges the model, its first half flatters it.";
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
