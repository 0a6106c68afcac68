"""The verbs of the command as functions: on a campaign, or the path of one."""

from __future__ import annotations

import json
from collections.abc import Iterable
from os import PathLike, fspath
from pathlib import Path
from typing import Any, Literal

from . import _native
from ._campaign import Campaign, campaign_of
from ._discovery import Discovery
from ._fit import Fit
from ._motion import Check, Comparison, Simulation
from ._plain import build

Source = Campaign | str | PathLike[str]
Model = Fit | str | PathLike[str]


def fit(campaign: Source, *, estimator: Literal["output_error", "staged", "integral"] | None = None) -> Fit:
    """Fits the free parameters of the baseline to the training runs.

    Args:
        campaign: a campaign, or the path of one.
        estimator: that of the campaign, else the one that suits its runs, when absent.

    Raises:
        DataError: the data does not determine the parameters.
    """
    result, model = campaign_of(campaign)._native.fit(estimator)
    return build(Fit, json.loads(result) | {"model": model})


def simulate(campaign: Source, model: Model | None = None) -> Simulation:
    """Simulates a model over the runs of free motion, each from a state estimated on its first seconds.

    Args:
        campaign: a campaign, or the path of one.
        model: a fit, or the path of a model file; fitted now when absent.
    """
    loaded = campaign_of(campaign)
    return build(Simulation, json.loads(loaded._native.simulate(_model(loaded, model))))


def compare(campaign: Source, model: Model | None = None) -> Comparison:
    """Holds a model against every run of free motion, those of the fit and those that took no part.

    Args:
        campaign: a campaign, or the path of one.
        model: a fit, or the path of a model file; fitted now when absent.
    """
    loaded = campaign_of(campaign)
    return build(Comparison, json.loads(loaded._native.compare(_model(loaded, model))))


Family = Literal["body", "actuator", "environment", "sensor"]


def discover(campaign: Source, *, families: Iterable[Family] | None = None) -> Discovery:
    """Looks for what the baseline lacks, and names it only where held-out runs agree.

    Args:
        campaign: a campaign, or the path of one.
        families: families of effects to search, besides your own; those of the campaign when absent.
    """
    chosen = None if families is None else list(families)
    return build(Discovery, json.loads(campaign_of(campaign)._native.discover(chosen)))


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
