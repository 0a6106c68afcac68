"""The verbs that write files: `export`, `report`, `tank_campaign`, `demo`."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from os import PathLike, fspath
from pathlib import Path
from typing import Any, cast

from . import _native
from ._campaign import Campaign, campaign_of
from ._errors import DataError, UsageError
from ._files import may_write, write
from ._fit import Fit
from ._model import Model
from ._models import Export
from ._plain import build
from ._progress import Progress, listener
from ._verbs import AnyModel, Published, Source, published, text_of


def export(
    source: AnyModel,
    to: str,
    path: str | PathLike[str] | None = None,
    *,
    link: str | None = None,
    mass: float | None = None,
    inertia: Sequence[float] | None = None,
    at: Mapping[str, float] | None = None,
    acting: bool = False,
    target_version: str | None = None,
) -> Export:
    """Exports a model to a file for another tool; `Export.lost` names what the file cannot represent.

    Args:
        source: a fit, a model, or the path of a model file; for ``gazebo-thrusters`` and ``ardusub`` that of a
            campaign.
        to: ``gazebo``, ``gazebo-added-mass``, ``gazebo-thrusters``, ``uuv``, ``urdf``, ``mujoco``,
            ``python-vehicle-simulator``, ``fossen-python``, ``fossen-matlab``, ``c-header``, ``linear-json``,
            ``linear-python``, ``linear-mat``, ``kalman`` (JSON), ``kalman-toml``, ``kalman-python``, ``kalman-mat``,
            ``ardusub``, ``latex`` or ``csv``.
        path: file to write; the content is only in the result when absent.
        link: name of the link on which the forces act.
        mass: dry mass, kg; that of the vehicle when absent.
        inertia: dry moments of inertia in roll, pitch and yaw, kg·m².
        at: operating point of a linear model: states and forces by name.
        acting: forces in the target are effective ones: losses of thrust (``[efficiency]``) are applied by the program
            that computes them. Without it, a target that cannot represent the losses is refused.
        target_version: version of the simulator that will read the file, ``"8"`` or ``"7.2"``.

    Raises:
        UsageError: an unknown target, something that the target needs but the model lacks, losses of thrust that
            it cannot represent, or a version that cannot read the file.
    """
    is_file = not isinstance(source, Fit | Model)
    text = fspath(cast("str", source)) if is_file else text_of(source)
    told, content = _native.export_model(text, is_file, to, link, mass, inertia, dict(at or {}), acting, target_version)
    made = build(Export, json.loads(told) | {"content": content})
    if path is not None:
        write(path, content, force=True)
    return made


def report(
    campaign: Source,
    output: str | PathLike[str],
    *,
    discovery: bool = True,
    params: Published | None = None,
    force: bool = False,
    progress: Progress = None,
) -> Path:
    """Writes everything about a campaign as one HTML page, and returns its path.

    Args:
        campaign: a campaign, or the path of one.
        output: page to write, atomically.
        discovery: also search for missing effects.
        params: published parameters to show next to the estimates, as for `compare_published`.
        force: replace an existing file.
        progress: as for `discover`.
    """
    place = may_write(output, force)
    with listener(progress) as tell:
        native = campaign_of(campaign, tell)._native
    inputs = [(path.name, hashlib.sha256(path.read_bytes()).hexdigest()) for path in map(Path, native.sources())]
    given = None if params is None else published(params)
    with listener(progress) as tell:
        page = native.report(discovery, given, f"hydrosysid.report(…, discovery={discovery})", inputs, tell)
    write(place, page.encode(), force)
    return place


def tank_campaign(folder: str | PathLike[str], *, seed: int = 1, noise: float = 1.0, force: bool = False) -> Campaign:
    """Writes the paper's campaign, simulated in the virtual tank, into a folder, and reads it.

    Args:
        folder: where ``campaign.toml`` and its logs are written; made when absent.
        seed: seed of everything random.
        noise: sensor noise as a multiple of the paper's; 0 for perfect sensors.
        force: replace an existing campaign.

    Raises:
        UsageError: the folder holds a campaign already, or cannot be written.
    """
    file = may_write(Path(folder) / "campaign.toml", force)
    _native.tank_campaign(fspath(folder), seed, noise)
    return Campaign.from_file(file)


def demo(
    folder: str | PathLike[str] = "demo",
    *,
    seed: int = 1,
    noise: float = 1.0,
    hide: str = "coriolis_yaw",
    progress: Progress = None,
) -> dict[str, Any]:
    """Runs the whole procedure on the virtual tank, and discovers a hidden effect; takes a minute.

    Args:
        folder: folder for campaigns, model, report and numbers; only that of an earlier demo is replaced.
        seed: seed of the tank.
        noise: sensor noise as a multiple of the default.
        hide: effect that the second campaign hides, an id of `effects`.
        progress: as for `discover`.

    Returns:
        The numbers, as ``demo.json`` holds them.

    Raises:
        DataError, UsageError: the reason is on standard error.
    """
    words = ["demo", "--quiet", "--force", "--folder", fspath(folder), "--seed", str(seed), "--noise", str(noise)]
    with listener(progress) as tell:
        code = _native.watched_command(["hydrosysid", *words, "--hide", hide], tell)
    if code != 0:
        kind = DataError if code == 1 else UsageError
        raise kind("the demo failed: the reason is on standard error")
    numbers: dict[str, Any] = json.loads((Path(folder) / "demo.json").read_text(encoding="utf-8"))
    return numbers
