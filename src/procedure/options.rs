//! Options of the stages: the `[stage]` tables of a campaign.
//!
//! (i) `bollard`: η_inter, and thrust curves. (ii) `steady`: drag from constant-velocity and towing runs.
//! (iii) `oscillatory` and `zigzag`: inertia, coupling and bias, drag held. `direct`: the direct
//! regression, eq. (30).
//! Source: Avila, Donha and Adamowski, *Ocean Engineering* 60 (2013) 81-94.

use serde::{Deserialize, Serialize};

use crate::estimate::{SteadyOptions, SteadyWindow};
use crate::filter::{PolynomialFilter, Window};
use crate::least_squares::StdMethod;

/// Options of all stages. A stage without runs of its kind does not run; `skip` omits it although
/// there are runs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct StagedOptions {
    /// Interaction of thrusters.
    #[serde(skip_serializing_if = "is_default")]
    pub bollard: BollardStage,
    /// Drag.
    #[serde(skip_serializing_if = "is_default")]
    pub steady: SteadyStage,
    /// Inertia and bias of one degree of freedom at a time.
    #[serde(skip_serializing_if = "is_default")]
    pub oscillatory: OscillatoryStage,
    /// The horizontal plane, with Coriolis coupling.
    #[serde(skip_serializing_if = "is_default")]
    pub zigzag: ZigzagStage,
    /// All parameters at once with differentiated velocity, to be shown beside the others.
    #[serde(skip_serializing_if = "is_default")]
    pub direct: DirectStage,
    /// Standard deviations of the integral stages. `hac`: increments of a noisy velocity are
    /// correlated, which makes (14) too wide or too narrow.
    #[serde(skip_serializing_if = "is_default")]
    pub std: StdMethod,
    /// Filter whose slope gives a body rate from its angle if the rate is not logged. One second,
    /// second degree.
    pub rates: PolynomialFilter,
}

impl Default for StagedOptions {
    fn default() -> StagedOptions {
        StagedOptions {
            bollard: BollardStage::default(),
            steady: SteadyStage::default(),
            oscillatory: OscillatoryStage::default(),
            zigzag: ZigzagStage::default(),
            direct: DirectStage::default(),
            std: StdMethod::default(),
            rates: PolynomialFilter { window: Window::Seconds(1.0), degree: 2 },
        }
    }
}

impl StagedOptions {
    /// These options with one filter of the velocities in all stages of motion.
    #[must_use]
    pub fn filtered(mut self, filter: Option<PolynomialFilter>) -> StagedOptions {
        self.oscillatory.filter = filter;
        self.zigzag.filter = filter;
        self
    }
}

/// `[stage.bollard]`: equation (16).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BollardStage {
    /// Omits the stage.
    pub skip: bool,
    /// Nominal forces below this value, N or N·m, are not fitted. 0: the paper fits all, and a dead
    /// band shows in the residuals.
    pub least_force: f64,
    /// Last part of each constant command that counts as steady, 0 to 1. 0.5: the first half
    /// contains the start-up of the propeller and of the water around it. If a command changes all
    /// the time, every sample counts.
    pub steady_part: f64,
}

impl Default for BollardStage {
    fn default() -> BollardStage {
        BollardStage { skip: false, least_force: 0.0, steady_part: 0.5 }
    }
}

/// `[stage.steady]`: equations (18) and (19).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SteadyStage {
    /// Omits the stage.
    pub skip: bool,
    /// Last part of each run that is searched for steady windows, 0 to 1. 0.5: the first half is
    /// acceleration, and a remaining acceleration is taken for drag.
    pub steady_part: f64,
    /// Greatest drift of the speed over a window, as a fraction of the greatest speed of the run.
    /// 0.04: a drift of 5 % causes an error of some 10 % in quadratic drag, about the paper's own
    /// scatter.
    pub drift: f64,
    /// Greatest scatter about the drift (one standard deviation), as a fraction of the greatest
    /// speed of the run. 0.08: the paper's record of Fig. 7 scatters by 6 %.
    pub scatter: f64,
    /// Least length of a window, s.
    pub length: f64,
    /// Windows set by hand: a run that is named here has these and no others.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub windows: Vec<GivenWindow>,
    /// Whether drag in yaw has separate values clockwise and anticlockwise, if runs show both.
    pub per_direction: bool,
    /// Source of the pitch of (19).
    pub pitch: PitchSource,
    /// Height at which drag acts, m below the body origin; for `pitch = "moments"`.
    pub drag_height: f64,
}

impl Default for SteadyStage {
    fn default() -> SteadyStage {
        let SteadyOptions { drift, scatter, length } = SteadyOptions::default();
        SteadyStage {
            skip: false,
            steady_part: 0.5,
            drift,
            scatter,
            length,
            windows: Vec::new(),
            per_direction: true,
            pitch: PitchSource::Logged,
            drag_height: 0.0,
        }
    }
}

