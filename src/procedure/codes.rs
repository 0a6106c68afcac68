//! Codes of the findings of the staged procedure.

use crate::finding::codes;

codes! {
    ADVANCE_RANGE = "S101" "advance-out-of-range" Warning "Part of a run was faster than the speeds at which the advance efficiency was measured; the line was extrapolated.";
    ADVANCE_AGAINST = "S102" "advance-against-motion" Warning "In part of a run the thrust opposed the motion, which the advance efficiency does not describe.";
    RATE_MADE = "S103" "rate-from-angle" Warning "A body rate that the model reads is not logged; it was computed by differentiating the filtered angle.";
    NO_STEADY = "S104" "no-steady-window" Warning "No stretch of a constant-velocity run is steady: lengthen the run or relax the limits.";
    NO_RUN = "S105" "no-run" Warning "No run shows what a stage needs, so its parameters keep their values.";
    NOT_ESTIMATED = "S106" "not-estimated" Warning "A free parameter has no stage that estimates it; it keeps its value. Output error can estimate it.";
    UNPHYSICAL = "S107" "unphysical" Warning "An estimate has a physically impossible sign: drag dissipates, inertia is positive.";
    MUNK = "S108" "munk-moment" Note "The coefficient of uv in yaw is not the difference of the virtual masses; it is reported as estimated.";
    TOO_LITTLE = "S109" "stage-failed" Warning "The data of a stage does not determine its parameters; they keep their values.";
    FEW_SPEEDS = "S110" "few-speeds" Note "A drag curve rests on few speeds; standard errors are widened by Student's \
                                           t.";
    GRAVITY = "S111" "net-weight-not-modelled" Note "The vehicle's net weight is known and the runs log pitch, but the model has no restoring_surge.";
    NO_GROUP = "S112" "group-not-measured" Warning "A run drives a group of thrusters for which no eta_inter was measured or given; 1 was used.";
    NO_PITCH = "S113" "no-pitch" Warning "The pitch of a steady run cannot be computed from the balance of moments: data of the vehicle or the thrusters' moment are missing.";
    NO_SUCH_RUN = "S114" "no-such-run" Warning "A steady window is given for a run that is not a constant-velocity or towing run of this campaign.";
}
