//! Codes of the findings of an export: where a simulator differs from the model.

use crate::finding::codes;

codes! {
    EFFECT_LOST = "X001" "effect-lost" Warning "A term of the model has no place in the target: the simulator moves otherwise than the model. Add it there by other means, or fit a model without it.";
    COEFFICIENT_LOST = "X002" "coefficient-lost" Warning "A coefficient, usually a coupling of two motions, cannot be written in the target: the simulator moves otherwise than the model.";
    NOT_VEHICLE = "X003" "not-of-the-vehicle" Note "A term describes the water or the sensors of the tests, not the vehicle: it is rightly left out.";
    NOT_MODELLED = "X004" "not-modelled" Warning "The target moves in six degrees of freedom and the model in fewer: the others have no added mass and no damping there. Hold them, or identify them.";
    INERTIA = "X005" "dry-inertia-unknown" Note "Dry and added inertia in rotation are not told apart: the whole is given to the rigid body, which moves the same. Separate them by the option for the dry inertia.";
    GUESSED_INERTIA = "X006" "inertia-set" Warning "A rigid body needs three moments of inertia; those that are neither identified nor given are set to the value that is told.";
    NEGATIVE = "X007" "negative-added-mass" Warning "The virtual inertia is below the dry one. Thrust, mass or their units are wrong somewhere, or the data do not determine it; simulators may refuse it.";
    UNSTABLE = "X008" "explicit-added-mass" Warning "The target applies added mass as a force from the acceleration of the step before; with so much of it the simulation blows up, however short the step. Use a target in which it is part of the inertia.";
    EQUILIBRIUM = "X009" "not-in-equilibrium" Warning "The operating point of the linear model is no equilibrium: the linear model holds for a moment only.";
    OUT_OF_ENVELOPE = "X010" "out-of-envelope" Warning "The operating point lies beyond the speeds, angles or forces of the fit: the model extrapolates there.";
    CURVE_LOST = "X011" "thrust-curve-lost" Warning "The target takes thrust as a straight line of the command: between rest and full command the true thrust differs by what is told.";
    RESTORING = "X012" "restoring-elsewhere" Note "Weight and buoyancy are not in this file: the target takes them from gravity and a buoyancy system, which must be set to what is told.";
    TRIANGLE = "X013" "impossible-inertia" Warning "No body has these three moments of inertia: each is at most the sum of the other two. Simulators refuse it.";
    CANCELLED = "X014" "coriolis-cancelled" Note "The model has other Coriolis terms than its inertia implies; the file makes up for the difference, so that the simulator moves as the model does.";
    DELAY = "X015" "delay-left-out" Warning "A delay has no linear model of finite order: it is left out; put it, or a Pade approximation, before the inputs.";
    NO_LIMITS = "X017" "no-limits" Note "The target moves at any speed and attitude, and does not know between which the model was fitted: beyond them it extrapolates and nothing there says so.";
    ONE_AMPLITUDE = "X018" "one-amplitude" Warning "The runs of the fit oscillate at one Keulegan-Carpenter number, and the target takes their added mass and drag at any amplitude. Those of bluff bodies change several-fold with it: fit runs of other amplitudes too, or simulate at this one.";
    NO_ENVELOPE = "X019" "no-envelope" Note "The model file holds no envelope, so that nobody can say where the target extrapolates. Fit the model anew.";
    DEPRECATED = "X020" "deprecated-form" Warning "The version of the consumer that is asked for reads this form and announces its end. Use the form that is told.";
    UNSEEN = "X021" "state-unseen" Note "No output tells of a state of the filter's model, neither itself nor by way of others: the filter carries it along by dead reckoning, and its row of the stationary gain is 0. Log it where it matters.";
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
