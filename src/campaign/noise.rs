//! Noise and random force in the results of the verbs: the key `noise` of their JSON.

use serde::Serialize;

use crate::estimate::filter_error::{
    Coordinate, FilterErrorFit, Filtered, Forecast, NoiseModel, Prediction, RandomForce,
};
use crate::frame::{Dof, Measured};
use crate::model::Model;
use crate::monitor::{MonitorOptions, restlessness};
use crate::navigation::upright;
use crate::run::{Run, commanded_rms};
use crate::wording::{digits, listed, times};

/// Noise and random force in the runs of a fit, and whether predictions agree with them.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Noise {
    /// Random force in each degree of freedom that has one.
    pub force: Vec<ForceFound>,
    /// The noise of each channel that the model predicts.
    pub sensors: Vec<SensorFound>,
    /// Whether no channel has innovations that are correlated beyond chance.
    pub innovations_white: bool,
    /// Down-weighting of outliers; `null` if every innovation counts in full, or the noise is that
    /// of a model file.
    pub held_back: Option<HeldBack>,
    /// Errors of the predictions, and the errors to expect.
    pub prediction: Vec<Predicted>,
}

/// Ratio of a random force to the thrust above which the force probably stands in for what the
/// model lacks; the forces found on vehicles in tanks, harbours and rivers are some per cent.
const NO_TURBULENCE: f64 = 0.2;

impl Noise {
    /// Describes the random force in a sentence.
    pub fn sentence(&self) -> String {
        match &self.force[..] {
            [] => "No random force is found: the model leaves only sensor noise.".into(),
            forces => format!("The vehicle is pushed by a random force of {}.", in_words(forces)),
        }
    }

    /// Describes the random forces in few words; `None` if there is none.
    pub fn forces(&self) -> Option<String> {
        let mut of = " of thrust";
        let mut one = |f: &ForceFound| {
            // the reference of the percentages is stated once
            let share = |s: f64| format!(", {} %{}", digits(100.0 * s), std::mem::take(&mut of));
            let share = f.share_of_thrust.map_or(String::new(), share);
            format!("{} {} {}{share}", f.dof, digits(f.rms), f.unit.replace('*', " "))
        };
        let all: Vec<String> = self.force.iter().map(&mut one).collect();
        (!all.is_empty()).then(|| format!("random force: {}", all.join("; ")))
    }

    /// Returns the unit of the predictions in a degree of freedom: of its velocity, or of its
    /// position or angle if no sensor gives the velocity.
    pub fn unit_in(&self, dof: Dof) -> &'static str {
        let has_velocity = self.sensors.iter().any(|sensor| sensor.channel == dof.velocity());
        let channel = if has_velocity { Measured::from(dof) } else { Measured::Function(dof.position().into()) };
        channel.unit()
    }

    /// Returns a sentence if a random force moves the vehicle and its commands hardly do.
    pub fn overwhelming(&self) -> Option<String> {
        let share = |f: &&ForceFound| f.share_of_thrust.unwrap_or(0.0);
        let most = self.force.iter().max_by(|a, b| share(a).total_cmp(&share(b)))?;
        (share(&most) > RandomForce::OVERWHELMING).then(|| {
            format!(
                "The commands do not dominate the motion: in {} a random force of {} {} is {} theirs.",
                most.dof,
                digits(most.rms),
                most.unit.replace('*', " "),
                times(share(&most))
            )
        })
    }

    /// Whether a random force is too large a share of the thrust to be turbulence or a tether:
    /// something may be missing in the model.
    pub fn is_more_than_turbulence(&self) -> bool {
        self.force.iter().filter_map(|f| f.share_of_thrust).any(|share| share > NO_TURBULENCE)
    }

    /// Returns ` That is more than turbulence or a tether`, `so` and a full stop; an empty text if
    /// it may be these.
    pub(crate) fn beyond_turbulence(&self, so: &str) -> String {
        match self.is_more_than_turbulence() {
            true => format!(" That is more than turbulence or a tether{so}."),
            false => String::new(),
        }
    }
}

