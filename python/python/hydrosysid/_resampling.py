"""The result of `resample`, and the block bootstrap of a linear system."""

from __future__ import annotations

from dataclasses import dataclass, field
from html import escape
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from ._arrays import array
from ._errors import Finding, UsageError
from ._html import html_table, picture
from ._progress import Progress, listener
from ._result import Result
from ._view import Rows, axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True)
class Scatter:
    """The scatter of the refits of one parameter, SI units.

    Attributes:
        term: ``id``, ``id@dof`` or ``id@dof:other``.
        name: symbol.
        value: the original estimate.
        mean: mean of the draws; its difference from `value` is the bias.
        std: standard deviation of the draws.
        interval: 2.5 and 97.5 percentiles of the draws.
        unit: unit.
        run: the run whose value it is; `None` for a common one.
    """

    term: str
    name: str
    value: float
    mean: float
    std: float
    interval: tuple[float, float]
    unit: str
    run: str | None = None


def _called(p: Scatter) -> str:
    return " ".join(filter(None, (p.term, p.name, p.run)))


@dataclass(frozen=True, eq=False, repr=False)
class Resampling(Result):
    """Refits of a campaign.

    Attributes:
        format: 1.
        method: ``bootstrap``, ``monte_carlo`` or ``runs``.
        draws: number of successful refits.
        failed: number of refits without a solution, left out.
        seed: seed of the draws.
        parameters: scatter of each free parameter.
        block: length of the stretches that ``runs`` drew, s; `None` for whole runs.
        warnings: warnings and notes.
        samples: estimates of each refit in the order of `parameters`, (draws, p).
    """

    title: ClassVar[str] = "Refits"

    format: int
    method: str
    draws: int
    failed: int
    seed: int
    parameters: tuple[Scatter, ...]
    block: float | None = None
    warnings: tuple[Finding, ...] = ()
    samples: NDArray[np.float64] | None = field(default=None, metadata={"own": True})

    def rows(self) -> Rows:
        """One row per parameter."""
        return [
            {
                "term": p.term,
                "run": p.run,
                "value": p.value,
                "mean": p.mean,
                "std": p.std,
                "low": p.interval[0],
                "high": p.interval[1],
                "unit": p.unit,
            }
            for p in self.parameters
        ]

    def summary(self) -> str:
        """The scatter of each parameter, and how it was drawn."""
        return f"{super().summary()}\n{self._drawn()}"

    def _drawn(self) -> str:
        drawn = {"bootstrap": "stretches of the runs", "monte_carlo": "data of the fitted model"}.get(
            self.method, "whole runs" if self.block is None else f"stretches of {self.block:g} s"
        )
        return f"{self.draws} draws of {drawn}, {self.failed} failed, seed {self.seed}"

    def plot(self, parameter: str | None = None, ax: Axes | None = None, **style: Any) -> Axes:
        """Estimates with 95 % of the draws, relative to the estimate; for one parameter, the histogram of its draws.

        Args:
            parameter: its term ``id@dof`` or symbol; all parameters when absent.
            ax: axes to draw into; new ones when absent.
            style: passed on to `matplotlib.axes.Axes.hist`, or `errorbar` for all.
        """
        if parameter is not None:
            return self._histogram(parameter, axes(ax), style)
        ax = axes(ax)
        shown = [p for p in self.parameters if p.value != 0.0]
        place = np.arange(len(shown))[::-1]
        middle = np.array([p.mean / p.value for p in shown])
        ends = np.sort([[end / p.value for end in p.interval] for p in shown], axis=1)
        spread = np.abs(ends.T - middle)
        look: dict[str, Any] = {"fmt": "o", "capsize": 3}
        ax.errorbar(middle, place, xerr=spread, **(look | style))
        ax.axvline(1.0, color="0.3", linewidth=0.8)
        ax.set_yticks(place, [_called(p) for p in shown])
        ax.set_ylim(-0.6, len(shown) - 0.4)
        ax.set_xlabel("mean and 95 % of the draws, relative to the estimate")
        return ax

    def _verdict(self) -> tuple[str, str]:
        shown = [p for p in self.parameters if p.value != 0.0 and p.std > 0.0]
        if not shown:
            return "", ""
        widest = max(shown, key=lambda p: (p.interval[1] - p.interval[0]) / abs(p.value))
        biased = max(shown, key=lambda p: abs(p.mean - p.value) / p.std)
        ends = sorted(100.0 * (end / widest.value - 1.0) for end in widest.interval)
        bias = abs(biased.mean - biased.value) / biased.std
        words = (
            f"{_called(widest)} scatters most: 95 % of its draws lie {ends[0]:+.2g} to {ends[1]:+.2g} % from the "
            f"estimate. The largest bias is {bias:.2g} standard deviations, of {_called(biased)}."
        )
        failed = self.failed / (self.draws + self.failed)
        return (
            ("amber", f"{self.failed} of {self.draws + self.failed} refits failed. {words}")
            if failed > 0.05
            else ("", words)
        )

    def _tables(self) -> list[str]:
        return [html_table(self.rows()), f"<p>{escape(self._drawn())}</p>"]

    def _picture(self) -> str:
        shown = sum(p.value != 0.0 for p in self.parameters)
        return picture(lambda figure: self.plot(ax=figure.add_subplot()), 5.2, 0.8 + 0.26 * shown) if shown else ""

    def _histogram(self, parameter: str, ax: Axes, style: dict[str, Any]) -> Axes:
        named = [k for k, p in enumerate(self.parameters) if parameter in (p.term, p.name)]
        if not named:
            raise KeyError(f"no parameter {parameter!r}; there are {', '.join(p.term for p in self.parameters)}")
        if self.samples is None:
            raise UsageError("these refits do not contain the single draws: no histogram can be drawn")
        p = self.parameters[named[0]]
        ax.hist(self.samples[:, named[0]], **({"bins": "auto", "color": "0.75"} | style))
        ax.axvline(p.value, color="C0", label="estimate")
        ax.axvspan(*p.interval, color="C0", alpha=0.15, label="95 % of the draws")
        ax.set(xlabel=f"{p.term} {p.name}, {p.unit}", ylabel="draws")
        ax.legend()
        return ax


