//! What a check reports: a light for each topic, findings, and the figures behind them.

use serde::Serialize;

use super::closed_loop::Loop;
use super::excitation::Excitation;
use super::lag::Lag;
use super::rates::ChannelRate;
use crate::finding::{Code, Finding};

/// What a light stands for.
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
    /// Whether a controller holds what should move.
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
    /// Looked at, nothing found.
    Green,
    /// Usable, with what the finding says in mind.
    Amber,
    /// Not to be used before it is mended.
    Red,
}

/// The light of one topic.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TopicLight {
    /// Topic.
    pub topic: Topic,
    /// Its light; `None` where the log holds nothing to judge it by.
    pub light: Option<Light>,
}

/// What a fault of the log is, for the discovery.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum FaultKind {
    /// Another unit or scale; factor = logged over true.
    Unit,
    /// The opposite sign; factor −1.
    Sign,
    /// Turned axes; factor = angle to add to the channel, rad.
    Frame,
    /// A lag; factor = s, positive when the channel's effect or news comes late.
    Delay,
}

/// A fault of the log that a model could mistake for an effect.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LogFault {
    /// What it is.
    pub kind: FaultKind,
    /// Channel.
    pub channel: String,
    /// How much, by [`FaultKind`].
    pub factor: f64,
}

/// How one channel agrees with another that says the same.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Agreement {
    /// Channel that is judged.
    pub channel: String,
    /// What it is held against, `d(psi)/dt`.
    pub against: String,
    /// Channel over what it is held against; 1 when they agree.
    pub factor: f64,
    /// Standard deviation of the factor.
    pub std: f64,
    /// Angle between them in the horizontal plane, rad; only for velocities.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angle: Option<f64>,
    /// How much later than the channel the other one is, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lag: Option<Lag>,
}

/// How a degree of freedom answers its command.
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
    /// How much later the motion answers, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub delay: Option<Lag>,
    /// Whether it stands for commands that always go with it: the gain is theirs together.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub joined: bool,
}

/// Everything a check says about one run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CheckReport {
    /// Name of the run, or the file.
    pub run: String,
    /// One light a topic.
    pub lights: Vec<TopicLight>,
    /// What was found; from reading the log too, when the check was given one.
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
    /// The worst light.
    pub fn worst(&self) -> Light {
        self.lights.iter().filter_map(|l| l.light).max().unwrap_or(Light::Green)
    }

    /// The light of a topic.
    pub fn light(&self, topic: Topic) -> Option<Light> {
        self.lights.iter().find(|l| l.topic == topic)?.light
    }
}

/// One thing a check of this room found, before it is put into words for a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// Code.
    pub code: &'static Code,
    /// Channels concerned.
    pub channels: Vec<String>,
    /// What, in one sentence.
    pub text: String,
    /// The faults it means.
    pub faults: Vec<LogFault>,
}

impl Found {
    /// A finding about channels.
    pub fn new(code: &'static Code, channels: &[&str], text: String) -> Found {
        Found { code, channels: channels.iter().map(|c| (*c).to_string()).collect(), text, faults: Vec::new() }
    }

    /// With the fault it means.
    #[must_use]
    pub fn fault(mut self, kind: FaultKind, channel: &str, factor: f64) -> Found {
        self.faults.push(LogFault { kind, channel: channel.to_string(), factor });
        self
    }
}
