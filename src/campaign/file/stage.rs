//! The `[stage.*]` tables: options of each stage of the staged procedure.
//!
//! (i) `bollard`: thrust curves and η_inter. (ii) `steady`: drag from constant-velocity and towing runs.
//! (iii) `oscillatory` and `zigzag`: inertia, coupling and bias, drag held. `direct`: the cautionary twin, eq. (30).
//! Source: Avila, Donha and Adamowski, *Ocean Engineering* 60 (2013) 81-94.

use serde::{Deserialize, Serialize};

use super::is_default;
use crate::filter::{PolynomialFilter, Window};

/// All stages. A stage without runs of its kind is left out by itself; `skip` leaves it out although there are.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct StageTable {
    /// Thrust curves and interaction.
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
}

/// `[stage.bollard]`: equations (1) and (16).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BollardStage {
    /// Leave the stage out.
    pub skip: bool,
    /// Commands below this are not fitted, as V. 0: the paper fits all, and a dead band shows in the residuals.
    pub least_command: f64,
    /// Last part of each constant command that counts as steady, 0 to 1. 0.5: the first half holds the start of the
    /// propeller and of the water around it.
    pub steady_part: f64,
}

impl Default for BollardStage {
    fn default() -> BollardStage {
        BollardStage { skip: false, least_command: 0.0, steady_part: 0.5 }
    }
}

/// `[stage.steady]`: equations (18) and (19).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SteadyStage {
    /// Leave the stage out.
    pub skip: bool,
    /// Last part of each run that counts as steady, 0 to 1. 0.5: the first half is acceleration.
    pub steady_part: f64,
    /// Greatest drift of the speed over that part, as a part of the speed, before the run is said not to be steady.
    /// 0.05: a drift of 5 % errs by some 10 % in quadratic drag, about the paper's own scatter.
    pub drift: f64,
}

impl Default for SteadyStage {
    fn default() -> SteadyStage {
        SteadyStage { skip: false, steady_part: 0.5, drift: 0.05 }
    }
}

/// `[stage.oscillatory]`: equations (20), (21), (26) and (27).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct OscillatoryStage {
    /// Leave the stage out.
    pub skip: bool,
    /// Polynomial filter of the signals; none by default, for the integral form differentiates nothing and a filter
    /// correlates the noise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub filter: Option<PolynomialFilter>,
    /// Samples from one end of an integration interval to the other. 1 is the paper's (5); at low rates and noisy
    /// velocities several are less biased.
    pub window: usize,
    /// Hold the drag that the steady stage found. True: that is the paper's step (iii); a single-step fit of both is
    /// ill-conditioned.
    pub hold_drag: bool,
    /// One fit a run, as in the paper's Table 5, instead of one for all runs.
    pub per_run: bool,
}

impl Default for OscillatoryStage {
    fn default() -> OscillatoryStage {
        OscillatoryStage { skip: false, filter: None, window: 1, hold_drag: true, per_run: false }
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
        ZigzagStage { skip: false, filter: None, window: 1, hold_drag: true, per_run: false, align: Align::Linear }
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
    /// Filter whose slope is the acceleration. Nine samples, a second of the paper's yaw rate, and a parabola: the
    /// lowest degree that does not flatten an oscillation's peaks.
    pub filter: PolynomialFilter,
}

impl Default for DirectStage {
    fn default() -> DirectStage {
        DirectStage { skip: true, filter: PolynomialFilter { window: Window::Samples(9), degree: 2 } }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_read_over_the_defaults() {
        let text = "[oscillatory]\nwindow = 3\nfilter = { window = { seconds = 1.5 }, degree = 2 }\n[zigzag]\nalign = 'previous'";
        let stage: StageTable = toml::from_str(text).unwrap();
        assert_eq!((stage.oscillatory.window, stage.oscillatory.hold_drag), (3, true));
        assert_eq!(stage.oscillatory.filter.map(|f| f.window), Some(Window::Seconds(1.5)));
        assert_eq!(stage.zigzag.align, Align::Previous);
        assert_eq!(stage.steady, SteadyStage::default());
        assert_eq!(toml::from_str::<StageTable>(&toml::to_string(&stage).unwrap()).unwrap(), stage);
        assert_eq!(toml::to_string(&StageTable::default()).unwrap(), "");
    }
}
