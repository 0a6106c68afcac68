//! Report of a check: a light for each topic, findings, and the figures behind them.

use serde::Serialize;

use super::closed_loop::Loop;
use super::excitation::Excitation;
use super::lag::Lag;
use super::rates::ChannelRate;
use crate::finding::{Code, Finding};

/// Topic of a light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Topic {
    /// The file itself: what reading it found.
    Reading,
    /// Time stamps.
    Clock,
    /// Rates, held samples.
    Sampling,
    /// Values: sentinels, spikes, frozen and constant channels.
    Values,
    /// Units, signs and frames of the sensors against each other.
    Consistency,
    /// Commands against the motion: sign, delay, limits.
    Commands,
    /// Whether the run can show what is asked.
    Excitation,
    /// Whether a controller holds the motion.
    Loop,
}

impl Topic {
    /// All, in the order of the report.
    pub const ALL: [Topic; 8] = [
        Topic::Reading,
        Topic::Clock,
        Topic::Sampling,
        Topic::Values,
        Topic::Consistency,
        Topic::Commands,
        Topic::Excitation,
        Topic::Loop,
    ];
}

/// Traffic light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Light {
    /// Checked, nothing found.
    Green,
    /// Usable, subject to the finding.
    Amber,
    /// Not to be used before it is corrected.
    Red,
}

/// The light of one topic.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TopicLight {
    /// Topic.
    pub topic: Topic,
    /// Its light; `None` if the log has no data to judge it by.
    pub light: Option<Light>,
}

/// Kind of a fault of the log, for the discovery.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum FaultKind {
    /// Another unit or scale; factor = logged over true.
    Unit,
    /// The opposite sign; factor −1.
    Sign,
    /// Turned axes; factor = angle to add to the channel, rad.
    Frame,
    /// A lag; factor = s, positive if the channel, or the answer to it, is late.
    Delay,
}

/// A fault of the log that a model could mistake for an effect.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LogFault {
    /// Kind.
    pub kind: FaultKind,
    /// Channel.
    pub channel: String,
    /// Size, with the meaning given by [`FaultKind`].
    pub factor: f64,
}

/// Agreement of a channel with another one that shows the same quantity.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Agreement {
    /// Channel that is judged.
    pub channel: String,
    /// Reference, such as `d(psi)/dt`.
    pub against: String,
    /// Channel over reference; 1 if they agree.
    pub factor: f64,
    /// Standard deviation of the factor.
    pub std: f64,
    /// Angle between them in the horizontal plane, rad; only for velocities.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angle: Option<f64>,
    /// How much later than the channel the reference is, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lag: Option<Lag>,
}

/// Answer of a degree of freedom to its command.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Answer {
    /// Channel of the command.
    pub channel: String,
    /// Channel of the velocity.
    pub velocity: String,
    /// Acceleration per unit of command: 1/mass for a force.
    pub gain: f64,
    /// Its standard deviation.
    pub std: f64,
    /// Delay of the motion, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub delay: Option<Lag>,
    /// Whether it stands for commands that always vary with it: the gain is that of all of them.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub joined: bool,
}

/// Result of the check of one run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CheckReport {
    /// Name of the run, or the file.
    pub run: String,
    /// One light per topic.
    pub lights: Vec<TopicLight>,
    /// Findings; with those of reading, if the check was given any.
    pub findings: Vec<Finding>,
    /// The same faults in the form the discovery reports them.
    pub log_findings: Vec<LogFault>,
    /// Rate of each channel.
    pub rates: Vec<ChannelRate>,
    /// Sensors against each other.
    pub agreements: Vec<Agreement>,
    /// Commands against the motion.
    pub answers: Vec<Answer>,
    /// What the run can show.
    pub excitation: Vec<Excitation>,
    /// Speeds and their commands.
    pub loops: Vec<Loop>,
}

impl CheckReport {
    /// Returns the worst light.
    pub fn worst(&self) -> Light {
        self.lights.iter().filter_map(|l| l.light).max().unwrap_or(Light::Green)
    }

    /// Returns the light of a topic.
    pub fn light(&self, topic: Topic) -> Option<Light> {
        self.lights.iter().find(|l| l.topic == topic)?.light
    }
}

/// A finding of a check of this module, before it becomes a message about a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// Code.
    pub code: &'static Code,
    /// Channels concerned.
    pub channels: Vec<String>,
    /// Description in one sentence.
    pub text: String,
    /// Faults that it implies.
    pub faults: Vec<LogFault>,
}

impl Found {
    /// Returns a finding about channels.
    pub fn new(code: &'static Code, channels: &[&str], text: String) -> Found {
        Found { code, channels: channels.iter().map(|c| (*c).to_string()).collect(), text, faults: Vec::new() }
    }

    /// Adds a fault that it implies.
    #[must_use]
    pub fn fault(mut self, kind: FaultKind, channel: &str, factor: f64) -> Found {
        self.faults.push(LogFault { kind, channel: channel.to_string(), factor });
        self
    }
}