impl SteadyStage {
    /// Limits for a steady window.
    pub(super) fn limits(&self) -> SteadyOptions {
        SteadyOptions { drift: self.drift, scatter: self.scatter, length: self.length }
    }
}

/// A steady window set by hand.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GivenWindow {
    /// Name of the run, its file.
    pub run: String,
    /// Begin, s.
    pub from: f64,
    /// End, s.
    pub to: f64,
}

impl GivenWindow {
    pub(super) fn window(&self) -> SteadyWindow {
        SteadyWindow { from: self.from, to: self.to }
    }
}

/// Source of the pitch of (19).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PitchSource {
    /// The column `theta`.
    #[default]
    Logged,
    /// The balance of moments at constant speed: righting moment against thrust and drag.
    Moments,
}

/// `[stage.oscillatory]`: equations (20), (21), (26) and (27).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct OscillatoryStage {
    /// Omits the stage.
    pub skip: bool,
    /// Polynomial filter of the velocities; none by default, because the integral form does not
    /// differentiate and a filter correlates the noise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub filter: Option<PolynomialFilter>,
    /// Length of an integration interval in sample intervals. 1 is the paper's (5); at low rates and
    /// with noisy velocities several are less biased.
    pub window: usize,
    /// Holds the drag that the steady stage found. True: this is the paper's step (iii); a
    /// single-step fit of both is ill-conditioned.
    pub hold_drag: bool,
    /// Adds a stage for each run beside that of all runs together, as in the paper's Table 5.
    pub per_run: bool,
}

impl Default for OscillatoryStage {
    fn default() -> OscillatoryStage {
        OscillatoryStage { skip: false, filter: None, window: 1, hold_drag: true, per_run: true }
    }
}

/// `[stage.zigzag]`: equations (28) and (29).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ZigzagStage {
    /// Omits the stage.
    pub skip: bool,
    /// As in the oscillatory stage.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub filter: Option<PolynomialFilter>,
    /// As in the oscillatory stage.
    pub window: usize,
    /// As in the oscillatory stage.
    pub hold_drag: bool,
    /// As in the oscillatory stage.
    pub per_run: bool,
    /// How products of channels with different rates (u v at 3 Hz beside r at 9 Hz) get common time
    /// stamps.
    pub align: Align,
}

impl Default for ZigzagStage {
    fn default() -> ZigzagStage {
        ZigzagStage { skip: false, filter: None, window: 1, hold_drag: true, per_run: true, align: Align::Linear }
    }
}

/// How a slow channel is read at the time stamps of a fast one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Align {
    /// Linear interpolation between its neighbours. The default: velocity is continuous, and no
    /// delay arises.
    #[default]
    Linear,
    /// The last sample before, as an on-board computer has it; late by half a sample on average.
    Previous,
    /// Only time stamps at which both channels have a sample.
    Common,
}

/// `[stage.direct]`: equation (30).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DirectStage {
    /// Omits the stage. True: its parameters are not to be used, so it is shown only on request.
    pub skip: bool,
    /// Filter whose slope is the acceleration. Seven samples and second degree: three quarters of a
    /// second of the paper's yaw rate. The estimates depend on it (docs/staged.md), which is what
    /// the direct regression is meant to show.
    pub filter: PolynomialFilter,
}

impl Default for DirectStage {
    fn default() -> DirectStage {
        DirectStage { skip: true, filter: PolynomialFilter { window: Window::Samples(7), degree: 2 } }
    }
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_read_over_the_defaults() {
        let text = "std = 'paper'\n[oscillatory]\nwindow = 3\nfilter = { window = { seconds = 1.5 }, degree = 2 }\n[zigzag]\nalign = 'previous'\n[steady]\nwindows = [{ run = 'a.csv', from = 3.0, to = 9.0 }]";
        let stage: StagedOptions = toml::from_str(text).unwrap();
        assert_eq!((stage.oscillatory.window, stage.oscillatory.hold_drag), (3, true));
        assert_eq!(stage.oscillatory.filter.map(|f| f.window), Some(Window::Seconds(1.5)));
        assert_eq!((stage.zigzag.align, stage.std), (Align::Previous, StdMethod::Paper));
        assert_eq!(stage.steady.windows[0].window(), SteadyWindow { from: 3.0, to: 9.0 });
        assert_eq!(stage.bollard, BollardStage::default());
        assert_eq!(toml::from_str::<StagedOptions>(&toml::to_string(&stage).unwrap()).unwrap(), stage);
    }

    #[test]
    fn a_misspelt_option_is_refused() {
        for text in ["[steady]\nwindow = []", "[steady]\nwindows = [{ run = 'a', form = 1 }]", "stdd = 'hac'"] {
            assert!(toml::from_str::<StagedOptions>(text).is_err(), "{text}");
        }
    }
}
