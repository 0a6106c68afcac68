//! Codes of this module, and the topic and light of each.

use super::report::{Light, Topic};
use crate::finding::codes;

macro_rules! placed {
    ($($name:ident = $code:literal $kind:literal $severity:ident $topic:ident $light:ident $meaning:literal;)*) => {
        codes! { $($name = $code $kind $severity $meaning;)* }
        /// Topic and light of a code of this module; `None` for a code of another one.
        pub fn place(code: &str) -> Option<(Topic, Light)> {
            match code { $($code => Some((Topic::$topic, Light::$light)),)* _ => None }
        }
    };
}

placed! {
    HELD = "K101" "held-samples" Warning Sampling Amber "A slower sensor is written at the rate of the log: only the first of the repeated values is a measurement. With repeated = \"auto\" in [log] (the default) they count as one sample, and nothing need be done; log each sensor at its own rate where you can.";
    FROZEN = "K102" "frozen" Warning Values Amber "A sensor that otherwise never repeats a value stays at exactly one value for long: it has lost its lock or its connection, and the driver repeats the last value. Cut the stretch with `from` and `to` or `where`, or make the logger leave such cells empty (missing = \"no_sample\").";
    COMMAND_SATURATION = "K103" "saturation" Note Commands Green "A command stays at its largest or smallest value for long: a limit was reached. If the log holds what was actually sent to the thrusters, as most logs do, nothing is wrong.";
    CLOCK_DRIFT = "K104" "clock-drift" Warning Clock Amber "A second time column runs at a different rate from t: one of the two is nominal, not measured. Use the measured one as t (columns.t); otherwise speeds and delays are off by the ratio of the rates.";
    CLOCK_STEP = "K105" "clock-step" Warning Clock Amber "The clock was set: a step of t differs from its usual step, or a second time column jumps relative to t. Use a monotonic clock as t (columns.t), or split the log into two runs with `from` and `to`.";

    SMOOTHED = "K106" "smoothed" Warning Sampling Amber "An estimator has smoothed an angle: its error is correlated over many samples, which together are worth only a few measurements. Log the unfiltered sensor as well, and trust the standard errors of what depends on this angle less.";

    UNIT = "K111" "unit" Warning Consistency Red "Two channels that measure the same quantity differ by the factor of a unit, such as degrees for radians or mm/s for m/s. Give the unit in the header or as columns.NAME.unit in [log].";
    SIGN = "K112" "sign" Warning Consistency Red "Two channels that measure the same quantity have opposite signs: a sensor has the opposite sign convention or is mounted the other way round. Set columns.NAME.sign = -1 for the wrong one; where several of v, w, q and r disagree, the log uses other axes: body_frame = \"flu\".";
    SCALE = "K113" "scale" Warning Consistency Amber "Two channels that measure the same quantity differ by a factor that no unit explains: a speed of sound, a gain or a calibration of one of them is off. Calibrate it, or set columns.NAME.scale for the wrong one.";
    FRAME = "K114" "frame" Warning Consistency Red "The velocity, rotated by the heading, does not point along the path of the position: axes are rotated or swapped. Try body_frame = \"flu\" or earth_frame = \"enu\" in [log], and check whether x and y, or u and v, are exchanged in [log.columns].";
    MISALIGNED = "K115" "frame" Warning Consistency Amber "The velocity, rotated by the heading, points a few degrees off the path of the position: the velocity sensor is mounted at an angle, the compass has a deviation, the magnetic declination is not corrected, or a current sets the vehicle. Correct the mounting angle or the heading where the log is made.";
    LATENCY = "K116" "delay" Warning Consistency Amber "One sensor lags another: it filters, or its time stamps are those of arrival. Stamp each sample when it is measured; for a sensor with its own log, `clock_offset` in its [[run]] aligns its clock with the others.";
    POSITION_SCALE = "K117" "position-scale" Warning Consistency Amber "The position in metres does not agree with latitude and longitude: the metres are in another unit, or come from a projection with a scale factor. Take the position from one of the two.";

    DEAD_RATE = "K118" "dead-rate" Warning Values Red "An angle turns while its rate stays near zero: the gyro, or its column, is dead. Leave the column out; the angle shows the rotation.";

    LEVER_ARM = "K119" "lever-arm" Warning Consistency Amber "The position is measured elsewhere on the vehicle than the velocity: an antenna or a beacon swings about the DVL as the vehicle turns. `hydrosysid discover` estimates the lever arm and adds it to the model; or refer both to the body origin where the log is made.";

    COMMAND_SIGN = "K121" "sign" Warning Commands Red "A command accelerates the vehicle the wrong way, or a velocity opposes all thrusters: its sign, or the position or axis of its [[thruster]], is reversed, two commands are exchanged, or the log or the vehicle file uses other axes (body_frame = \"flu\" in [log]). Reverse one command with columns.NAME.sign = -1, or correct its [[thruster]] table. Where several commands look wrong in v and w (or q and r) together, the frame is wrong, not each of the thrusters: correct that first.";
    COMMAND_DELAY = "K122" "delay" Warning Commands Amber "The vehicle answers a command later, or earlier, than it is logged: thrusters take time to spin up, the command is delayed on its way, or command and motion have different clocks. Bring both to one clock, with `clock_offset` if they are in two logs; a true delay or lag of the thrusters is one of the effects that `hydrosysid discover` finds.";
    COMMAND_UNIT = "K124" "unit" Warning Commands Red "The commands of thrusters exceed the limits in their [[thruster]] tables several times over, or never leave the dead band: they are in per cent, pulse widths or volts where fractions of a full command are expected, or the reverse. Set unit or scale of the columns (columns.V1.scale = 0.01 for per cent), or correct `max` and `deadband`.";
    SIGN_DISAGREES = "K123" "sign" Warning Commands Amber "In a minority of a vehicle's logs a command acts the wrong way, in the others the right way: a controller moved it in those few, or their column has the opposite sign.";

    EXCITATION = "K131" "excitation" Warning Excitation Amber "The run cannot identify the parameters of this degree of freedom: the command hardly varies there, or motion and command are too small compared with the noise. Add a run that drives it in both directions with changing amplitude (`hydrosysid plan` proposes one), fix its parameters, or leave it out of `dofs`.";
    AT_REST = "K134" "at-rest" Warning Excitation Amber "Nothing moves beyond the noise of its sensor: there is nothing to learn from the run. The vehicle was moored, on deck or not armed, or the wrong columns are read; leave the run out, or set [log.columns].";
    MODE_CLOSED_LOOP = "K133" "closed-loop" Warning Loop Amber "The logged modes say that a controller steers: the command depends on the motion there. Add runs in a manual mode, or an excitation on top of the controller; if other stretches remain, cut these with `from` and `to`.";
    CLOSED_LOOP = "K132" "closed-loop" Warning Loop Amber "A controller holds the speed, or a command repeats the noise of a sensor: the command depends on the motion, and their relation is the controller's, not the vehicle's. Add runs without the controller, or with steps or sines added to its output.";

    GUESSED = "K201" "guessed-columns" Note Consistency Green "Columns were guessed from their names; name them in the options to be sure.";
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