/// Down-weighting of innovations, because there are outliers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct HeldBack {
    /// Limit beyond which an innovation is down-weighted, in standard deviations.
    pub beyond: f64,
    /// Share of the innovations beyond the limit.
    pub share: f64,
    /// Share beyond the limit in Gaussian noise.
    pub by_chance: f64,
}

impl HeldBack {
    /// Returns the down-weighting of a fit; `None` if every innovation counts in full.
    pub(super) fn of(fit: &FilterErrorFit) -> Option<HeldBack> {
        fit.held_back().map(|(share, by_chance)| HeldBack { beyond: fit.limit, share, by_chance })
    }

    /// Describes the down-weighting in a sentence without its full stop.
    pub fn sentence(&self) -> String {
        format!(
            "outliers are down-weighted: {} % of the innovations lie beyond {} standard deviations, where chance puts \
             {} %",
            digits(100.0 * self.share),
            self.beyond,
            digits(100.0 * self.by_chance)
        )
    }
}

/// A random force.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ForceFound {
    /// Degree of freedom in which it acts.
    pub dof: Dof,
    /// Standard deviation of the force, in `unit`.
    pub rms: f64,
    /// Standard deviation of `rms`; 0 for a force that was held.
    pub std: f64,
    /// `N` or `N*m`.
    pub unit: &'static str,
    /// Correlation time, s.
    pub correlation_time: f64,
    /// Standard deviation of `correlation_time`, s; 0 for a force that was held.
    pub correlation_time_std: f64,
    /// `rms` over the rms of the thrust in its degree of freedom; `null` without thrust there.
    pub share_of_thrust: Option<f64>,
    /// Whether the correlation time is below the sample time, so that only rms² times it is known.
    pub only_intensity: bool,
}

/// The noise of a channel.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SensorFound {
    /// The channel.
    pub channel: String,
    /// Standard deviation of the white part, in the unit of the channel.
    pub std: f64,
    /// Standard deviation that the campaign states.
    pub stated: Option<f64>,
    /// Usual range for such a sensor, from and to.
    pub typical: Option<[f64; 2]>,
    /// Correlation time of the coloured part, s; `null` for white noise.
    pub correlation_time: Option<f64>,
    /// Standard deviation of the coloured part.
    pub coloured_std: Option<f64>,
    /// Factor by which windows of its innovations differ from white ones more than by chance: 1 for
    /// noise that is as described here. [`monitor`](crate::campaign::monitor()) takes it into
    /// account.
    pub restlessness: f64,
}

/// Errors of the predictions of one channel of a run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Predicted {
    /// Name of the run.
    pub run: String,
    /// Degree of freedom.
    pub dof: Dof,
    /// Seconds ahead: 0 for one sample, `null` for a free run.
    pub ahead: Option<f64>,
    /// Root-mean-square error, in the unit of the channel.
    pub rms: f64,
    /// The error that the filter expects, sensor and random force included.
    pub expected: f64,
}

/// Returns the usual range of the standard deviation of sensors of a channel: Doppler logs, gyros
/// of small vehicles, tilt and compass, pressure, acoustic positions. Kinsey, Eustice and Whitcomb,
/// *A survey of underwater vehicle navigation* (2006).
fn typical(channel: &str) -> Option<[f64; 2]> {
    let degree = f64::to_radians(1.0);
    match channel {
        "u" | "v" | "w" => Some([0.001, 0.02]),
        "p" | "q" | "r" => Some([0.0005, 0.01]),
        "phi" | "theta" => Some([0.05 * degree, degree]),
        "psi" => Some([0.1 * degree, 3.0 * degree]),
        "z" => Some([0.002, 0.1]),
        "x" | "y" => Some([0.01, 2.0]),
        _ => None,
    }
}

/// Returns the degree of freedom of a channel: of a velocity, or of a position or angle if no
/// velocity is predicted.
fn dof_of(outputs: &[String], output: usize) -> Option<Dof> {
    let name = &outputs[output];
    let position = |dof: &Dof| dof.position() == name && !outputs.iter().any(|o| o == dof.velocity());
    Dof::ALL.into_iter().find(|dof| dof.velocity() == name || position(dof))
}

