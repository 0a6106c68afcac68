//! One log: assigns its columns to channels and finds its reading options, each with the reason.

use std::collections::BTreeMap;
use std::path::Path;

use super::commands::{self, COMMAND, FORCE, Kind, names};
use super::layout::{self, Layout};
use super::meaning::{self, Meaning};
use super::told::Told;
use super::words::{self, Words};
use super::{alike, altitude, drives, dvl_axes, fins, parts, ros, speeds, turning, units, values};
use crate::frame::Dof;
use crate::log::columns::Quantity;
use crate::log::options::{BodyFrame, ColumnSource, EarthFrame, VelocityReference};
use crate::log::{self, LogFile, LogOptions, columns};
use crate::run::Run;

/// Quantities that a thruster's command may have.
const COMMANDS: &[Quantity] = &[Quantity::Command, Quantity::Force];

/// A log with its channels and reading options, as far as they were found.
#[derive(Debug, Clone, Default)]
pub struct Understood {
    /// Path of the file as the campaign names it.
    pub shown: String,
    /// Options that the user has given: they take precedence.
    pub given: LogOptions,
    /// Options with which the log is read.
    pub options: LogOptions,
    /// Reason of each option and column that was guessed: `missing`, `columns.psi`.
    pub reasons: BTreeMap<String, String>,
    /// Alternative columns of a channel.
    pub choices: BTreeMap<String, Vec<ColumnSource>>,
    /// Names of its columns: logs with the same names are written alike.
    pub headers: Vec<String>,
    /// Change of the heading over the integral of the yaw rate as first read: negative if the rate
    /// counts the other way.
    pub turns: Option<f64>,
    /// Remarks for the campaign: columns that were not placed, and other meanings of a column.
    pub remarks: Vec<String>,
    /// Commands of the thrusters, in the order of V1, V2, …
    pub commands: Vec<commands::Column>,
    /// Unit of the commands.
    pub kind: Option<Kind>,
    /// The log; `None` if it could not be read.
    pub log: Option<LogFile>,
    /// Reasons why it could not be read.
    pub refused: Vec<String>,
}

/// Finds the channels and reading options of the log at `path`; `given` are the user's options,
/// which take precedence.
pub fn understand(path: &Path, shown: &str, given: &LogOptions) -> Understood {
    let mut this =
        Understood { shown: shown.to_string(), given: given.clone(), options: given.clone(), ..Understood::default() };
    let layout = match layout::of(path, given) {
        Ok(layout) => layout,
        Err(error) => {
            this.refused.push(error.to_string());
            return this;
        }
    };
    if let Some(what) = layout.no_csv {
        this.refused.push(what);
        return this;
    }
    this.headers.clone_from(&layout.headers);
    this.lay_out(&layout, given);
    if layout.nameless() {
        this.refused.push("the columns have no names: put a header line first, such as t,u,r,V1,V2".into());
        return this;
    }
    this.place(&layout, given);
    if let Some(what) = this.table(&layout) {
        this.refused.push(what);
        return this;
    }
    this.attempt(path);
    this
}

/// Decides what only the values of all logs together tell, and reads the logs again whose options
/// change. `thrusters`: number of thrusters of the vehicle; `full_rpm`: turns a minute of a full
/// command, if they are known.
pub fn settle(logs: &mut [Understood], paths: &[&Path], thrusters: Option<usize>, full_rpm: Option<f64>) {
    let placed_anew = drives::place_anew(logs, thrusters);
    for (k, (log, path)) in logs.iter_mut().zip(paths).enumerate() {
        // the steps below need the new commands and time stamps in seconds
        if values::counter(log) || placed_anew.contains(&k) {
            log.attempt(path);
        }
    }
    let before: Vec<LogOptions> = logs.iter().map(|log| log.options.clone()).collect();
    altitude::settle(logs);
    turning::settle(logs);
    logs.iter_mut().for_each(values::settle);
    speeds::settle(logs);
    parts::settle(logs);
    values::depth(logs);
    values::agree(logs);
    dvl_axes::settle(logs);
    drives::settle(logs, full_rpm);
    alike::settle(logs);
    for ((log, path), before) in logs.iter_mut().zip(paths).zip(&before) {
        if log.log.is_some() && log.options != *before {
            log.attempt(path);
        }
    }
    for k in fins::settle(logs) {
        logs[k].attempt(paths[k]);
    }
}

