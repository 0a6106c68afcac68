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
    HELD = "K101" "held-samples" Warning Sampling Amber "A slower sensor is written at the rate of the log: only the first of the repeated values is a measurement. Nothing need be done where they are taken as one (repeated = \"auto\" in [log], the default); log each sensor at its own rate where you can.";
    FROZEN = "K102" "frozen" Warning Values Amber "A sensor that otherwise never repeats a value stays at exactly one for long: it has lost its lock or its connection, and the driver writes the last value on. Cut the stretch with `from` and `to` or `where`, or make the logger leave such cells empty (missing = \"no_sample\").";
    COMMAND_SATURATION = "K103" "saturation" Note Commands Green "A command stays at its largest or smallest value for long: a limit was reached. Where the log holds what was sent to the thrusters, as it mostly does, nothing is wrong with it.";
    CLOCK_DRIFT = "K104" "clock-drift" Warning Clock Amber "A second column of time runs at another rate than t: one of the two is nominal and not measured. Take the one that was measured as t (columns.t); speeds and delays are off by the ratio of the rates otherwise.";
    CLOCK_STEP = "K105" "clock-step" Warning Clock Amber "The clock was set: t steps unlike its usual steps, or a second column of time jumps against it. Take a monotonic clock as t (columns.t), or make two runs of the log with `from` and `to`.";

    SMOOTHED = "K106" "smoothed" Warning Sampling Amber "An estimator has smoothed an angle: its error lasts for many samples, and these are worth few measurements. Log the sensor before the filter as well, and trust the deviations of what hangs on this angle less.";

    UNIT = "K111" "unit" Warning Consistency Red "Two channels that say the same differ by the factor of a unit, such as degrees for radians or mm/s for m/s. Give the unit in the header or as columns.NAME.unit in [log].";
    SIGN = "K112" "sign" Warning Consistency Red "Two channels that say the same have opposite signs: a sensor counts the other way, or stands turned round. Set columns.NAME.sign = -1 of the one that is wrong; where several of v, w, q and r disagree, the log has other axes: body_frame = \"flu\".";
    SCALE = "K113" "scale" Warning Consistency Amber "Two channels that say the same differ by a factor that is no unit's: a speed of sound, a gain or a calibration of one of them is off. Calibrate it, or set columns.NAME.scale of the one that is wrong.";
    FRAME = "K114" "frame" Warning Consistency Red "Velocity turned by the heading does not point where the position goes: axes are turned or swapped. Try body_frame = \"flu\" or earth_frame = \"enu\" in [log], and look whether x and y, or u and v, are exchanged in [log.columns].";
    MISALIGNED = "K115" "frame" Warning Consistency Amber "Velocity turned by the heading points a few degrees beside where the position goes: the velocity sensor is mounted turned, the compass has a deviation or the magnetic declination is not taken off, or a current sets the vehicle. Mend the mounting angle or the heading where the log is made.";
    LATENCY = "K116" "delay" Warning Consistency Amber "One sensor says later what another one has said: it filters, or its stamps are those of arrival. Stamp it when it is measured; a sensor with a log of its own is brought to the clock of the others by `clock_offset` in its [[run]].";
    POSITION_SCALE = "K117" "position-scale" Warning Consistency Amber "Metres of position do not agree with degrees of latitude and longitude: the metres are of another unit, or of a projection with a scale of its own. Take the position from one of the two.";

    DEAD_RATE = "K118" "dead-rate" Warning Values Red "An angle turns while its rate stays near zero: the gyro, or its column, is dead. Leave the column out; the angle tells the turn.";

    LEVER_ARM = "K119" "lever-arm" Warning Consistency Amber "The position is measured elsewhere on the vehicle than the velocity: an antenna or a beacon swings about the DVL as the vehicle turns. `hydrosysid discover` names the lever arm and puts it into the model; or bring both to the origin where the log is made.";

    COMMAND_SIGN = "K121" "sign" Warning Commands Red "A command accelerates the vehicle the wrong way, or a velocity goes against all thrusters: its sign, or the position and axis of its [[thruster]], is opposite, two commands are exchanged, or the log or the vehicle file has other axes (body_frame = \"flu\" in [log]). Turn one command with columns.NAME.sign = -1, or mend its [[thruster]] table. Where several commands are accused in v and w (or q and r) together, it is one frame that is wrong, not each of the thrusters: mend that first.";
    COMMAND_DELAY = "K122" "delay" Warning Commands Amber "The vehicle answers a command later, or earlier, than it is logged: thrusters take time to spin up, the command waits on its way, or command and motion are on two clocks. Put both on one clock, with `clock_offset` where they are in two logs; a true delay or lag of the thrusters is one of the effects that `hydrosysid discover` names.";
    COMMAND_UNIT = "K124" "unit" Warning Commands Red "The commands of thrusters go several times beyond what their [[thruster]] tables take, or never leave the dead band: they are in per cent, in pulse widths or in volts where parts of a full command are expected, or the other way round. Set unit or scale of the columns (columns.V1.scale = 0.01 for per cent), or mend `max` and `deadband`.";
    SIGN_DISAGREES = "K123" "sign" Warning Commands Amber "By the fewer of a vehicle's logs a command acts the wrong way, by the others the right way: a controller moved it in these few, or their column was turned.";

    EXCITATION = "K131" "excitation" Warning Excitation Amber "The run cannot show what is asked of it in this degree of freedom: the command hardly varies there, or motion and command are too small beside the noise. Add a run that drives it with changing amplitude and both ways (`hydrosysid plan` proposes one), hold its parameters, or leave it out of `dofs`.";
    AT_REST = "K134" "at-rest" Warning Excitation Amber "Nothing moves beyond the noise of its sensor: there is nothing to learn from the run. The vehicle was tied, on deck or not armed, or the columns are the wrong ones; leave the run out, or set [log.columns].";
    MODE_CLOSED_LOOP = "K133" "closed-loop" Warning Loop Amber "The log says by its modes that a controller steers: the command follows the motion there. Add runs in a manual mode, or an excitation on top of the controller; cut such stretches with `from` and `to` where there are others.";
    CLOSED_LOOP = "K132" "closed-loop" Warning Loop Amber "A controller holds the speed, or a command repeats the noise of a sensor: the command follows the motion, and their relation is the controller's, not the vehicle's. Add runs without the controller, or with steps or sines put on top of its output.";

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
