"""The verbs of the command as functions: on a campaign, or the path of one."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import replace
from os import PathLike, fspath
from pathlib import Path
from typing import Any, Literal, cast

from . import _native
from ._campaign import Campaign, campaign_of
from ._check import Check
from ._cross import CrossValidation
from ._discovery import Discovery
from ._errors import UsageError
from ._fit import Fit, RunResiduals
from ._forces import Forces
from ._model import Model
from ._models import ModelDifference, Monitored, PublishedComparison
from ._motion import Comparison, SimulatedRun, Simulation
from ._plain import build, plain
from ._planning import Plan
from ._progress import Listener, Progress, listener
from ._run import Run
from ._settings import toml_text

Source = Campaign | str | PathLike[str]
AnyModel = Fit | Model | str | PathLike[str]
Estimator = Literal["filter_error", "output_error", "staged", "integral"]


def fit(
    campaign: Source,
    *,
    estimator: Estimator | None = None,
    thorough: bool = False,
    stream: bool | None = None,
    progress: Progress = None,
) -> Fit:
    """Fits the free parameters of the baseline to the training runs.

    Args:
        campaign: a campaign, or the path of one.
        estimator: that of the campaign, else the one that suits its runs, when absent.
        thorough: profile likelihoods of doubtful parameters, segments of other lengths, and the most informative
            next run, in `Fit.identifiability`, some ten fits; for fits by rows, halves of the runs and longer windows.
        stream: read the logs piece by piece and keep none of them; integral least squares of a campaign that is given
            by its path. When absent: where ``estimator="integral"`` would have to keep more than 64 MiB of logs.
        progress: as for `discover`.

    Raises:
        DataError: the data does not determine the parameters, or a run cannot be read piece by piece.
        UsageError: `stream` with a campaign in memory, or with another estimator.
    """
    with listener(progress) as tell:
        if stream is None:
            stream = (
                isinstance(campaign, str | PathLike)
                and not thorough
                and _native.too_large_to_keep(fspath(campaign), estimator)
            )
        if stream:
            if isinstance(campaign, Campaign) or thorough or estimator not in (None, "integral"):
                raise UsageError("stream = True: integral least squares of a campaign that is given by its path")
            result, model = _native.fit_streamed(fspath(campaign), tell)
            left: list[Any] = []
        else:
            result, model, left = campaign_of(campaign, tell)._native.fit(estimator, thorough, tell)
    return replace(build(Fit, json.loads(result)), model=Model(model), residuals=tuple(RunResiduals(*r) for r in left))


def simulate(campaign: Source, model: AnyModel | None = None, *, progress: Progress = None) -> Simulation:
    """Simulates a model over the runs of free motion, each from a state estimated on its first seconds.

    Args:
        campaign: a campaign, or the path of one.
        model: a fit, a model, or the path of a model file; the campaign is fitted when absent.
        progress: as for `discover`.
    """
    with listener(progress) as tell:
        loaded = campaign_of(campaign, tell)
        return _simulated(loaded, _model(loaded, model, tell), tell)


def _simulated(campaign: Campaign, model: str, tell: Listener | None) -> Simulation:
    told, trajectories = campaign._native.simulate(model, tell)
    made = build(Simulation, json.loads(told))
    runs = zip(made.runs, trajectories, strict=True)
    return replace(made, runs=tuple(SimulatedRun(run.run, run.role, *arrays) for run, arrays in runs))


def force_components(
    campaign: Source, model: AnyModel | None = None, *, progress: Progress = None
) -> tuple[Forces, ...]:
    """The force of each term of a model over time, for each run of free motion and degree of freedom.

    A balance that depends on a quantity that no sensor logs has no entry.

    Args:
        campaign: a campaign, or the path of one.
        model: a fit, a model, or the path of a model file; the campaign is fitted when absent.
        progress: as for `discover`.
    """
    with listener(progress) as tell:
        loaded = campaign_of(campaign, tell)
        told, series = loaded._native.components(_model(loaded, model, tell), tell)
    entries = zip(json.loads(told)["runs"], series, strict=True)
    return tuple(Forces(entry["run"], entry["dof"], *arrays, entry["unit"]) for entry, arrays in entries)


def compare(campaign: Source, model: AnyModel | None = None, *, progress: Progress = None) -> Comparison:
    """Compares a model with every run of free motion, those of the fit and the held-out ones.

    The runs themselves, measured and simulated, are in `Comparison.simulation`.

    Args:
        campaign: a campaign, or the path of one.
        model: a fit, a model, or the path of a model file; the campaign is fitted when absent.
        progress: as for `discover`.
    """
    with listener(progress) as tell:
        loaded = campaign_of(campaign, tell)
        text = _model(loaded, model, tell)
        compared = build(Comparison, json.loads(loaded._native.compare(text, tell)))
        return replace(compared, simulation=_simulated(loaded, text, tell))


Family = Literal["body", "actuator", "environment", "sensor"]
Published = str | PathLike[str] | Mapping[str, Any]


def published(params: Published) -> tuple[str, str]:
    """Text and name of published parameters."""
    if isinstance(params, Mapping):
        return toml_text(params), "params"
    return Path(params).read_text(encoding="utf-8"), fspath(params)


def compare_published(
    campaign: Source, params: Published, model: AnyModel | None = None, *, progress: Progress = None
) -> PublishedComparison:
    """Compares published parameters with the runs of a campaign and with its own estimates.

    Args:
        campaign: a campaign, or the path of one.
        params: the path of a TOML file, or its content as a mapping: ``format``, ``convention`` (``sname``,
            ``hydrosysid`` or ``fossen``), ``source``, ``mass``, ``inertia`` and ``parameters``.
        model: your own model: a fit, a model, or the path of a model file; the campaign is fitted when absent.
        progress: as for `discover`.

    Raises:
        UsageError: an unknown parameter, or a convention that does not fit; the message names the key.
    """
    with listener(progress) as tell:
        loaded = campaign_of(campaign, tell)
        result = loaded._native.compare_published(_model(loaded, model, tell), *published(params), tell)
    return build(PublishedComparison, json.loads(result))


def cross_validate(
    campaign: Source, *, estimator: Estimator | None = None, progress: Progress = None
) -> CrossValidation:
    """Fits each run alone and simulates its model on every other run: Table 6 of the paper.

    Args:
        campaign: a campaign, or the path of one.
        estimator: as for `fit`. For a staged fit, the stages of single runs are used; else a training run is fitted by
            output error, with the common estimates as priors of 100 % standard deviation, so that what it does not show
            keeps its value.
        progress: as for `discover`.

    Raises:
        DataError: the data does not determine the parameters.
    """
    with listener(progress) as tell:
        return build(CrossValidation, json.loads(campaign_of(campaign, tell)._native.cross_validate(estimator, tell)))


def compare_models(a: AnyModel, b: AnyModel, *, names: tuple[str, str] | None = None) -> ModelDifference:
    """Compares two models of a vehicle: each parameter with its interval, and all together.

    Args:
        a: a fit, a model, or the path of a model file.
        b: another.
        names: what they are called in the result; the paths, or ``a`` and ``b``.
    """
    texts = [text_of(m) for m in (a, b)]
    called = [letter if isinstance(m, Fit | Model) else fspath(m) for m, letter in ((a, "a"), (b, "b"))]
    result = _native.model_difference(texts[0], texts[1], list(names or called))
    return build(ModelDifference, json.loads(result))


def monitor(
    campaign: Source, model: AnyModel, *, window: float = 8.0, level: float = 0.01, progress: Progress = None
) -> Monitored:
    """Runs a model with fixed parameters along the runs of a campaign and reports where it no longer fits.

    Args:
        campaign: the new logs as a campaign, or the path of one.
        model: a fit, a model, or the path of a model file.
        window: length of a window, s.
        level: probability of a false alarm in all windows together, for white noise.
        progress: as for `discover`.
    """
    with listener(progress) as tell:
        loaded = campaign_of(campaign, tell)
        return build(Monitored, json.loads(loaded._native.monitor(_model(loaded, model), window, level, tell)))


def discover(campaign: Source, *, families: Iterable[Family] | None = None, progress: Progress = None) -> Discovery:
    """Searches for what the baseline lacks, and names it only if held-out runs agree.

    Ctrl-C ends it within a fraction of a second, as it does every long verb.

    Args:
        campaign: a campaign, or the path of one.
        families: families of effects to search, in addition to your own; those of the campaign when absent.
        progress: `True` for a bar of tqdm (``hydrosysid[progress]``), or a line where there is no tqdm; or a function
            that is called as ``progress(what, done, of)``; an exception in it ends the work and propagates.
    """
    chosen = None if families is None else list(families)
    with listener(progress) as tell:
        return build(Discovery, json.loads(campaign_of(campaign, tell)._native.discover(chosen, tell)))


def plan(
    source: Campaign | AnyModel,
    *,
    want: str | Iterable[str] = (),
    limits: Mapping[str, float] | None = None,
    noise: Mapping[str, float] | None = None,
    rates: float | Mapping[str, float] | None = None,
    length: float = 90.0,
    most: int = 12,
    room: float | None = None,
    without_known: bool = False,
    runs: Iterable[Mapping[str, Any]] | None = None,
    rehearse: int = 0,
    seed: int = 1,
    progress: Progress = None,
) -> Plan:
    """Proposes runs that reach the requested standard errors, or predicts those of given runs.

    Args:
        source: a campaign, which is fitted first, a fit, or the path of a campaign or a model file.
        want: requested standard errors: ``"k_u|u|=10"`` (SI), ``"inertia@yaw=3%"``, or ``"5%"`` for all, the default.
        limits: largest force or moment by degree of freedom, N and N·m; those of the thrusters or of the runs of the
            model when absent.
        noise: noise of sensors by channel, SI; that of the runs of the model when absent.
        rates: rate of all sensors, Hz, or of each by channel.
        length: length of each run, s.
        most: maximum number of runs.
        room: largest horizontal distance from the start of a run, m.
        without_known: ignore the data to which the model was fitted; otherwise they are included.
        runs: runs to judge instead, each with ``name``, ``kind``, ``length``, ``pushes`` as in `Plan.runs`.
        rehearse: number of simulated campaigns by which the plan is checked.
        seed: seed of the rehearsal.
        progress: as for `discover`.

    Raises:
        DataError: nothing can be planned.
        UsageError: an invalid request or limit.
    """
    request: dict[str, Any] = {
        "wants": [want] if isinstance(want, str) else list(want),
        "limits": dict(limits or {}),
        "noise": dict(noise or {}),
        "rates": {"": float(rates)} if isinstance(rates, int | float) else dict(rates or {}),
        "length": length,
        "most": most,
        "room": room,
        "without_known": without_known,
        "runs": None if runs is None else [_manoeuvre(run) for run in runs],
        "rehearse": rehearse,
        "seed": seed,
    }
    text = json.dumps(request)
    model = _model_text(source)
    with listener(progress) as tell:
        if model is None:
            result, told = _native.plan_campaign(campaign_of(cast("Source", source), tell)._native, text, tell)
        else:
            result, told = _native.plan_model(model, text, tell)
    commands = tuple(Run(signals, name=name, kind=kind) for name, kind, signals in told)
    return build(Plan, json.loads(result) | {"commands": commands})


def _manoeuvre(run: Any) -> dict[str, Any]:
    data = run if isinstance(run, Mapping) else plain(run)
    return {key: data[key] for key in ("name", "kind", "length", "pushes") if key in data}


def _model_text(source: Campaign | AnyModel) -> str | None:
    """The text of a model file; `None` for a campaign."""
    if isinstance(source, Campaign):
        return None
    if isinstance(source, Fit | Model):
        return text_of(source)
    if Path(source).is_dir():
        return None
    text = Path(source).read_text(encoding="utf-8")
    # a model says which version wrote it, a campaign never does
    return text if "hydrosysid" in tomllib.loads(text) else None


def check(
    source: str | PathLike[str] | Iterable[str | PathLike[str]],
    *,
    allow_outside: bool = False,
    required: Iterable[str] = (),
    progress: Progress = None,
    **log: Any,
) -> Check:
    """Checks a campaign (a ``.toml`` file, or a folder with one) or bare logs before anything is fitted.

    Refused data is a result, not an exception.

    Args:
        source: a campaign file, a log, or several logs.
        allow_outside: let the campaign's logs lie outside its folder.
        required: columns that a bare log must have.
        progress: as for `discover`.
        log: the reading options of ``[log]`` for bare logs.
    """
    if isinstance(source, str | PathLike):
        if Path(source).suffix == ".toml" or Path(source).is_dir():
            with listener(progress) as tell:
                return build(Check, json.loads(_native.check_campaign(fspath(source), allow_outside, tell)))
        source = [source]
    paths = [fspath(path) for path in source]
    with listener(progress) as tell:
        return build(Check, json.loads(_native.check_logs(paths, json.dumps(log), list(required), tell)))


def _model(campaign: Campaign, model: AnyModel | None, tell: Listener | None = None) -> str:
    if model is None:
        return fit(campaign, progress=tell).model.to_toml()
    return text_of(model)


def text_of(model: AnyModel) -> str:
    """The text of a model's file."""
    if isinstance(model, Fit):
        return model.model.to_toml()
    return model.to_toml() if isinstance(model, Model) else Path(model).read_text(encoding="utf-8")
