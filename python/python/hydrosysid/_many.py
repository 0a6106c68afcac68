"""Many fits at once: a list of campaigns, or a bootstrap, mapped over any executor."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable
from dataclasses import replace
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Literal

import numpy as np

from ._campaign import Campaign, campaign_of
from ._errors import DataError, UsageError
from ._fit import Fit
from ._fits import Fits
from ._plain import build
from ._progress import Listener, Progress, listener
from ._resampling import Resampling, Scatter
from ._verbs import Estimator, Source, fit
from ._workers import Workers, mapped, mapped_or_failed

Stretches = tuple[tuple[int, float, float], ...]


def map_fit(
    campaigns: Iterable[Source],
    *,
    executor: Workers | None = None,
    estimator: Estimator | None = None,
    progress: Progress = None,
) -> Fits:
    """Fits many campaigns. If one fails, the result holds its error, and the others continue.

    The results do not depend on the executor. A campaign that was read from a file is passed to a worker
    as its path, which the worker must be able to read; one in memory as its arrays.

    Args:
        campaigns: campaigns, or paths of such.
        executor: any `concurrent.futures.Executor`, or a Dask ``Client``; a plain loop when absent. One fit uses all
            cores: set ``RAYON_NUM_THREADS=1`` where workers share them.
        estimator: as for `fit`.
        progress: as for `discover`; called whenever a campaign is done, in any order.

    Raises:
        UsageError: `executor` is neither, or `campaigns` is a single campaign.
    """
    listed = [_absolute(source, k) for k, source in enumerate(_several(campaigns))]
    work = partial(_fitted, estimator)
    found = mapped_or_failed(work, listed, executor, "fitting campaigns", progress)
    return Fits(1, _names(listed), tuple(found))


def _several(campaigns: Iterable[Source]) -> Iterable[Source]:
    """The campaigns, if they are many: a path is a sequence too, of its letters."""
    single = isinstance(campaigns, Campaign | str | bytes | os.PathLike)
    if single or not isinstance(campaigns, Iterable):
        told = type(campaigns).__name__ if isinstance(campaigns, Campaign) else repr(campaigns)
        one = "; one campaign is fitted by fit()" if single else ""
        raise UsageError(f"campaigns = {told}: a list of campaigns or of their paths is expected{one}")
    return campaigns


def _absolute(source: Source, place: int) -> Source | UsageError:
    """A path that means the same in every process; the error of what is no campaign."""
    if isinstance(source, Campaign):
        return source
    path = os.fspath(source) if isinstance(source, os.PathLike) else source
    if isinstance(path, str):
        return os.path.abspath(path)
    return UsageError(f"campaigns[{place}] = {source!r}: a campaign, or the path of one, is expected")


def _names(listed: list[Source | UsageError]) -> tuple[str, ...]:
    """Of each campaign the name of its vehicle, or of its file or folder, as it is told apart from the others'; of what
    is no campaign its place."""
    files = [Path(source) for source in listed if not isinstance(source, Campaign | UsageError)]
    places = [file.parent if file.name == "campaign.toml" else file for file in files]
    one_drive = len({place.drive for place in places}) == 1
    common = os.path.commonpath([place.parent for place in places]) if one_drive else None
    shown = iter([str(place) if common is None else place.relative_to(common).as_posix() for place in places])

    def name(k: int, source: Source | UsageError) -> str:
        if isinstance(source, UsageError):
            return f"campaigns[{k}]"
        return source.name if isinstance(source, Campaign) else next(shown)

    return tuple(name(k, source) for k, source in enumerate(listed))


def _fitted(estimator: Estimator | None, campaign: Source | UsageError) -> Fit:
    if isinstance(campaign, UsageError):
        raise campaign
    # the residuals stay where they are: a result is to cross a wire
    return replace(fit(campaign, estimator=estimator), residuals=())


def resample(
    campaign: Source,
    *,
    method: Literal["bootstrap", "monte_carlo", "runs"] = "bootstrap",
    draws: int | None = None,
    block: float | None = None,
    seed: int | None = None,
    estimator: Estimator | None = None,
    executor: Workers | None = None,
    progress: Progress = None,
) -> Resampling:
    """Refits the baseline many times, to show how far estimates scatter.

    Each refit has a number that determines its draw: the results do not depend on `executor`.

    Args:
        campaign: a campaign, or the path of one.
        method: ``bootstrap`` draws stretches of the training runs with replacement and assumes them independent
            of each other; by filter error each draw is one Gauss-Newton step under the noise of the fit.
            ``monte_carlo`` fits data simulated with the fitted model (filter error: with its random force), and assumes
            that the model is right. ``runs`` draws whole runs with replacement, kind by kind: correlations within a
            run are preserved.
        draws: number of refits; 1000 when absent, 200 where each is a whole fit: with ``runs``, and of
            ``monte_carlo`` by filter error.
        block: with ``runs``, length of stretches that are drawn instead of whole runs, s: much longer than the
            correlation of residuals. A handful of runs say little of their spread.
        seed: seed of the draws; that of the campaign when absent, 1 with ``runs``.
        estimator: as for `fit`: that of the campaign when absent, else the one that suits its runs.
        executor: as for `map_fit`; without one, refits are made in this process, on all cores.
        progress: called as ``progress(what, done, of)``; `True` shows a bar.

    Raises:
        DataError: the data does not determine the parameters, or has too few runs or stretches to draw from.
        UsageError: fewer than two draws, or an argument that belongs to another method.
    """
    if draws is not None and draws < 2:
        raise UsageError(f"draws = {draws}: at least two are needed")
    loaded = campaign_of(campaign)
    used = loaded._native.estimator(estimator)
    is_slow = method == "runs" or (method == "monte_carlo" and used == "filter_error")
    count = (200 if is_slow else 1000) if draws is None else draws
    if method == "runs":
        return _of_runs(loaded, count, block, 1 if seed is None else seed, estimator, executor, progress)
    if block is not None:
        raise UsageError(f"block: only method = 'runs' takes this, not {method!r}")
    if executor is None:
        with listener(progress) as heard:
            return _some(loaded, method, estimator, seed, heard, (0, count))
    ends = range(0, count + 1, max(LOT, -(-count // LOTS)))
    lots = list(pairwise([*ends, count] if ends[-1] < count else ends))
    work = partial(_some, loaded, method, estimator, seed, None)
    return _together(list(mapped(work, lots, executor, "refitting", progress)))


def _some(
    campaign: Campaign,
    method: str,
    estimator: Estimator | None,
    seed: int | None,
    tell: Listener | None,
    numbers: tuple[int, int],
) -> Resampling:
    """The refits of these numbers, from the first to before the last."""
    told, samples = campaign._native.resample(method, estimator, numbers, seed, tell)
    return replace(build(Resampling, json.loads(told)), samples=samples)


def _together(lots: list[Resampling]) -> Resampling:
    """The refits of several lots as one result, summed in the order in which one process sums."""
    samples = np.vstack([lot.samples for lot in lots if lot.samples is not None])
    n = len(samples)
    mean = np.cumsum(samples, axis=0)[-1] / n
    std = np.sqrt(np.cumsum((samples - mean) ** 2, axis=0)[-1] / (n - 1.0))
    ordered = np.sort(samples, axis=0)
    ends = []
    for level in (0.025, 0.975):
        low, part = int(level * (n - 1)), level * (n - 1) % 1.0
        ends.append(ordered[low] + part * (ordered[min(low + 1, n - 1)] - ordered[low]))
    spread = zip(lots[0].parameters, mean.tolist(), std.tolist(), ends[0].tolist(), ends[1].tolist(), strict=True)
    parameters = tuple(replace(p, mean=m, std=s, interval=(a, b)) for p, m, s, a, b in spread)
    failed = sum(lot.failed for lot in lots)
    return replace(lots[0], draws=n, failed=failed, parameters=parameters, samples=samples)


def _of_runs(
    campaign: Campaign,
    draws: int,
    block: float | None,
    seed: int,
    estimator: Estimator | None,
    executor: Workers | None,
    progress: Progress,
) -> Resampling:
    whole = fit(campaign, estimator=estimator)
    # the staged procedure leaves what no stage shows
    free = [p for p in whole.parameters if not p.fixed and not p.per_run and p.std is not None]
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
    found = [row for rows in mapped(work, lots, executor, "drawing", progress) for row in rows]
    good = np.array([row for row in found if row is not None])
    if 2 * len(good) < draws:
        raise DataError(
            f"{draws - len(good)} of {draws} draws do not determine a fit: more runs or shorter blocks are needed"
        )
    ends = np.quantile(good, [0.025, 0.975], axis=0).T.tolist()
    spread = zip(free, good.mean(axis=0).tolist(), good.std(axis=0, ddof=1).tolist(), ends, strict=True)
    parameters = tuple(Scatter(p.term, p.name, p.value, m, s, (a, b), p.unit) for p, m, s, (a, b) in spread)
    failed = draws - len(good)
    return Resampling(1, "runs", len(good), failed, seed, parameters, block, whole.warnings, good)


LOT = 8
"""Draws that a worker makes at once, at least."""
LOTS = 32
"""Lots at most into which refits are cut that begin with a fit of their own."""


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
        result, *_ = campaign._native.resampled(list(stretches)).fit(estimator, False, None)
    except DataError:
        return None
    found = {(p.term, p.name): p.value for p in build(Fit, json.loads(result)).parameters}
    return [found[name] for name in names]