impl Understood {
    /// Its channels as a run; `None` if it could not be read.
    pub fn as_run(&self) -> Option<Run> {
        Some(Run { signals: self.log.as_ref()?.signals.clone(), ..Run::default() })
    }

    /// Notes the reason of an option that was guessed.
    pub fn guess(&mut self, key: impl Into<String>, reason: impl Into<String>) {
        self.reasons.insert(key.into(), reason.into());
    }

    fn lay_out(&mut self, layout: &Layout, given: &LogOptions) {
        if layout.delimiter != given.delimiter {
            self.options.delimiter = layout.delimiter;
            self.guess("delimiter", "header and rows split into equally many fields at it");
        }
        if layout.decimal != given.decimal {
            self.options.decimal = layout.decimal;
            self.guess("decimal", "numbers contain a comma and no point");
        }
        if layout.comment != given.comment {
            self.options.comment.clone_from(&layout.comment);
            let why = match layout.two_headers {
                true => "of two header lines the first says where the columns come from: it is skipped",
                false => "lines before the header start with it",
            };
            self.guess("comment", why);
        }
        if layout.unit_row && !given.unit_row {
            self.options.unit_row = true;
            self.guess("unit_row", "the line below the header holds words where the next ones hold numbers");
        }
    }

    /// Assigns each header to its channel.
    fn place(&mut self, layout: &Layout, given: &LogOptions) {
        let taken = |header: &str| {
            let base = columns::split_header(header).0;
            given.columns.values().any(|s| s.name.trim() == header || s.name.trim() == base)
        };
        let mut meant: Vec<(Meaning, String, Words)> = Vec::new();
        let mut driven: Vec<commands::Column> = Vec::new();
        let mut left: Vec<String> = Vec::new();
        let mut own: Vec<String> = given.columns.keys().cloned().collect();
        for header in layout.headers.iter().filter(|h| !h.is_empty() && !taken(h)) {
            let words = words::of(header);
            let (base, unit) = columns::split_header(header);
            if let Some(quantity) = columns::quantity(base).filter(|_| !own.iter().any(|o| o == base)) {
                let all = if quantity == Quantity::Command { COMMANDS } else { &[quantity] };
                if let Some(unit) = units::unknown(all, header, words.unit.as_deref()) {
                    self.set_aside(base, header, unit);
                    continue;
                }
                own.push(base.to_string());
                if let Some(command) = commands::of(header, &words) {
                    driven.push(command);
                } else if unit.is_some_and(|u| !u.is_empty() && quantity.unit(u).is_none()) {
                    self.map(base, header, &words, 1, "its unit");
                }
                continue;
            }
            if let Some(command) = commands::of(header, &words) {
                match units::unknown(COMMANDS, header, words.unit.as_deref()) {
                    Some(unit) => self.remarks.push(units::left_out("V1", header, unit)),
                    None => driven.push(command),
                }
                continue;
            }
            let meanings = meaning::of(&words);
            match meanings.first() {
                Some(best) => meant.push((best.clone(), header.clone(), words)),
                None => left.push(header.clone()),
            }
        }
        left.extend(wanted_angles(&mut meant));
        // the column that fits best is taken, the others are named as alternatives
        meant.sort_by_key(|(m, ..)| std::cmp::Reverse(m.score));
        let mut told = Told::default();
        for (meaning, header, words) in meant {
            let quantity = columns::quantity(meaning.channel);
            if let Some(unit) = units::unknown(quantity.as_slice(), &header, words.unit.as_deref()) {
                self.remarks.push(units::left_out(meaning.channel, &header, unit));
                continue;
            }
            told.note_ground(&header, &words);
            if !own.iter().any(|o| o == meaning.channel) && told.take(meaning.channel, &header, &words) {
                continue;
            }
            // a doubtful name (a course for the heading) gives way to a group that tells the
            // channel
            if meaning.score < meaning::PLAIN && told.tells(meaning.channel) {
                continue;
            }
            if own.iter().any(|o| o == meaning.channel) {
                let channel = meaning.channel;
                if self.options.columns.contains_key(channel) && !given.columns.contains_key(channel) {
                    let (other, _) = units::source(channel, &header, words.unit.as_deref(), meaning.sign);
                    self.choices.entry(channel.to_string()).or_default().push(other);
                    continue;
                }
                self.remarks.push(format!("{header:?} could also be {channel}: {channel} = {header:?}"));
                continue;
            }
            own.push(meaning.channel.to_string());
            let why = if meaning.score >= meaning::PLAIN { "its name" } else { "its name, with doubt" };
            self.map(meaning.channel, &header, &words, meaning.sign, why);
            self.refer(meaning.channel, &header, &words);
        }
        self.place_told(&told, layout, &mut own, &mut left);
        self.planar_theta(&own);
        self.ros(layout);
        self.time(layout, &mut own, &mut left);
        if !own.iter().any(|c| log::check::is_velocity(c) || log::check::is_measured(c)) {
            self.bench(&mut driven, &mut left);
        } else if driven.iter().all(|column| column.kind == Some(Kind::Turns)) {
            // the measured thrust of a single propeller tells more than its turns
            let pushes = left.iter().position(|header| commands::push(header, &words::of(header)).is_some());
            if let Some(header) = pushes.filter(|_| !own.iter().any(|c| c.starts_with("tau_"))).map(|k| left.remove(k))
            {
                driven.extend(commands::push(&header, &words::of(&header)));
            }
        }
        self.drive(&driven, given);
        if !left.is_empty() {
            let list: Vec<String> = left.iter().map(|h| format!("{h:?}")).collect();
            self.remarks.push(format!("not recognised, kept under their own names: {}", list.join(", ")));
        }
    }

