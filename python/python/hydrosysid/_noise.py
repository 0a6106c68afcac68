"""What is random in the runs: the force that pushes the vehicle, sensor noise, and the errors of predictions."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class RandomForce:
    """A random force in one degree of freedom, a first-order Gauss-Markov process.

    Attributes:
        dof: degree of freedom in which it acts.
        rms: its standard deviation, in `unit`.
        std: standard deviation of `rms`; 0 for a force that was held.
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
        stated: as the campaign states it.
        typical: what such a sensor usually has, from and to.
        correlation_time: correlation time of the coloured part, s; `None` for white noise.
        coloured_std: standard deviation of the coloured part.
        restlessness: how much more windows of its innovations differ from white ones than chance makes them.
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
    """How predictions of a run err in one degree of freedom.

    Attributes:
        run: name of the run.
        dof: degree of freedom.
        ahead: seconds ahead; 0 for one sample, `None` for a free run.
        rms: root-mean-square error, in the unit of the channel.
        expected: the error that sensor and random force let expect.
    """

    run: str
    dof: str
    ahead: float | None
    rms: float
    expected: float


@dataclass(frozen=True)
class HeldBack:
    """Innovations that are held back, since there are outliers.

    Attributes:
        beyond: deviations beyond which they are.
        share: share of the innovations that lies there.
        by_chance: the share that does in Gaussian noise.
    """

    beyond: float
    share: float
    by_chance: float


@dataclass(frozen=True)
class Noise:
    """What is random in the runs.

    Attributes:
        force: the random force in each degree of freedom in which there is one.
        sensors: the noise of each channel that the model predicts.
        innovations_white: whether no channel's innovations are correlated beyond chance.
        held_back: how the fit holds outliers back; `None` where every innovation counts as it is, or the noise is that
            of a model file.
        prediction: how predictions err, and how they should.
    """

    force: tuple[RandomForce, ...]
    sensors: tuple[SensorNoise, ...]
    innovations_white: bool
    held_back: HeldBack | None
    prediction: tuple[Prediction, ...]
