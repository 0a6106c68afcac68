//! Codes of the findings of reading a log.

use crate::finding::codes;

codes! {
    EMPTY_FILE = "L001" "empty-file" Error "The file holds no text at all, or blank lines only.";
    NO_DATA = "L002" "no-data" Error "There is a header but no row of data left to work with.";
    ENCODING = "L003" "encoding" Error "The bytes are not UTF-8 text: another encoding, a compressed file, or a block of NUL bytes after a power loss.";
    LINE_LENGTH = "L004" "line-length" Error "One line is longer than max_line_bytes: usually a file without line ends or a quote that is never closed.";
    QUOTE = "L005" "quote" Error "A quoted field is not closed, or something follows its closing quote.";
    HEADER = "L006" "header" Error "The first line is not a header: it holds numbers, or it is a comment and no comment option is set.";
    DELIMITER = "L007" "delimiter" Error "The header does not split at the delimiter but would at another one: set delimiter.";
    COLUMN_LIMIT = "L008" "column-limit" Error "The header has more columns than max_columns.";
    DUPLICATE_COLUMN = "L009" "duplicate-column" Error "Two columns have the same name, so it is not known which one is meant.";
    MISSING_COLUMN = "L010" "missing-column" Error "A column that is needed is not there under this name: give its header in columns.";
    UNIT_UNKNOWN = "L011" "unit" Error "The unit in the header or in columns is not one of the units that this column \
                                        accepts.";
    FIELD_COUNT = "L012" "field-count" Error "A row has more or fewer fields than the header.";
    PARSE = "L013" "parse" Error "A cell is not a number.";
    MISSING = "L014" "missing" Error "A cell is empty: set missing to drop the row or to read it as no new sample of this sensor.";
    NON_FINITE = "L015" "non-finite" Error "A cell is NaN, infinite, or too large for a 64-bit number.";
    TIME_FORMAT = "L016" "time-format" Error "A time stamp is an ISO 8601 date, or is not one although time_format says so.";
    TIME_ORDER = "L017" "time-not-increasing" Error "A time stamp is not later than the one before it: a repeated row, a clock set back, or a clock too coarse.";
    ONE_ROW = "L018" "too-few-rows" Error "A single row shows no motion.";
    EARTH_VELOCITY = "L019" "earth-velocity" Error "Velocities along earth axes are rotated to body axes by the attitude: this needs u, v, w at the same instants, and phi, theta, psi over the same time.";
    DERIVED = "L020" "derived" Error "Latitude and longitude, a quaternion, or speed and course over ground do not yield the position, the angles or the velocity.";

    TOO_FEW_ROWS = "L101" "too-few-rows" Warning "So few rows determine only a handful of parameters: a fit needs at least two rows more than parameters.";
    ROWS_DROPPED = "L102" "rows-dropped" Warning "Rows were left out because an option says so.";
    BLANK_LINE = "L103" "blank-line" Warning "A blank line stands between rows; it was skipped.";
    SHORT_LAST_FIELD = "L104" "no-final-newline-short-field" Warning "The file ends without a line end and its last number has fewer decimals than all others of its column: it may be truncated.";
    GAP = "L105" "gap" Warning "Time jumps forward, or one sensor falls silent while the others go on. Where all are silent, the run is split in two; where one is, no regression row that uses it spans the gap, and filter error and output error continue with the others.";
    TIME_UNIT = "L106" "time-unit" Warning "The usual step of time is implausible in this unit, or time is a counter of rows: check time_unit, or the scale of columns.t.";
    SENTINEL = "L107" "sentinel" Warning "A value far from all others recurs exactly: a sensor's code for 'no value'. List it in missing_values.";
    OUTLIER = "L108" "outlier" Warning "Single samples lie far from their neighbours.";
    MAGNITUDE = "L109" "implausible-magnitude" Warning "Single samples are larger than anything a vehicle does.";
    UNIT = "L110" "unit" Warning "The whole column is implausibly large in its unit: perhaps it is in another one.";
    HELD = "L111" "held-samples" Warning "Values repeat in steps: a slower sensor was written at the rate of the log. Each of its samples is used once, unless the option `repeated` says that all are measurements or the log is read piece by piece.";
    CONSTANT = "L112" "constant-column" Warning "A measured column never changes, or a rate stays below what any gyro shows at rest: nothing can be learned from it.";
    SATURATION = "L113" "saturation" Warning "A column stays at its largest or smallest value for long: a limit of the sensor or of the actuator.";
    NON_PHYSICAL = "L114" "non-physical" Warning "A quick fit gives a negative inertia or drag: most likely a sign or a frame is wrong.";
    FRAME = "L115" "frame" Warning "The vehicle would be upside down: body_frame and earth_frame do not fit the angles.";
    NO_COMMAND = "L116" "no-command" Warning "All commands are zero: no force is known. If the vehicle was driven, its commands are in other columns.";

    IGNORED = "L201" "ignored-columns" Note "Columns that are not numeric, or not in every row, and that were not requested.";
    NO_FINAL_NEWLINE = "L202" "no-final-newline" Note "The last row has no line end; its fields are complete.";
    UNEVEN_COMMAND = "L203" "uneven-command" Note "A command with its own time stamps comes at uneven steps: set input = \"hold\" if a command is logged only when it changes.";
    REPEATED = "L204" "repeated-values" Note "Values that a slower sensor's channel merely repeats were treated as no sample, because an option says so.";
    CLOCK = "L211" "clock" Note "Which clock the time stamps of a log in another format come from; `clock` selects one.";
    ORIGIN = "L212" "time-origin" Note "Time stamps of a wall clock: the first one is t = 0.";
    NO_SAMPLE = "L213" "no-sample" Note "Samples were left out because an option excludes them: invalid, missing or repeated.";
    LEFT_OUT = "L215" "stream-left-out" Note "A topic of a log in another format cannot be decoded and is left out: its type is not known, or the log does not hold its definition. The others are read.";
    OTHER_FORMAT = "L216" "other-format" Error "The first bytes show that the file is a log in another format, not CSV. With the command of the Python package, `hydrosysid init` reads it and writes a campaign, and `hydrosysid convert` turns it into CSV.";
    TURNED = "L214" "earth-to-body" Note "Velocities logged along earth axes were rotated to body axes by the logged attitude.";
    TOLD = "L217" "told-in-other-words" Note "A channel is computed from others, as `[log.columns]` says: x, y from latitude and longitude, phi, theta, psi from a quaternion, u, v from speed and course over ground.";
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_unique() {
        let codes: std::collections::BTreeSet<_> = ALL.iter().map(|c| c.code).collect();
        assert_eq!(codes.len(), ALL.len());
    }
}