/// Returns the random forces of a fit to `runs`.
pub(super) fn forces(fit: &FilterErrorFit, runs: &[Run]) -> Vec<ForceFound> {
    let (coordinates, covariance) = (&fit.noise_unknowns, fit.noise_covariance());
    let std = |of: Coordinate| {
        let k = coordinates.iter().position(|c| *c == of)?;
        Some(covariance[(k, k)].max(0.0).sqrt())
    };
    let sample_time = fit.filtered.sample_time();
    let found = |(k, force): (usize, &RandomForce)| ForceFound {
        dof: force.dof,
        rms: force.rms,
        std: force.rms * std(Coordinate::ForceRms(k)).unwrap_or(0.0),
        unit: if force.dof.is_rotation() { "N*m" } else { "N" },
        correlation_time: force.time,
        correlation_time_std: force.time * std(Coordinate::ForceTime(k)).unwrap_or(0.0),
        share_of_thrust: commanded_rms(runs, force.dof).map(|thrust| force.rms / thrust),
        only_intensity: force.time < sample_time,
    };
    fit.noise.forces.iter().enumerate().map(found).collect()
}

/// Returns the noise of the sensors.
pub(super) fn sensors(
    filtered: &Filtered,
    noise: &NoiseModel,
    stated: &std::collections::BTreeMap<String, f64>,
    forecasts: &[Forecast],
) -> Vec<SensorFound> {
    let outputs = filtered.problem.dynamics.outputs.iter().zip(&noise.sensors).enumerate();
    outputs
        .map(|(k, (output, sensor))| {
            let channel = upright::instrument_of(output).unwrap_or(output);
            SensorFound {
                channel: channel.to_string(),
                std: sensor.std,
                stated: stated.get(channel).copied(),
                typical: typical(channel),
                correlation_time: sensor.coloured.map(|c| c.time),
                coloured_std: sensor.coloured.map(|c| c.rms),
                restlessness: restlessness(
                    forecasts.iter().filter_map(|f| f.channels.get(k)),
                    MonitorOptions::default().window,
                ),
            }
        })
        .collect()
}

/// Returns the prediction errors of each run in each degree of freedom, stretches of a run
/// together.
pub(super) fn predicted(filtered: &Filtered, forecasts: &[Forecast]) -> Vec<Predicted> {
    let outputs = &filtered.problem.dynamics.outputs;
    let mut all: Vec<(String, Dof, Prediction)> = Vec::new();
    for forecast in forecasts {
        for channel in &forecast.channels {
            let Some(dof) = dof_of(outputs, channel.output) else { continue };
            for prediction in channel.predictions.iter().filter(|p| p.count > 0) {
                let known = |(run, d, p): &&mut (String, Dof, Prediction)| {
                    *run == forecast.run && *d == dof && p.ahead == prediction.ahead
                };
                match all.iter_mut().find(known) {
                    Some((_, _, sum)) => *sum = sum.with(prediction),
                    None => all.push((forecast.run.clone(), dof, *prediction)),
                }
            }
        }
    }
    let told = |(run, dof, p): (String, Dof, Prediction)| Predicted {
        run,
        dof,
        ahead: p.ahead,
        rms: p.rms(),
        expected: p.expected_rms(),
    };
    all.into_iter().map(told).collect()
}

/// Returns the predictions with the horizon `ahead` over all stretches together, by degree of
/// freedom.
pub(super) fn by_dof(filtered: &Filtered, forecasts: &[Forecast], ahead: Option<f64>) -> Vec<(Dof, Prediction)> {
    let outputs = &filtered.problem.dynamics.outputs;
    let mut all: Vec<(Dof, Prediction)> = Vec::new();
    for channel in forecasts.iter().flat_map(|f| &f.channels) {
        let of = channel.predictions.iter().find(|p| p.ahead == ahead);
        let (Some(dof), Some(prediction)) = (dof_of(outputs, channel.output), of) else { continue };
        match all.iter_mut().find(|(d, _)| *d == dof) {
            Some((_, sum)) => *sum = sum.with(prediction),
            None => all.push((dof, *prediction)),
        }
    }
    all
}

/// Whether no channel has correlated innovations.
pub(super) fn white(forecasts: &[Forecast]) -> bool {
    let channels = forecasts.first().map_or(0, |f| f.channels.len());
    (0..channels).all(|c| {
        let all = forecasts.iter().map(|f| f.channels[c].whiteness.clone());
        all.reduce(|a, b| a.with(&b)).is_none_or(|w| w.is_white(channels))
    })
}

