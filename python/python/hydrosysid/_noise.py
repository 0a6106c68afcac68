"""The random parts of the runs: the force that pushes the vehicle, sensor noise, and prediction errors."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class RandomForce:
    """A random force in one degree of freedom, a first-order Gauss-Markov process.

    Attributes:
        dof: degree of freedom in which it acts.
        rms: its standard deviation, in `unit`.
        std: standard error of `rms`; 0 for a fixed force.
        unit: ``N`` or ``N*m``.
        correlation_time: correlation time, s.
        correlation_time_std: standard deviation of it, s.
        share_of_thrust: rms over that of the thrust; `None` without thrust there.
        only_intensity: whether only rms² times the correlation time is known.
    """

    dof: str
    rms: float
    std: float
    unit: str
    correlation_time: float
    correlation_time_std: float
    share_of_thrust: float | None
    only_intensity: bool


@dataclass(frozen=True)
class SensorNoise:
    """The noise of a channel, SI.

    Attributes:
        channel: the channel.
        std: standard deviation of the white part.
        stated: the value stated in the campaign.
        typical: typical range of such a sensor, from and to.
        correlation_time: correlation time of the coloured part, s; `None` for white noise.
        coloured_std: standard deviation of the coloured part.
        restlessness: how much more windows of its innovations differ from white ones than by chance.
    """

    channel: str
    std: float
    stated: float | None
    typical: tuple[float, ...] | None
    correlation_time: float | None
    coloured_std: float | None
    restlessness: float


@dataclass(frozen=True)
class Prediction:
    """Prediction errors of a run in one degree of freedom.

    Attributes:
        run: name of the run.
        dof: degree of freedom.
        ahead: seconds ahead; 0 for one sample, `None` for a free run.
        rms: root-mean-square error, in the unit of the channel.
        expected: the error expected from sensor noise and random force.
    """

    run: str
    dof: str
    ahead: float | None
    rms: float
    expected: float


@dataclass(frozen=True)
class HeldBack:
    """Innovations that are down-weighted because of outliers.

    Attributes:
        beyond: limit in standard deviations.
        share: share of the innovations beyond it.
        by_chance: the same share for Gaussian noise.
    """

    beyond: float
    share: float
    by_chance: float


@dataclass(frozen=True)
class Noise:
    """The random parts of the runs.

    Attributes:
        force: the random force in each degree of freedom in which there is one.
        sensors: the noise of each channel that the model predicts.
        innovations_white: whether no channel has significantly correlated innovations.
        held_back: how the fit down-weights outliers; `None` if every innovation counts fully, or the noise is that
            of a model file.
        prediction: actual and expected prediction errors.
    """

    force: tuple[RandomForce, ...]
    sensors: tuple[SensorNoise, ...]
    innovations_white: bool
    held_back: HeldBack | None
    prediction: tuple[Prediction, ...]
