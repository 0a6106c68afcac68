//! Options of the stages: the `[stage]` tables of a campaign.
//!
//! (i) `bollard`: η_inter, and thrust curves. (ii) `steady`: drag from constant-velocity and towing runs.
//! (iii) `oscillatory` and `zigzag`: inertia, coupling and bias, drag held. `direct`: the cautionary twin, eq. (30).
//! Source: Avila, Donha and Adamowski, *Ocean Engineering* 60 (2013) 81-94.

use serde::{Deserialize, Serialize};

use crate::estimate::{SteadyOptions, SteadyWindow};
use crate::filter::{PolynomialFilter, Window};
use crate::least_squares::StdMethod;

/// All stages. A stage without runs of its kind is left out by itself; `skip` leaves it out although there are.
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
    /// Everything at once with differentiated velocity, to be shown beside the others.
    #[serde(skip_serializing_if = "is_default")]
    pub direct: DirectStage,
    /// Standard deviations of the integral stages. `hac`: increments of a noisy velocity are correlated, and (14) then
    /// is too wide or too narrow.
    #[serde(skip_serializing_if = "is_default")]
    pub std: StdMethod,
    /// Filter whose slope makes a body rate from its angle, where the rate is not logged. A second and a parabola.
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
    /// The same with one filter of the velocities in all stages of motion.
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
    /// Leave the stage out.
    pub skip: bool,
    /// Nominal forces below this, N or N·m, are not fitted. 0: the paper fits all, and a dead band shows in the
    /// residuals.
    pub least_force: f64,
    /// Last part of each constant command that counts as steady, 0 to 1. 0.5: the first half holds the start of the
    /// propeller and of the water around it. Of a command that changes all the time every sample counts.
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
    /// Leave the stage out.
    pub skip: bool,
    /// Last part of each run in which steady windows are sought, 0 to 1. 0.5: the first half is acceleration, and what
    /// is left of it passes for drag.
    pub steady_part: f64,
    /// Greatest drift of the speed over a window, as a part of the greatest speed of the run. 0.04: a drift of 5 % errs
    /// by some 10 % in quadratic drag, about the paper's own scatter.
    pub drift: f64,
    /// Greatest scatter about the drift (one standard deviation), as a part of the greatest speed of the run. 0.08: the
    /// paper's record of Fig. 7 scatters by 6 %.
    pub scatter: f64,
    /// Least length of a window, s.
    pub length: f64,
    /// Windows by hand: a run that is named here has these and no others.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub windows: Vec<GivenWindow>,
    /// Whether drag in yaw has values of its own clockwise and anticlockwise, where runs show both.
    pub per_direction: bool,
    /// Where the pitch of (19) comes from.
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
    /// What counts as steady.
    pub(super) fn limits(&self) -> SteadyOptions {
        SteadyOptions { drift: self.drift, scatter: self.scatter, length: self.length }
    }
}

/// A steady window given by hand.
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

/// Where the pitch of (19) comes from.
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
    /// Leave the stage out.
    pub skip: bool,
    /// Polynomial filter of the velocities; none by default, for the integral form differentiates nothing and a filter
    /// correlates the noise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub filter: Option<PolynomialFilter>,
    /// Samples from one end of an integration interval to the other. 1 is the paper's (5); at low rates and noisy
    /// velocities several are less biased.
    pub window: usize,
    /// Hold the drag that the steady stage found. True: that is the paper's step (iii); a single-step fit of both is
    /// ill-conditioned.
    pub hold_drag: bool,
    /// A stage of each run beside that of all together, as in the paper's Table 5.
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
    /// Leave the stage out.
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
    /// How products of channels with different rates (u v at 3 Hz beside r at 9 Hz) come to common instants.
    pub align: Align,
}

impl Default for ZigzagStage {
    fn default() -> ZigzagStage {
        ZigzagStage { skip: false, filter: None, window: 1, hold_drag: true, per_run: true, align: Align::Linear }
    }
}

/// How a slow channel is read at the instants of a fast one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Align {
    /// On the straight line between its neighbours. The default: velocity is continuous, and no delay arises.
    #[default]
    Linear,
    /// The last sample before, as a computer on board would have it; late by half a sample on average.
    Previous,
    /// Only instants at which both have a sample.
    Common,
}

/// `[stage.direct]`: equation (30).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DirectStage {
    /// Leave the stage out. True: its parameters are not to be used, so it is shown only to those who ask.
    pub skip: bool,
    /// Filter whose slope is the acceleration. Seven samples and a parabola: three quarters of a second of the paper's
    /// yaw rate. The estimates hang on it (docs/staged.md), which is what the twin is there to show.
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
