"""The verbs that write files: `init`, `report`, `demo`."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from os import PathLike, fspath
from pathlib import Path
from typing import Any

from . import _native
from ._campaign import campaign_of
from ._errors import DataError, UsageError
from ._files import may_write, write
from ._progress import Progress, listener
from ._verbs import Source


def init(
    logs: Iterable[str | PathLike[str]],
    output: str | PathLike[str] | None = None,
    *,
    name: str = "vehicle",
    mass: float | None = None,
    volume: float | None = None,
    weight: float | None = None,
    buoyancy: float | None = None,
    length: float | None = None,
    force: bool = False,
    **log: Any,
) -> str:
    """The text of a commented campaign file from a set of logs and what is known of the vehicle.

    Args:
        logs: CSV logs; they lie in the campaign's folder or below it.
        output: file to write, whole or not at all.
        name: name of the vehicle.
        mass: dry mass, kg.
        volume: displaced volume, m³.
        weight: weight in air, N.
        buoyancy: buoyancy, N.
        length: characteristic length, m.
        force: replace a file that is there.
        log: reading options of ``[log]``.

    Raises:
        DataError: a log that cannot be read.
        UsageError: a log outside the folder, or `output` exists.
    """
    folder = Path() if output is None else may_write(output, force).parent
    shown = []
    for log_file in logs:
        path = Path(log_file)
        try:
            inside = path.resolve().relative_to(folder.resolve()).as_posix()
        except ValueError:
            text = "a log lies in the campaign's folder or below it; write the campaign there"
            raise UsageError(f"{path}: {text}") from None
        shown.append((fspath(path), inside))
    text = _native.init_campaign(shown, name, mass, volume, weight, buoyancy, length, json.dumps(log))
    if output is not None:
        write(output, text.encode(), force)
    return text


def report(
    campaign: Source,
    output: str | PathLike[str],
    *,
    discovery: bool = True,
    force: bool = False,
    progress: Progress = None,
) -> Path:
    """Writes everything about a campaign as one HTML page, and returns its path.

    Args:
        campaign: a campaign, or the path of one.
        output: page to write, whole or not at all.
        discovery: search for what is missing, too.
        force: replace a file that is there.
        progress: as for `discover`.
    """
    place = may_write(output, force)
    native = campaign_of(campaign)._native
    inputs = [(path.name, hashlib.sha256(path.read_bytes()).hexdigest()) for path in map(Path, native.sources())]
    with listener(progress) as tell:
        page = native.report(discovery, f"hydrosysid.report(…, discovery={discovery})", inputs, tell)
    write(place, page.encode(), force)
    return place


def demo(
    folder: str | PathLike[str] = "demo", *, seed: int = 1, noise: float = 1.0, hide: str = "coriolis_yaw"
) -> dict[str, Any]:
    """The whole procedure on the virtual tank, and an effect that was hidden found again; takes a minute.

    Args:
        folder: where campaigns, model, report and numbers are written; an earlier demo's is replaced, nobody else's.
        seed: seed of the tank.
        noise: noise of the sensors in units of the ordinary one.
        hide: effect that the second campaign hides, an id of `effects`.

    Returns:
        The numbers, as ``demo.json`` holds them.

    Raises:
        DataError, UsageError: the reason stands on standard error.
    """
    words = ["demo", "--quiet", "--force", "--folder", fspath(folder), "--seed", str(seed), "--noise", str(noise)]
    code = _native.command(["hydrosysid", *words, "--hide", hide])
    if code != 0:
        kind = DataError if code == 1 else UsageError
        raise kind("the demo was not made: the reason stands on standard error")
    numbers: dict[str, Any] = json.loads((Path(folder) / "demo.json").read_text(encoding="utf-8"))
    return numbers
