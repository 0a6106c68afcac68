"""Many fits at once: a list of campaigns, or a bootstrap, mapped over any executor."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Executor
from functools import partial
from itertools import pairwise
from typing import Literal, TypeVar

import numpy as np

from ._campaign import Campaign, campaign_of
from ._errors import DataError, UsageError
from ._fit import Fit
from ._plain import build
from ._progress import Progress, listener
from ._resampling import Resampling, Scatter
from ._verbs import Estimator, Source, fit

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


def resample(
    campaign: Source,
    *,
    method: Literal["bootstrap", "monte_carlo", "runs"] = "bootstrap",
    draws: int | None = None,
    block: float | None = None,
    seed: int | None = None,
    estimator: Estimator | None = None,
    executor: Executor | None = None,
    progress: Progress = None,
) -> Resampling:
    """Refits the baseline many times, to show how far estimates scatter.

    Args:
        campaign: a campaign, or the path of one.
        method: ``bootstrap`` draws stretches of the training runs with replacement and asks that those be independent
            of each other; ``monte_carlo`` fits data that the fitted model made and asks that the model be right. Both
            refit by output error in this process, on all cores. ``runs`` draws whole runs with replacement, kind by
            kind, and fits by any estimator: what goes together within a run stays together, so that residuals may be
            correlated there, and an executor can share out the fits.
        draws: number of refits; 1000 when absent, 200 with ``runs``, where each is a whole fit.
        block: with ``runs``, length of stretches that are drawn instead of whole runs, s: much longer than residuals
            remember. A handful of runs say little of their own spread.
        seed: with ``runs``, seed of the draws, 1 when absent; else that of the campaign.
        estimator: with ``runs``, as for `fit`.
        executor: with ``runs``, as for `map_fit`; the results do not depend on it.
        progress: called as ``progress(what, done, of)``; `True` shows a bar.

    Raises:
        DataError: the data does not determine the parameters, or has too few runs or stretches to draw from.
        UsageError: fewer than two draws, or an argument that belongs to another method.
    """
    count = (200 if method == "runs" else 1000) if draws is None else draws
    if count < 2:
        raise UsageError(f"draws = {count}: at least two are needed")
    if method == "runs":
        return _of_runs(campaign_of(campaign), count, block, 1 if seed is None else seed, estimator, executor, progress)
    given = {"block": block, "seed": seed, "estimator": estimator, "executor": executor}
    if foreign := [name for name, value in given.items() if value is not None]:
        raise UsageError(f"{', '.join(foreign)}: only method = 'runs' takes this, not {method!r}")
    with listener(progress) as heard:
        return build(Resampling, json.loads(campaign_of(campaign)._native.resample(method, count, heard)))


def _of_runs(
    campaign: Campaign,
    draws: int,
    block: float | None,
    seed: int,
    estimator: Estimator | None,
    executor: Executor | None,
    progress: Progress,
) -> Resampling:
    whole = fit(campaign, estimator=estimator)
    free = [p for p in whole.parameters if not p.fixed and not p.per_run]
    groups = _groups(campaign, block)
    rng = np.random.default_rng(seed)
    drawn = [
        tuple(group[k] for group in groups for k in rng.integers(0, len(group), len(group)).tolist())
        for _ in range(draws)
    ]
    # a campaign crosses to a worker once for some draws
    lots = [tuple(drawn[k : k + LOT]) for k in range(0, draws, LOT)]
    names = tuple((p.term, p.name) for p in free)
    work = partial(_refits, campaign, names, estimator)
    found = [row for rows in _mapped(work, lots, executor, "drawing", progress) for row in rows]
    good = np.array([row for row in found if row is not None])
    if 2 * len(good) < draws:
        raise DataError(
            f"{draws - len(good)} of {draws} draws determine no fit: more runs are needed, or shorter blocks"
        )
    ends = np.quantile(good, [0.025, 0.975], axis=0).T.tolist()
    spread = zip(free, good.mean(axis=0).tolist(), good.std(axis=0, ddof=1).tolist(), ends, strict=True)
    parameters = tuple(Scatter(p.term, p.name, p.value, m, s, (a, b), p.unit) for p, m, s, (a, b) in spread)
    failed = draws - len(good)
    return Resampling(1, "runs", len(good), failed, seed, parameters, block, whole.warnings, good)


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