    /// Sets `columns.channel`.
    fn map(&mut self, channel: &str, header: &str, words: &Words, sign: i8, why: &str) {
        let (source, how) = units::source(channel, header, words.unit.as_deref(), sign);
        // a column with the channel's own name and a known unit needs no entry
        if source == ColumnSource::from(header) && columns::split_header(header).0 == channel {
            return;
        }
        self.options.columns.insert(channel.to_string(), source);
        self.guess(format!("columns.{channel}"), format!("{header:?} is {channel} by {why}{how}"));
    }

    /// Keeps a column with a known name and an unknown unit under another name: the reader would
    /// refuse the log for it.
    fn set_aside(&mut self, channel: &str, header: &str, unit: &str) {
        let other = format!("{channel}_as_logged");
        self.options.columns.insert(other.clone(), ColumnSource::from(header));
        self.guess(format!("columns.{other}"), units::left_out(channel, header, unit));
    }

    /// Sets the axes of ROS if the columns are fields of its messages, as in a table of a bag.
    fn ros(&mut self, layout: &Layout) {
        let usual = LogOptions::default();
        let unsaid = self.given.body_frame == usual.body_frame && self.given.earth_frame == usual.earth_frame;
        let Some(field) = ros::field(&layout.headers).filter(|_| unsaid) else { return };
        let why = format!("{field:?} is a field of a ROS message, whose axes are assumed to be those of REP 103");
        self.options.body_frame = BodyFrame::Flu;
        self.guess("body_frame", format!("{why}: forward, port, up (\"frd\" if they are forward, starboard, down)"));
        self.options.earth_frame = EarthFrame::Enu;
        self.guess("earth_frame", format!("{why}: east, north, up (\"ned\" if they are north, east, down)"));
    }

    /// Sets the velocity reference to water if a velocity's name says that it is measured through
    /// the water.
    fn refer(&mut self, channel: &str, header: &str, words: &Words) {
        let name = words.words.join(" ");
        let through =
            ["through water", "through the water", "stw", "water speed"].iter().any(|said| name.contains(said));
        if through && log::check::is_velocity(channel) && self.given.velocity_reference.is_none() {
            self.options.velocity_reference = Some(VelocityReference::Water);
            self.guess("velocity_reference", format!("{header:?} is a velocity through the water by its name"));
        }
    }

