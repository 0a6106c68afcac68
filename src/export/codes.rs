//! Codes of the findings of an export: where a simulator differs from the model.

use crate::finding::codes;

codes! {
    EFFECT_LOST = "X001" "effect-lost" Warning "A term of the model has no place in the target: the simulator moves differently from the model. Add it there by other means, or fit a model without it.";
    COEFFICIENT_LOST = "X002" "coefficient-lost" Warning "A coefficient, usually a coupling of two motions, cannot be written in the target: the simulator moves differently from the model.";
    NOT_VEHICLE = "X003" "not-of-the-vehicle" Note "A term describes the water or the sensors of the tests, not the vehicle: it is left out on purpose.";
    NOT_MODELLED = "X004" "not-modelled" Warning "The target moves in six degrees of freedom, the model in fewer: the others have no added mass and no damping there. Lock them, or identify them.";
    INERTIA = "X005" "dry-inertia-unknown" Note "The data do not separate dry and added inertia in rotation: the whole is given to the rigid body, and the motion is the same. Separate them with the option for the dry inertia.";
    GUESSED_INERTIA = "X006" "inertia-set" Warning "A rigid body needs three moments of inertia; those that are neither identified nor given are set to the stated value.";
    NEGATIVE = "X007" "negative-added-mass" Warning "The virtual inertia is below the dry one. Thrust, mass or their units are wrong somewhere, or the data do not determine it; simulators may refuse it.";
    UNSTABLE = "X008" "explicit-added-mass" Warning "The target applies added mass as a force from the acceleration of the step before; with this much added mass the simulation blows up, however short the step. Use a target in which it is part of the inertia.";
    EQUILIBRIUM = "X009" "not-in-equilibrium" Warning "The operating point of the linear model is not an equilibrium: the linear model holds only for a moment.";
    OUT_OF_ENVELOPE = "X010" "out-of-envelope" Warning "The operating point lies beyond the speeds, angles or forces of the fit: the model extrapolates there.";
    CURVE_LOST = "X011" "thrust-curve-lost" Warning "The target assumes thrust linear in the command: between rest and full command the true thrust differs by the stated amount.";
    RESTORING = "X012" "restoring-elsewhere" Note "Weight and buoyancy are not in this file: the target takes them from gravity and a buoyancy system, which must be set to the stated values.";
    TRIANGLE = "X013" "impossible-inertia" Warning "No rigid body can have these three moments of inertia: each must be at most the sum of the other two. Simulators refuse it.";
    CANCELLED = "X014" "coriolis-cancelled" Note "The Coriolis terms of the model differ from those that its inertia implies; the file compensates for the difference, so the simulator moves as the model does.";
    DELAY = "X015" "delay-left-out" Warning "A delay has no linear model of finite order: it is left out; put it, or a Padé approximation, before the inputs.";
    NO_LIMITS = "X017" "no-limits" Note "The target moves at any speed and attitude and does not know the range in which the model was fitted: beyond it, the target extrapolates without warning.";
    ONE_AMPLITUDE = "X018" "one-amplitude" Warning "The runs of the fit oscillate at one Keulegan-Carpenter number, and the target uses their added mass and drag at any amplitude. Those of bluff bodies change several-fold with it: fit runs of other amplitudes as well, or simulate at this one.";
    NO_ENVELOPE = "X019" "no-envelope" Note "The model file has no envelope, so it is unknown where the target extrapolates. Fit the model again.";
    DEPRECATED = "X020" "deprecated-form" Warning "The requested version of the consumer reads this form but has announced its removal. Use the form that the message names.";
    UNSEEN = "X021" "state-unseen" Note "No output observes a state of the filter's model, directly or through other states: the filter propagates it by dead reckoning, and its row of the stationary gain is 0. Log it if it matters.";
    PULSE = "X016" "pulse-unknown" Warning "A thruster has no `neutral` and `span`, or no `max`: its pulse widths are not known and are left out.";
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    #[test]
    fn codes_are_unique_in_the_house() {
        let all = || crate::campaign::codes::everywhere().chain(super::ALL);
        let codes: BTreeSet<_> = all().map(|c| c.code).collect();
        assert_eq!(codes.len(), all().count());
    }
}
