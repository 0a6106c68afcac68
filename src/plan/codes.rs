//! Codes of the findings of planning.

use crate::finding::codes;

codes! {
    NOT_SHOWN = "P101" "not-shown" Warning "No run of the plan shows this parameter apart from the others: it needs motion in another degree of freedom, another sensor, or a fixed value.";
    NOT_REACHED = "P102" "not-reached" Warning "The plan does not reach the requested standard error of this parameter: allow more or longer runs, more thrust, or a better sensor.";
    BEYOND = "P103" "plan-beyond-model" Warning "A proposed run is faster than the runs from which the model was estimated: its prediction is an extrapolation.";
    REHEARSED_WORSE = "P104" "rehearsed-worse" Warning "Fits of simulated campaigns scatter by more than a fifth beyond the prediction, or fail: the runs are too short or too weak for the linearised prediction to hold. Allow longer runs, more thrust or more room.";
    SATURATES = "P105" "plan-saturates" Warning "A proposed run requests more thrust in several degrees of freedom at once than the thrusters can provide together: the commands are clipped, and the run shows less than the plan predicts. Lower the limits with --limit DOF=N.";
    LIMITS_SEEN = "P201" "limits-from-runs" Note "No limit of thrust is given: the largest force of the runs from which the model was estimated is used. Give the vehicle's own with --limit DOF=N.";
    INSTRUMENTS_USUAL = "P202" "instruments-usual" Note "Noise or rate of a sensor is not known: those of an ordinary DVL and gyro are assumed (5 mm/s, 3 mrad/s, 0.5 degrees, 10 Hz). Give your own with --noise and --rate.";
    LEFT_OUT = "P203" "candidates-left-out" Note "Some candidate runs were left out: they need more room than available, or the model diverges or capsizes in them.";
    REHEARSED_HELD = "P204" "rehearsed-held" Note "A plan that adds runs to existing ones is rehearsed on its own runs. What these alone do not show, and the model knows from the existing runs, is fixed in the rehearsal; if they show nothing alone, there is no rehearsal.";
}