    /// Reads "theta" as the heading in a planar log: one with x and y and no other angle.
    fn planar_theta(&mut self, own: &[String]) {
        let has = |channel: &str| own.iter().any(|o| o == channel);
        let said = self.given.columns.contains_key("theta");
        if said || !["x", "y", "theta"].into_iter().all(has) || ["psi", "phi", "z", "q"].into_iter().any(has) {
            return;
        }
        let source = self.options.columns.remove("theta").unwrap_or_else(|| ColumnSource::from("theta"));
        if words::of(&source.name).words != ["theta"] {
            self.options.columns.insert("theta".into(), source);
            return;
        }
        self.reasons.remove("columns.theta");
        self.guess(
            "columns.psi",
            format!("{:?} stands next to x and y without another angle: the heading", source.name),
        );
        self.options.columns.insert("psi".into(), source);
    }

    /// Places force and command of a log without motion: a thruster on a bench.
    fn bench(&mut self, driven: &mut Vec<commands::Column>, left: &mut Vec<String>) {
        let has = |header: &str, wanted: &[&str]| names(&words::of(header), wanted);
        let force = left.iter().find(|h| has(h, FORCE)).cloned();
        let command = left.iter().find(|h| has(h, COMMAND)).cloned();
        if let Some(header) = &force {
            left.retain(|h| h != header);
            self.map("force", header, &words::of(header), 1, "its name, with doubt");
        }
        if let Some(header) = command.filter(|_| driven.is_empty() && force.is_some()) {
            left.retain(|h| *h != header);
            driven.push(commands::single(&header, &words::of(&header)));
        }
    }

    /// Places the commands of the thrusters: those that the user has given, else the chosen group.
    fn drive(&mut self, driven: &[commands::Column], given: &LogOptions) {
        let said = commands::given(given);
        if !said.is_empty() {
            self.kind = said[0].kind;
            self.commands = said;
            return;
        }
        let chosen = commands::chosen(driven);
        for other in driven.iter().filter(|c| !chosen.contains(c)) {
            self.remarks.push(format!("{:?} may also be a command and is not used", other.header));
        }
        self.assign(chosen);
    }

    /// Replaces the commands, by others or by the same as another kind.
    pub(super) fn assign_anew(&mut self, chosen: Vec<commands::Column>) {
        for (k, column) in self.commands.clone().iter().enumerate() {
            self.options.columns.retain(|_, source| source.name != column.header);
            for letter in ["V", "F"] {
                self.reasons.remove(&format!("columns.{letter}{}", k + 1));
            }
        }
        self.assign(chosen);
    }

    /// Writes the commands as V1, V2, … or F1, F2, …
    fn assign(&mut self, chosen: Vec<commands::Column>) {
        self.kind = chosen.first().and_then(|c| c.kind);
        let letter = if self.kind == Some(Kind::Force) { "F" } else { "V" };
        for (k, column) in chosen.iter().enumerate() {
            let channel = format!("{letter}{}", k + 1);
            let unit = words::of(&column.header).unit;
            let (source, mut how) = units::source(&channel, &column.header, unit.as_deref(), 1);
            if commands::is_force_by_name(column) {
                how += "; its name gives no unit: N is assumed";
            }
            if columns::split_header(&column.header).0 != channel
                || source != ColumnSource::from(column.header.as_str())
            {
                self.options.columns.insert(channel.clone(), source);
                let why = format!("{:?} is the command of thruster {} by its name{how}", column.header, column.label);
                self.guess(format!("columns.{channel}"), why);
            }
        }
        self.commands = chosen;
    }
}

/// Removes, and returns, headers that may be a desired angle: `cmd_yaw` is a moment only beside the
/// command of a force, `cmd_surge`.
fn wanted_angles(meant: &mut Vec<(Meaning, String, Words)>) -> Vec<String> {
    let is = |m: &Meaning, dofs: &[Dof]| {
        m.score == meaning::BY_DEGREE_OF_FREEDOM && dofs.iter().any(|dof| dof.force() == m.channel)
    };
    if meant.iter().any(|(m, ..)| is(m, &Dof::ALL[..3])) {
        return Vec::new();
    }
    let angles = meant.extract_if(.., |(m, ..)| is(m, &Dof::ALL[3..]));
    angles.map(|(_, header, _)| header).collect()
}
