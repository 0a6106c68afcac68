"""The results of `simulate` and `compare`."""

from __future__ import annotations

from dataclasses import dataclass, field
from os import PathLike
from statistics import median
from typing import TYPE_CHECKING, Any, ClassVar, overload

import numpy as np
from numpy.typing import NDArray

from ._errors import Finding, UsageError
from ._files import write
from ._html import html_table, picture
from ._noise import Noise
from ._panels import channels_of, draw_channel, draw_run
from ._result import Result
from ._run import Run
from ._series import mcap_of, side_by_side
from ._units import VELOCITIES
from ._view import Rows, axes, latex_table, text_table

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True, eq=False)
class SimulatedRun:
    """One simulated run, SI units; `measured` is NaN where a sensor has no sample.

    `std` is the expected standard deviation of a sample about the simulation, NaN at the start of a stretch; empty
    if the model has no noise.
    """

    run: str
    role: str
    time: NDArray[np.float64]
    simulated: dict[str, NDArray[np.float64]]
    measured: dict[str, NDArray[np.float64]]
    std: dict[str, NDArray[np.float64]] = field(default_factory=dict)


@dataclass(frozen=True, eq=False, repr=False)
class Simulation(Result):
    """Simulated runs next to the measurements.

    Attributes:
        format: 1.
        runs: the runs of free motion.
        warnings: warnings and notes.
    """

    format: int
    runs: tuple[SimulatedRun, ...]
    warnings: tuple[Finding, ...]

    title: ClassVar[str] = "Simulation"

    def __getitem__(self, name: str) -> SimulatedRun:
        """The run of this name."""
        for run in self.runs:
            if run.run == name:
                return run
        raise KeyError(f"no run {name!r}; there are {', '.join(run.run for run in self.runs)}")

    def rows(self) -> Rows:
        """One row per instant and channel."""
        return [
            {"run": run.run, "t": t, "channel": channel, "simulated": s, "measured": m}
            for run in self.runs
            for channel, values in run.simulated.items()
            for t, s, m in zip(run.time.tolist(), values.tolist(), run.measured[channel].tolist(), strict=True)
        ]

    def _brief_rows(self) -> Rows:
        return [
            {
                "run": run.run,
                "role": run.role,
                "channel": channel,
                "instants": len(run.time),
                "rms": float(np.sqrt(np.nanmean((values - run.measured[channel]) ** 2))),
            }
            for run in self.runs
            for channel, values in run.simulated.items()
            if np.isfinite(run.measured[channel]).any()
        ]

    def summary(self) -> str:
        """One line per run and channel."""
        return "\n".join([text_table(self._brief_rows(), self.title), *self._remarks()])

    def to_latex(self) -> str:
        """One line per run and channel."""
        return latex_table(self._brief_rows())

    def series(self) -> Run:
        """Channels ``RUN/u/measured``, ``simulated``, ``residual`` and ``std`` of all runs, as one run."""
        return side_by_side({run.run: (run.time, run.simulated, run.measured, run.std) for run in self.runs})

    def to_csv(self, path: str | PathLike[str], *, force: bool = False) -> None:
        """Writes the series of all runs side by side, like the command's ``--series``, for PlotJuggler.

        Args:
            path: file to write, atomically.
            force: replace an existing file.
        """
        self.series().to_csv(path, force=force)

    def to_mcap(self, path: str | PathLike[str], *, force: bool = False) -> None:
        """Writes the series as MCAP, one topic per run and channel, for Foxglove and PlotJuggler.

        It needs ``hydrosysid[mcap]``.

        Args:
            path: file to write, atomically.
            force: replace an existing file.
        """
        write(path, mcap_of(self.series()), force)

    @overload
    def plot(self, run: str | None = None, channel: None = None, *, ax: None = None, **style: Any) -> NDArray[Any]: ...
    @overload
    def plot(self, run: str | None = None, channel: str | None = None, *, ax: Axes, **style: Any) -> Axes: ...
    @overload
    def plot(self, run: str | None, channel: str, *, ax: Axes | None = None, **style: Any) -> Axes: ...
    @overload
    def plot(self, run: str | None = None, *, channel: str, ax: Axes | None = None, **style: Any) -> Axes: ...
    def plot(
        self, run: str | None = None, channel: str | None = None, *, ax: Axes | None = None, **style: Any
    ) -> NDArray[Any] | Axes:
        """A run over time: measured, simulated, and the band of 95 % of the samples if the model has noise.

        Args:
            run: name of the run; the first when absent.
            channel: name of the channel, ``u``; when absent all that are measured, one panel each in a figure of their
                own, or the first of them in `ax`.
            ax: axes to draw one channel into; new ones when absent.
            style: passed on to the lines of the simulation.

        Returns:
            The axes; for all channels an array of them, in the order of the panels.

        Raises:
            KeyError: no such run or channel.
        """
        return _drawn(self.runs[0] if run is None else self[run], {}, channel, ax, style)

    def _verdict(self) -> tuple[str, str]:
        explained = _explained(self.runs)
        if not explained:
            return "", ""
        least, channel, run = min(explained)
        held_out = sum(one.role == "validate" for one in self.runs)
        runs = (
            f"{len(self.runs)} runs, {held_out} of which took no part in the fit"
            if held_out
            else f"{len(self.runs)} runs"
        )
        return "", f"{runs}; fit {least:.3g} % or better, lowest in {channel} of {run}."

    def _tables(self) -> list[str]:
        return [html_table(self._brief_rows())]

    def _picture(self) -> str:
        return _small_picture(self.runs[0], {}) if self.runs else ""


