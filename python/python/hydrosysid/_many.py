"""Many fits at once: a list of campaigns, or a bootstrap, mapped over any executor."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

import numpy as np
from numpy.typing import NDArray

from ._campaign import Campaign, campaign_of
from ._errors import DataError, Finding, UsageError
from ._fit import Fit
from ._plain import build
from ._progress import Progress, listener
from ._result import Result
from ._verbs import Estimator, Source, fit
from ._view import Rows, axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes

T = TypeVar("T")
R = TypeVar("R")
Stretches = tuple[tuple[int, float, float], ...]


def map_fit(
    campaigns: Iterable[Source],
    *,
    executor: Executor | None = None,
    estimator: Estimator | None = None,
    progress: Progress = None,
) -> list[Fit]:
    """Fits many campaigns, in their order; the results are the same whatever executor does the work.

    Args:
        campaigns: campaigns, or paths of such.
        executor: any `concurrent.futures.Executor`: a process pool, or that of Dask's ``Client.get_executor()``; a
            plain loop when absent. One fit uses all cores: set ``RAYON_NUM_THREADS=1`` where workers share them.
        estimator: as for `fit`.
        progress: as for `discover`; is told of every campaign that is done.
    """
    listed = list(campaigns)
    return list(_mapped(partial(fit, estimator=estimator), listed, executor, "fitting campaigns", progress))


def _mapped(
    work: Callable[[T], R], items: Sequence[T], executor: Executor | None, what: str, progress: Progress
) -> Iterator[R]:
    with listener(progress) as tell:
        for k, result in enumerate(map(work, items) if executor is None else executor.map(work, items)):
            if tell is not None:
                tell(what, k + 1, len(items))
            yield result


@dataclass(frozen=True)
class Resampled:
    """A parameter over all draws: its estimate, and what the draws say of it; SI units."""

    term: str
    name: str
    value: float
    std: float
    low: float
    high: float
    unit: str


@dataclass(frozen=True, eq=False, repr=False)
class Bootstrap(Result):
    """Refits to resampled runs.

    Attributes:
        format: 1.
        parameters: the free parameters: estimate, standard deviation, 95 % interval of the draws.
        draws: estimates of each draw in the order of `parameters`, (n, p).
        failed: draws that determined no fit.
        block: length of the stretches that were drawn, s; `None` for whole runs.
        seed: seed of the draws.
        warnings: what there is to say.
    """

    format: int
    parameters: tuple[Resampled, ...]
    draws: NDArray[np.float64]
    failed: int
    block: float | None
    seed: int
    warnings: tuple[Finding, ...]

    title: ClassVar[str] = "Bootstrap"

    def rows(self) -> Rows:
        """One row a parameter."""
        return [
            {
                "": f"{p.term} {p.name}",
                "coef": p.value,
                "std err": p.std,
                "[0.025": p.low,
                "0.975]": p.high,
                "unit": p.unit,
            }
            for p in self.parameters
        ]

    def summary(self) -> str:
        """The parameters with the intervals of the draws."""
        drawn = "whole runs" if self.block is None else f"stretches of {self.block:g} s"
        foot = f"{len(self.draws)} draws of {drawn}, {self.failed} failed, seed {self.seed}"
        return super().summary() + "\n" + foot

    def plot(self, parameter: str | None = None, ax: Axes | None = None, **style: Any) -> Axes:
        """Histogram of the draws of a parameter, with the estimate and the 95 % interval.

        Args:
            parameter: its term ``id@dof`` or symbol; the first when absent.
            ax: axes to draw into; new ones when absent.
            style: passed on to `matplotlib.axes.Axes.hist`.
        """
        ax = axes(ax)
        named = [k for k, p in enumerate(self.parameters) if parameter in (None, p.term, p.name)]
        if not named:
            raise KeyError(f"no parameter {parameter!r}; there are {', '.join(p.term for p in self.parameters)}")
        p = self.parameters[named[0]]
        ax.hist(self.draws[:, named[0]], **({"bins": "auto", "color": "0.75"} | style))
        ax.axvline(p.value, color="C0", label="estimate")
        ax.axvspan(p.low, p.high, color="C0", alpha=0.15, label="95 % of the draws")
        ax.set(xlabel=f"{p.term} {p.name}, {p.unit}", ylabel="draws")
        ax.legend()
        return ax


def bootstrap(
    campaign: Source,
    draws: int = 200,
    *,
    block: float | None = None,
    seed: int = 1,
    estimator: Estimator | None = None,
    executor: Executor | None = None,
    progress: Progress = None,
) -> Bootstrap:
    """Fits the model to runs drawn with replacement, kind by kind: how far estimates move between campaigns.

    What goes together within a run stays together, so that residuals may be correlated there. A handful of runs say
    little of their own spread: cut them into stretches with `block`. Every draw is a whole fit by any estimator, which
    an executor can share out; `resample` is the quick one in this process, by output error.

    Args:
        campaign: a campaign, or the path of one.
        draws: how many.
        block: length of stretches that are drawn instead of whole runs, s: much longer than residuals remember.
        seed: seed of the draws.
        estimator: as for `fit`.
        executor: as for `map_fit`; the results do not depend on it.
        progress: as for `discover`.

    Raises:
        DataError: fewer than two runs or stretches to draw from, or most draws determine no fit.
    """
    if draws < 2:
        raise UsageError(f"draws = {draws}: at least two are needed")
    loaded = campaign_of(campaign)
    whole = fit(loaded, estimator=estimator)
    free = [p for p in whole.parameters if not p.fixed and not p.per_run]
    groups = _groups(loaded, block)
    rng = np.random.default_rng(seed)
    drawn = [
        tuple(group[k] for group in groups for k in rng.integers(0, len(group), len(group)).tolist())
        for _ in range(draws)
    ]
    # a campaign crosses to a worker once for some draws
    lots = [tuple(drawn[k : k + LOT]) for k in range(0, draws, LOT)]
    names = tuple((p.term, p.name) for p in free)
    work = partial(_refits, loaded, names, estimator)
    found = [row for rows in _mapped(work, lots, executor, "drawing", progress) for row in rows]
    good = np.array([row for row in found if row is not None])
    if 2 * len(good) < draws:
        raise DataError(
            f"{draws - len(good)} of {draws} draws determine no fit: more runs are needed, or shorter blocks"
        )
    low, high = np.quantile(good, [0.025, 0.975], axis=0)
    std = good.std(axis=0, ddof=1)
    spread = zip(free, std.tolist(), low.tolist(), high.tolist(), strict=True)
    parameters = tuple(Resampled(p.term, p.name, p.value, s, a, b, p.unit) for p, s, a, b in spread)
    return Bootstrap(1, parameters, good, draws - len(good), block, seed, whole.warnings)


LOT = 8
"""Draws that a worker makes at once."""


def _groups(campaign: Campaign, block: float | None) -> list[list[tuple[int, float, float]]]:
    """What is drawn from, kind by kind: training runs or their stretches, with begin and end in s."""
    kinds: dict[str, list[tuple[int, float, float]]] = {}
    for k, (kind, role, span) in enumerate(json.loads(campaign._native.spans())):
        if role != "train" or span is None:
            continue
        begin, end = span
        parts = 1 if block is None else max(1, int((end - begin) / block))
        edges = np.linspace(begin, end, parts + 1).tolist()
        kinds.setdefault(kind, []).extend((k, a, b) for a, b in pairwise(edges))
    if all(len(group) < 2 for group in kinds.values()):
        raise DataError("a bootstrap draws from two runs or more; cut a single one into stretches with block = …")
    return list(kinds.values())


def _refits(
    campaign: Campaign, names: tuple[tuple[str, str], ...], estimator: str | None, lot: tuple[Stretches, ...]
) -> list[list[float] | None]:
    return [_refit(campaign, names, estimator, stretches) for stretches in lot]


def _refit(
    campaign: Campaign, names: tuple[tuple[str, str], ...], estimator: str | None, stretches: Stretches
) -> list[float] | None:
    try:
        result, _ = campaign._native.resampled(list(stretches)).fit(estimator, False, None)
    except DataError:
        return None
    found = {(p.term, p.name): p.value for p in build(Fit, json.loads(result)).parameters}
    return [found[name] for name in names]
