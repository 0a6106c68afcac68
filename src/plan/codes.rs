//! Codes of the findings of planning.

use crate::finding::codes;

codes! {
    NOT_SHOWN = "P101" "not-shown" Warning "No run of the plan shows this parameter apart from the others: it needs another degree of freedom, another sensor, or a value that is held.";
    NOT_REACHED = "P102" "not-reached" Warning "The plan does not bring this parameter to the deviation that was wanted: allow more or longer runs, more thrust, or a better sensor.";
    BEYOND = "P103" "plan-beyond-model" Warning "A proposed run is faster than the runs that the model comes from: what the plan predicts of it is an extrapolation.";
    REHEARSED_WORSE = "P104" "rehearsed-worse" Warning "Fits of simulated campaigns scatter by more than a fifth beyond the prediction, or cannot be made: the runs are too short or too weak for the linearised prediction to hold. Allow longer runs, more thrust or more room.";
    SATURATES = "P105" "plan-saturates" Warning "A proposed run pushes in several degrees of freedom at once by more than the thrusters give together: they are cut, and the run shows less than the plan predicts. Lower the limits with --limit DOF=N.";
    LIMITS_SEEN = "P201" "limits-from-runs" Note "No limit of thrust is given: the greatest force of the runs that the model comes from is taken. Give the vehicle's own with --limit DOF=N.";
    INSTRUMENTS_USUAL = "P202" "instruments-usual" Note "Noise or rate of a sensor is not known: those of an ordinary DVL and gyro are taken (5 mm/s, 3 mrad/s, 0.5 degrees, 10 Hz). Give your own with --noise and --rate.";
    LEFT_OUT = "P203" "candidates-left-out" Note "Some candidate runs were left out: they need more room than there is, or the model runs away or turns over in them.";
    REHEARSED_HELD = "P204" "rehearsed-held" Note "A plan that adds runs to those at hand is rehearsed on its own runs. What these alone do not show, and the model knows from the runs at hand, is held in the rehearsal; where they show nothing alone, there is no rehearsal.";
}