/// Returns the noise of a fit, with the errors of its predictions of runs; the test for whiteness
/// uses its own forecasts, `of_training`.
pub(super) fn of_fit(
    (fit, of_training): (&FilterErrorFit, &[Forecast]),
    training: &[Run],
    stated: &std::collections::BTreeMap<String, f64>,
    (filtered, forecasts): (&Filtered, &[Forecast]),
) -> Noise {
    Noise {
        force: forces(fit, training),
        sensors: sensors(&fit.filtered, &fit.noise, stated, forecasts),
        innovations_white: white(of_training),
        held_back: HeldBack::of(fit),
        prediction: predicted(filtered, forecasts),
    }
}

/// Describes the random force in words: `1.2 N in surge (correlation 0.8 s, 3 % of its thrust)`.
pub(super) fn in_words(forces: &[ForceFound]) -> String {
    let one = |f: &ForceFound| {
        let unit = f.unit.replace('*', " ");
        let share = f.share_of_thrust.map_or(String::new(), |s| format!(", {} % of its thrust", digits(100.0 * s)));
        format!("{} {unit} in {} (correlation {} s{share})", digits(f.rms), f.dof, digits(f.correlation_time))
    };
    let all: Vec<String> = forces.iter().map(one).collect();
    listed(&all)
}

/// Returns the model with every parameter fixed, for runs that take part in no fit.
pub(super) fn with_parameters_fixed(model: &Model) -> Model {
    let mut fixed = model.clone();
    fixed.parameters.iter_mut().for_each(|p| p.fixed = true);
    fixed
}

#[cfg(test)]
mod tests {
    use super::*;

    fn force(dof: Dof, rms: f64, unit: &'static str) -> ForceFound {
        ForceFound {
            dof,
            rms,
            std: 0.1,
            unit,
            correlation_time: 0.82,
            correlation_time_std: 0.2,
            share_of_thrust: Some(0.031),
            only_intensity: false,
        }
    }

    #[test]
    fn a_force_is_told_with_two_digits() {
        let forces = [force(Dof::Surge, 1.234, "N"), force(Dof::Yaw, 0.0512, "N*m")];
        assert_eq!(
            in_words(&forces),
            "1.2 N in surge (correlation 0.82 s, 3.1 % of its thrust) and 0.051 N m in yaw (correlation 0.82 s, 3.1 % of its thrust)"
        );
        assert_eq!(in_words(&[]), "");
        let found = Noise { force: forces.to_vec(), ..Noise::default() };
        let line = "random force: surge 1.2 N, 3.1 % of thrust; yaw 0.051 N m, 3.1 %";
        assert_eq!(found.forces().as_deref(), Some(line));
        assert_eq!(Noise::default().forces(), None);
    }

    #[test]
    fn outliers_that_are_held_back_are_said() {
        let held_back = HeldBack { beyond: 1.345, share: 0.2134, by_chance: 0.1786 };
        let said = "outliers are down-weighted: 21 % of the innovations lie beyond 1.345 standard deviations, where \
                    chance puts 18 %";
        assert_eq!(held_back.sentence(), said);
    }

    /// A force beyond ten times the commands is said to move the vehicle; a smaller one, or one
    /// without commands, is not.
    #[test]
    fn what_overwhelms_the_commands_is_said() {
        let of = |shares: [Option<f64>; 2]| {
            let [surge, yaw] = shares;
            let surge = ForceFound { share_of_thrust: surge, ..force(Dof::Surge, 31.9, "N") };
            let yaw = ForceFound { share_of_thrust: yaw, ..force(Dof::Yaw, 2.19, "N*m") };
            Noise { force: vec![surge, yaw], ..Noise::default() }.overwhelming()
        };
        let said = of([Some(95.0), Some(12.0)]).unwrap();
        assert!(said.ends_with("in surge a random force of 32 N is 95 times theirs."), "{said}");
        assert_eq!((of([Some(9.0), None]), of([None, None])), (None, None));
        assert_eq!(Noise::default().overwhelming(), None);
    }
}