def _explained(runs: tuple[SimulatedRun, ...]) -> list[tuple[float, str, str]]:
    """Fit of each channel of each run, %: 100 for a perfect simulation, 0 for one no better than the mean."""
    found = []
    for run in runs:
        for channel, simulated in run.simulated.items():
            there = np.isfinite(run.measured[channel])
            measured = run.measured[channel][there]
            spread = float(np.std(measured)) if there.any() else 0.0
            if spread > 0.0:
                rms = float(np.sqrt(np.mean((simulated[there] - measured) ** 2)))
                # a simulation that ran away is as wrong as can be
                percent = 100.0 * (1.0 - rms / spread) if np.isfinite(rms) else -np.inf
                found.append((percent, channel, run.run))
    return found


def _title(run: SimulatedRun) -> str:
    return f"{run.run}, {'of the fit' if run.role == 'train' else 'took no part in the fit'}"


def _drawn(
    run: SimulatedRun, remarks: dict[str, str], channel: str | None, ax: Axes | None, style: dict[str, Any]
) -> NDArray[Any] | Axes:
    if channel is None and ax is None:
        return draw_run(run, _title(run), style, remarks)
    name = channels_of(run)[0] if channel is None else channel
    ax = draw_channel(axes(ax), run, name, style)
    ax.set(xlabel="t, s", title="; ".join(filter(None, [_title(run), remarks.get(name)])))
    ax.margins(y=0.22)
    ax.legend(loc="upper right", ncols=3, fontsize="small")
    return ax


def _small_picture(run: SimulatedRun, remarks: dict[str, str]) -> str:
    shown = min(len(channels_of(run)), 3)
    if not shown:
        return ""
    return picture(lambda figure: draw_run(run, _title(run), {}, remarks, figure, 3), 6.4, 0.9 + 1.1 * shown)


