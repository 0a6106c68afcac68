"""The verbs of the command as functions: on a campaign, or the path of one."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Iterable, Mapping
from os import PathLike, fspath
from pathlib import Path
from typing import Any, Literal, cast

from . import _native
from ._campaign import Campaign, campaign_of
from ._discovery import Discovery
from ._errors import UsageError
from ._fit import Fit
from ._motion import Check, Comparison, Simulation
from ._plain import build, plain
from ._planning import Plan
from ._progress import Progress, listener
from ._resampling import Resampling
from ._run import Run

Source = Campaign | str | PathLike[str]
Model = Fit | str | PathLike[str]
Estimator = Literal["output_error", "staged", "integral"]


def fit(
    campaign: Source,
    *,
    estimator: Estimator | None = None,
    thorough: bool = False,
    progress: Progress = None,
) -> Fit:
    """Fits the free parameters of the baseline to the training runs.

    Args:
        campaign: a campaign, or the path of one.
        estimator: that of the campaign, else the one that suits its runs, when absent.
        thorough: profile likelihoods of doubtful parameters, segments of other lengths, and the run that would tell
            most, in `Fit.identifiability`; output error only, some ten fits.
        progress: as for `discover`.

    Raises:
        DataError: the data does not determine the parameters.
    """
    with listener(progress) as tell:
        result, model = campaign_of(campaign)._native.fit(estimator, thorough, tell)
    return build(Fit, json.loads(result) | {"model": model})


def resample(
    campaign: Source,
    *,
    method: Literal["bootstrap", "monte_carlo"] = "bootstrap",
    draws: int = 1000,
    progress: Progress = None,
) -> Resampling:
    """Refits the baseline by output error many times, on all cores, to show how far estimates scatter.

    Args:
        campaign: a campaign, or the path of one.
        method: ``bootstrap`` draws stretches of the training runs with replacement and asks that those be independent
            of each other; ``monte_carlo`` fits data that the fitted model made and asks that the model be right.
        draws: number of refits; a whole fit each with ``monte_carlo``.
        progress: called as ``progress(what, done, of)``; `True` shows a bar.

    Raises:
        DataError: the data does not determine the parameters, or has too few stretches to draw from.
    """
    if draws < 2:
        raise UsageError(f"draws = {draws}: at least 2 are needed")
    with listener(progress) as heard:
        return build(Resampling, json.loads(campaign_of(campaign)._native.resample(method, draws, heard)))


def simulate(campaign: Source, model: Model | None = None, *, progress: Progress = None) -> Simulation:
    """Simulates a model over the runs of free motion, each from a state estimated on its first seconds.

    Args:
        campaign: a campaign, or the path of one.
        model: a fit, or the path of a model file; fitted now when absent.
        progress: as for `discover`.
    """
    loaded = campaign_of(campaign)
    with listener(progress) as tell:
        return build(Simulation, json.loads(loaded._native.simulate(_model(loaded, model), tell)))


def compare(campaign: Source, model: Model | None = None, *, progress: Progress = None) -> Comparison:
    """Holds a model against every run of free motion, those of the fit and those that took no part.

    Args:
        campaign: a campaign, or the path of one.
        model: a fit, or the path of a model file; fitted now when absent.
        progress: as for `discover`.
    """
    loaded = campaign_of(campaign)
    with listener(progress) as tell:
        return build(Comparison, json.loads(loaded._native.compare(_model(loaded, model), tell)))


Family = Literal["body", "actuator", "environment", "sensor"]


def discover(campaign: Source, *, families: Iterable[Family] | None = None, progress: Progress = None) -> Discovery:
    """Looks for what the baseline lacks, and names it only where held-out runs agree.

    Ctrl-C ends it within a fraction of a second, as it does every long verb.

    Args:
        campaign: a campaign, or the path of one.
        families: families of effects to search, besides your own; those of the campaign when absent.
        progress: `True` for a bar of tqdm (``hydrosysid[progress]``), or a function that is called as
            ``progress(what, done, of)``; what it raises ends the work and passes through.
    """
    chosen = None if families is None else list(families)
    with listener(progress) as tell:
        return build(Discovery, json.loads(campaign_of(campaign)._native.discover(chosen, tell)))


def plan(
    source: Campaign | Model,
    *,
    want: str | Iterable[str] = (),
    limits: Mapping[str, float] | None = None,
    noise: Mapping[str, float] | None = None,
    rates: float | Mapping[str, float] | None = None,
    length: float = 90.0,
    most: int = 12,
    room: float | None = None,
    with_known: bool = False,
    runs: Iterable[Mapping[str, Any]] | None = None,
    rehearse: int = 0,
    seed: int = 1,
) -> Plan:
    """Proposes the runs that bring parameters to wanted deviations, or says what given runs will bring.

    Args:
        source: a campaign, which is fitted first, a fit, or the path of a campaign or a model file.
        want: wanted deviations: ``"k_u|u|=10"`` (SI), ``"inertia@yaw=3%"``, or ``"5%"`` for all; 5 % when absent.
        limits: greatest force or moment by degree of freedom, N and N·m; those of the thrusters or of the runs of the
            model when absent.
        noise: noise of sensors by channel, SI; that of the runs of the model when absent.
        rates: rate of all sensors, Hz, or of each by channel.
        length: length of each run, s.
        most: most runs.
        room: greatest horizontal distance from the start of a run, m.
        with_known: count on the data that the model comes from.
        runs: runs to judge instead, each with ``name``, ``kind``, ``length``, ``pushes`` as in `Plan.runs`.
        rehearse: number of simulated campaigns by which the plan is checked.
        seed: seed of the rehearsal.

    Raises:
        DataError: nothing can be planned.
        UsageError: a wish or a limit that cannot be.
    """
    request: dict[str, Any] = {
        "wants": [want] if isinstance(want, str) else list(want),
        "limits": dict(limits or {}),
        "noise": dict(noise or {}),
        "rates": {"": float(rates)} if isinstance(rates, int | float) else dict(rates or {}),
        "length": length,
        "most": most,
        "room": room,
        "with_known": with_known,
        "runs": None if runs is None else [_manoeuvre(run) for run in runs],
        "rehearse": rehearse,
        "seed": seed,
    }
    text = json.dumps(request)
    model = _model_text(source)
    if model is None:
        result, told = _native.plan_campaign(campaign_of(cast("Source", source))._native, text)
    else:
        result, told = _native.plan_model(model, text)
    commands = tuple(Run(signals, name=name, kind=kind) for name, kind, signals in told)
    return build(Plan, json.loads(result) | {"commands": commands})


def _manoeuvre(run: Any) -> dict[str, Any]:
    data = run if isinstance(run, Mapping) else plain(run)
    return {key: data[key] for key in ("name", "kind", "length", "pushes") if key in data}


def _model_text(source: Campaign | Model) -> str | None:
    """The text of a model file; `None` for a campaign."""
    if isinstance(source, Campaign):
        return None
    if isinstance(source, Fit):
        return source.model
    text = Path(source).read_text(encoding="utf-8")
    # a model says which version wrote it, a campaign never does
    return text if "hydrosysid" in tomllib.loads(text) else None


def check(
    source: str | PathLike[str] | Iterable[str | PathLike[str]],
    *,
    allow_outside: bool = False,
    required: Iterable[str] = (),
    **log: Any,
) -> Check:
    """Checks a campaign (a ``.toml`` file) or bare logs before anything is fitted; what is refused is a result.

    Args:
        source: a campaign file, a log, or several logs.
        allow_outside: let the campaign's logs lie outside its folder.
        required: columns that a bare log must have.
        log: the reading options of ``[log]`` for bare logs.
    """
    if isinstance(source, str | PathLike):
        if Path(source).suffix == ".toml":
            return build(Check, json.loads(_native.check_campaign(fspath(source), allow_outside)))
        source = [source]
    paths = [fspath(path) for path in source]
    return build(Check, json.loads(_native.check_logs(paths, json.dumps(log), list(required))))


def tank_campaign(folder: str | PathLike[str], *, seed: int = 1, noise: float = 1.0) -> Campaign:
    """Writes the paper's campaign, sailed in the virtual tank, into a folder, and reads it.

    Args:
        folder: where ``campaign.toml`` and its logs are written; made when absent.
        seed: seed of everything random.
        noise: noise of the sensors in units of the paper's; 0 for perfect ones.
    """
    _native.tank_campaign(fspath(folder), seed, noise)
    return Campaign.from_file(Path(folder) / "campaign.toml")


def _model(campaign: Campaign, model: Model | None) -> str:
    if model is None:
        return fit(campaign).model
    return model.model if isinstance(model, Fit) else Path(model).read_text(encoding="utf-8")
