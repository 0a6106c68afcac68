//! The codes of this room, and the topic and light that each belongs to.

use super::report::{Light, Topic};
use crate::finding::codes;

macro_rules! placed {
    ($($name:ident = $code:literal $kind:literal $severity:ident $topic:ident $light:ident $meaning:literal;)*) => {
        codes! { $($name = $code $kind $severity $meaning;)* }
        /// Topic and light of a code of this room, `None` for another room's.
        pub fn place(code: &str) -> Option<(Topic, Light)> {
            match code { $($code => Some((Topic::$topic, Light::$light)),)* _ => None }
        }
    };
}

placed! {
    HELD = "K101" "held-samples" Warning Sampling Amber "A slower sensor is written at the rate of the log: only the first of the repeated values is a measurement.";
    FROZEN = "K102" "frozen" Warning Values Amber "A sensor that otherwise never repeats a value stays at exactly one for long.";
    COMMAND_SATURATION = "K103" "saturation" Note Commands Green "A command stays at its largest or smallest value for long: a limit was reached. Where the log holds what was sent to the thrusters, as it mostly does, nothing is wrong with it.";
    CLOCK_DRIFT = "K104" "clock-drift" Warning Clock Amber "A second column of time runs at another rate than t: one of the two is nominal and not measured.";
    CLOCK_STEP = "K105" "clock-step" Warning Clock Amber "The clock was set: t steps unlike its usual steps, or a second column of time jumps against it.";

    SMOOTHED = "K106" "smoothed" Warning Sampling Amber "An estimator has smoothed an angle: its error lasts for many samples, and these are worth few measurements.";

    UNIT = "K111" "unit" Warning Consistency Red "Two channels that say the same differ by the factor of a unit.";
    SIGN = "K112" "sign" Warning Consistency Red "Two channels that say the same have opposite signs.";
    SCALE = "K113" "scale" Warning Consistency Amber "Two channels that say the same differ by a factor that is no unit's.";
    FRAME = "K114" "frame" Warning Consistency Red "Velocity turned by the heading does not point where the position goes: axes are turned or swapped.";
    MISALIGNED = "K115" "frame" Warning Consistency Amber "Velocity turned by the heading points a few degrees beside where the position goes.";
    LATENCY = "K116" "delay" Warning Consistency Amber "One sensor says later what another one has said.";
    POSITION_SCALE = "K117" "position-scale" Warning Consistency Amber "Metres of position do not agree with degrees of latitude and longitude.";

    DEAD_RATE = "K118" "dead-rate" Warning Values Red "An angle turns while its rate stays near zero: the gyro, or its column, is dead. Leave the column out; the angle tells the turn.";

    COMMAND_SIGN = "K121" "sign" Warning Commands Red "A command accelerates the vehicle the wrong way, or a velocity goes against all thrusters.";
    COMMAND_DELAY = "K122" "delay" Warning Commands Amber "The vehicle answers a command later, or earlier, than it is logged.";
    SIGN_DISAGREES = "K123" "sign" Warning Commands Amber "By the fewer of a vehicle's logs a command acts the wrong way, by the others the right way: a controller moved it in these few, or their column was turned.";

    EXCITATION = "K131" "excitation" Warning Excitation Amber "The run cannot show what is asked of it in this degree of freedom.";
    AT_REST = "K134" "at-rest" Warning Excitation Amber "Nothing moves beyond the noise of its sensor: there is nothing to learn from the run.";
    MODE_CLOSED_LOOP = "K133" "closed-loop" Warning Loop Amber "The log says by its modes that a controller steers: the command follows the motion there.";
    CLOSED_LOOP = "K132" "closed-loop" Warning Loop Amber "A controller holds the speed, or a command repeats the noise of a sensor: the command follows the motion, and their relation is the controller's, not the vehicle's.";

    GUESSED = "K201" "guessed-columns" Note Consistency Green "Columns were taken for what their names suggest; name them in the options to be sure.";
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_unique_and_have_a_place() {
        let codes: std::collections::BTreeSet<_> = ALL.iter().map(|c| c.code).collect();
        assert_eq!(codes.len(), ALL.len());
        assert!(ALL.iter().all(|c| place(c.code).is_some()));
        assert_eq!(place("L101"), None);
    }
}