@dataclass(frozen=True)
class Disagreement:
    """A model against one run in one degree of freedom, in `unit`.

    Attributes:
        run: name of the run.
        role: ``train`` or ``validate``.
        dof: degree of freedom.
        mean_abs: mean of the absolute error, equation (25) of the paper.
        std_abs: its standard deviation, equation (25).
        rms: root mean square of the error.
        noise_floor: standard deviation of the sensor's noise.
        fit_percent: 100 for a perfect simulation, 0 for one no better than the mean.
        unit: ``m/s`` or ``rad/s``.
        pieces: number of stretches that were simulated, each from its own initial state: more than 1 at gaps and
            where the motion is unstable.
        piece_length: length of the stretches into which unstable motion was cut, s; `None` if none was.
    """

    run: str
    role: str
    dof: str
    mean_abs: float
    std_abs: float
    rms: float
    noise_floor: float
    fit_percent: float
    unit: str
    pieces: int = 1
    piece_length: float | None = None


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(Result):
    """A model compared with runs.

    Attributes:
        format: 1.
        runs: one entry per run and degree of freedom.
        warnings: warnings and notes.
        noise: noise, and the model's predictions of each run; `None` if no filter can follow the runs.
        simulation: the runs themselves, measured and simulated.
    """

    format: int
    runs: tuple[Disagreement, ...]
    warnings: tuple[Finding, ...]
    noise: Noise | None = None
    simulation: Simulation | None = field(default=None, metadata={"own": True})

    title: ClassVar[str] = "Model against measurement"

    def rows(self) -> Rows:
        """One row per run and degree of freedom."""
        return [dict(vars(entry)) for entry in self.runs]

    @overload
    def plot(self, run: str | None = None, channel: None = None, *, ax: None = None, **style: Any) -> NDArray[Any]: ...
    @overload
    def plot(self, run: str | None = None, channel: str | None = None, *, ax: Axes, **style: Any) -> Axes: ...
    @overload
    def plot(self, run: str | None, channel: str, *, ax: Axes | None = None, **style: Any) -> Axes: ...
    @overload
    def plot(self, run: str | None = None, *, channel: str, ax: Axes | None = None, **style: Any) -> Axes: ...
    def plot(
        self, run: str | None = None, channel: str | None = None, *, ax: Axes | None = None, **style: Any
    ) -> NDArray[Any] | Axes:
        """A run over time: measured, simulated, and the band of 95 % of the samples if the model has noise.

        Args:
            run: name of the run; the first held-out run when absent, else the first.
            channel: name of the channel, ``u``; when absent all that are measured, one panel each in a figure of their
                own, or the first of them in `ax`.
            ax: axes to draw one channel into; new ones when absent.
            style: passed on to the lines of the simulation.

        Returns:
            The axes; for all channels an array of them, in the order of the panels.

        Raises:
            KeyError: no such run or channel.
            UsageError: a comparison that was assembled by hand, without its simulation.
        """
        shown = self._shown(run)
        return _drawn(shown, self._remarks_on(shown.run), channel, ax, style)

    def _verdict(self) -> tuple[str, str]:
        known = [e for e in self.runs if e.noise_floor > 0.0]
        held_out = [e for e in known if e.role == "validate"]
        judged = held_out or known
        if not judged:
            return "", ""
        ratios = [e.rms / e.noise_floor for e in judged]
        worst = judged[int(np.argmax(ratios))]
        runs = "Held-out runs" if held_out else "Runs of the fit (none is held out)"
        return "", (
            f"{runs}: the free simulation errs by {median(ratios):.2g} × the sensor noise (median), at most "
            f"{max(ratios):.2g} ×: {worst.run} in {worst.dof}."
        )

    def _shown(self, run: str | None) -> SimulatedRun:
        if self.simulation is None or not self.simulation.runs:
            raise UsageError("this comparison has no simulated run to plot")
        if run is not None:
            return self.simulation[run]
        free = [one for one in self.simulation.runs if one.role == "validate"]
        return (free or list(self.simulation.runs))[0]

    def _remarks_on(self, run: str) -> dict[str, str]:
        """Error over noise of each velocity."""
        own = [e for e in self.runs if e.run == run and e.noise_floor > 0.0]
        return {VELOCITIES[e.dof]: f"error {e.rms / e.noise_floor:.2g} × noise" for e in own if e.dof in VELOCITIES}

    def _picture(self) -> str:
        if self.simulation is None or not self.simulation.runs:
            return ""
        shown = self._shown(None)
        return _small_picture(shown, self._remarks_on(shown.run))

    def plot_errors(self, ax: Axes | None = None, **style: Any) -> Axes:
        """Root mean square error of each run relative to the noise floor.

        Args:
            ax: axes to draw into; new ones when absent.
            style: passed on to `matplotlib.axes.Axes.barh`.
        """
        ax = axes(ax)
        place = np.arange(len(self.runs))[::-1]
        for role, look in (("train", {"color": "C0"}), ("validate", {"color": "C1"})):
            chosen = [k for k, entry in enumerate(self.runs) if entry.role == role]
            ratio = [self.runs[k].rms / self.runs[k].noise_floor for k in chosen]
            if chosen:
                ax.barh(place[chosen], ratio, **(look | {"label": role} | style))
        ax.axvline(1.0, color="0.3", linewidth=0.8)
        ax.set_yticks(place, [f"{entry.run} {entry.dof}" for entry in self.runs])
        ax.set_xlabel("rms error over sensor noise")
        # below the bars, where none is
        ax.set_ylim(-1.6, len(self.runs) - 0.4)
        ax.legend(loc="lower right", ncols=2)
        return ax
