"""A run over time: what was measured, what is simulated and the band about it, one panel per channel."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ._errors import UsageError
from ._units import unit_of
from ._view import Z_95, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ._motion import SimulatedRun

ORDER = ["u", "v", "w", "p", "q", "r", "x", "y", "z", "phi", "theta", "psi"]
"""States in the order of their panels; other channels follow."""


def channels_of(run: SimulatedRun) -> list[str]:
    """Channels that have a panel: those that are measured, or all where none is."""
    measured = [name for name in run.simulated if np.isfinite(run.measured[name]).any()]
    return sorted(measured or run.simulated, key=lambda n: (ORDER.index(n) if n in ORDER else len(ORDER), n))


def draw_channel(ax: Axes, run: SimulatedRun, channel: str, style: dict[str, Any]) -> Axes:
    """One channel of a run in these axes.

    Raises:
        KeyError: no such channel.
    """
    if channel not in run.simulated:
        raise KeyError(f"no channel {channel!r}; there are {', '.join(run.simulated)}")
    simulated, measured = run.simulated[channel], run.measured[channel]
    there = np.isfinite(measured)
    ax.plot(run.time[there], measured[there], ".", color="0.55", markersize=3, label="measured", zorder=1)
    # where a stretch begins anew no line is drawn
    time, line, std = _broken(run.time, simulated, run.std.get(channel, np.full_like(simulated, np.nan)))
    own: dict[str, Any] = {"label": "simulated", "linewidth": 1.3, "zorder": 3}
    (drawn,) = ax.plot(time, line, **(own | style))
    if np.isfinite(std).any():
        low, high = line - Z_95 * std, line + Z_95 * std
        look: dict[str, Any] = {"color": drawn.get_color(), "alpha": 0.18, "linewidth": 0}
        ax.fill_between(time, low, high, label="95 % of the samples", zorder=2, **look)
    unit = unit_of(channel)
    ax.set_ylabel(f"{channel}, {unit}" if unit else channel)
    ax.margins(x=0.01)
    return ax


def _broken(
    time: NDArray[np.float64], *columns: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """The columns with NaN between samples that are further apart than ten usual steps."""
    steps = np.diff(time)
    gaps = np.flatnonzero(steps > 10.0 * np.median(steps)) + 1 if len(steps) else np.empty(0, dtype=int)
    whole = [np.insert(column, gaps, np.nan) for column in (time, *columns)]
    return whole[0], whole[1], whole[2]


def draw_run(
    run: SimulatedRun,
    title: str,
    style: dict[str, Any],
    remarks: Mapping[str, str] | None = None,
    figure: Figure | None = None,
    most: int | None = None,
) -> NDArray[Any]:
    """All channels of a run, one panel each, under one title; returns the axes, one a channel, in order.

    Args:
        run: the run.
        title: title of the figure.
        style: passed on to the lines of the simulation.
        remarks: what stands over the panel of a channel.
        figure: figure to draw into; a new one when absent.
        most: greatest number of panels.
    """
    names = channels_of(run)[:most]
    if not names:
        raise UsageError(f"{run.run} has no channel to plot")
    columns = 1 if len(names) <= 4 else 2
    lines = -(-len(names) // columns)
    whole = new_figure(4.6 * columns + 1.6, 1.4 * lines + 1.2) if figure is None else figure
    grid = whole.subplots(lines, columns, sharex=True, squeeze=False)
    # down the first column, then down the second, so that a kind of channel stays together
    axes = [grid[k % lines, k // lines] for k in range(lines * columns)]
    for ax, name in zip(axes, names, strict=False):
        draw_channel(ax, run, name, style)
    for ax in axes[len(names) :]:
        ax.remove()
    for ax in axes[: len(names)]:
        if axes.index(ax) % lines == lines - 1 or axes.index(ax) == len(names) - 1:
            ax.set_xlabel("t, s")
            ax.tick_params(labelbottom=True)
    for ax, name in zip(axes, names, strict=False):
        ax.set_title((remarks or {}).get(name, ""), loc="right", fontsize=7.5, pad=2)
    handles, labels = axes[0].get_legend_handles_labels()
    whole.suptitle(title, fontsize=10)
    whole.legend(handles, labels, loc="outside lower center", ncols=3, frameon=False, fontsize=8)
    whole.align_ylabels(axes[: len(names)])
    return np.array(axes[: len(names)])