def block_bootstrap(
    H: ArrayLike,
    y: ArrayLike,
    *,
    block: int,
    draws: int = 1000,
    seed: int = 1,
    progress: Progress = None,
) -> NDArray[np.float64]:
    """Least-squares solutions of H θ = y on blocks of rows drawn with replacement, on all cores.

    Args:
        H: columns of regressors, (n, p).
        y: right-hand side, (n).
        block: rows of a block: longer than residuals stay correlated.
        draws: number of refits.
        seed: seed of the draws; the result does not depend on the number of cores.
        progress: called as ``progress(what, done, of)``; `True` shows a bar.

    Returns:
        θ of each refit, (draws, p); refits without a solution are left out.

    Raises:
        DataError: as for `least_squares`, and fewer than two blocks.

    >>> x = np.linspace(0.0, 1.0, 200)
    >>> y = 2.0 * x + np.random.default_rng(1).normal(0.0, 0.1, 200)
    >>> thetas = block_bootstrap(x[:, None], y, block=10)
    >>> bool(abs(thetas.mean() - 2.0) < 0.1 and 0.005 < thetas.std() < 0.02)
    True
    """
    if block < 1 or draws < 1:
        raise UsageError(f"block = {block}, draws = {draws}: both must be at least 1")
    h, right = array(H, "H", 2), array(y, "y")
    if h.shape[0] != len(right):
        raise UsageError(f"H has {h.shape[0]} rows, y has {len(right)}")
    with listener(progress) as heard:
        return _native.block_bootstrap(h, right, block, draws, seed, heard)
