"""The verb `init` on logs of any format: the campaign's folder, the logs in it, and the text."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Iterable, Mapping
from os import PathLike, fspath
from pathlib import Path
from typing import Any

from . import _native
from ._errors import UsageError
from ._files import may_write, write
from ._formats import is_known
from ._scaffold_logs import Findings


def init(
    logs: Iterable[str | PathLike[str]],
    output: str | PathLike[str] | None = None,
    *,
    vehicle: str | PathLike[str] | None = None,
    name: str = "",
    mass: float | None = None,
    volume: float | None = None,
    weight: float | None = None,
    buoyancy: float | None = None,
    length: float | None = None,
    force: bool = False,
    msg: Iterable[str | PathLike[str]] = (),
    **log: Any,
) -> str:
    """The text of a commented campaign for logs as they come off a vehicle; every guess is a comment ``# guessed:``.

    Args:
        logs: CSV, and with `output` any other format that `convert` reads; several logs of one dive are merged.
        output: folder, or campaign file (``.toml``), to write. Logs outside the folder are copied into it, those of
            other formats as CSV.
        vehicle: one that comes with the program (`vehicles`), or a vehicle file.
        name: name of the vehicle; that of the vehicle file when empty.
        mass: dry mass, kg.
        volume: displaced volume, m³.
        weight: weight in air, N.
        buoyancy: buoyancy, N.
        length: characteristic length, m.
        force: replace an existing campaign.
        msg: definitions of ROS messages that bags do not contain: ``.msg`` files, or folders of them.
        log: reading options of ``[log]``; they win over guesses. ``columns`` of other formats name a field as
            ``STREAM:FIELD``.

    Raises:
        UsageError: no such vehicle or log, a log of another format without `output`, or an existing campaign.
    """
    figures = (mass, volume, weight, buoyancy, length)
    return scaffold(logs, output, (name, figures, vehicle), log, msg=msg, force=force)


def scaffold(
    logs: Iterable[str | PathLike[str]],
    output: str | PathLike[str] | None,
    about: tuple[str, tuple[float | None, ...], str | PathLike[str] | None],
    log: Mapping[str, Any],
    *,
    msg: Iterable[str | PathLike[str]],
    force: bool,
    told: Callable[[list[str]], None] | None = None,
) -> str:
    """As `init`; `about` is the vehicle's name, its figures and the one that it is.

    `told` hears the warnings before the campaign is written, and what it raises leaves it unwritten.
    """
    name, figures, vehicle = about
    file = None if output is None else campaign_file(Path(output))
    folder = Path() if file is None else may_write(file, force).parent
    if file is not None:
        folder.mkdir(parents=True, exist_ok=True)
    given = [Path(path) for path in logs]
    for path in given:
        if not path.exists():
            raise UsageError(f"{path}: there is no such log")
        if is_known(path) and file is None:
            raise UsageError(f"{path}: give with output where to write it as CSV")
    found = Findings(folder, log, tuple(fspath(one) for one in msg), {p.name for p in given if not is_known(p)})
    shown = []
    for path in given:
        shown += found.convert(path) if is_known(path) else [_beside(path, folder, file is not None)]
    chosen = None if vehicle is None else str(vehicle)
    options, learned = json.dumps(found.left()), json.dumps(found.learned())
    text, companions, warnings = _native.init_campaign(shown, name, figures, chosen, options, learned)
    if told is not None:
        told([*found.unread, *found.warned, *warnings])
    if file is not None:
        for source, beside in companions:
            _copy(Path(source), folder / beside)
        write(file, text.encode(), force)
    return text


def vehicles() -> dict[str, dict[str, Any]]:
    """The vehicles that come with the program: name to the tables of its file.

    >>> len(vehicles()["bluerov2-heavy"]["thruster"])
    8
    """
    found: dict[str, dict[str, Any]] = dict(json.loads(_native.known_vehicles()))
    return found


def campaign_file(output: Path) -> Path:
    """The campaign file that is asked for: a name without ``.toml`` is a folder.

    >>> campaign_file(Path("dive")).as_posix()
    'dive/campaign.toml'
    """
    return output if output.suffix == ".toml" and not output.is_dir() else output / "campaign.toml"


def _beside(path: Path, folder: Path, writes: bool) -> tuple[str, str]:
    """A CSV log and how the campaign names it; copied into the folder where it lies elsewhere."""
    try:
        return str(path), path.resolve().relative_to(folder.resolve()).as_posix()
    except ValueError:
        if not writes:
            return str(path), path.as_posix()
    _copy(path, folder / path.name)
    return str(folder / path.name), path.name


def _copy(path: Path, target: Path) -> None:
    """Copies a file; one that is there already is left where it holds the same."""
    if target.exists():
        if target.read_bytes() != path.read_bytes():
            raise UsageError(f"{target} already exists and is a different file from {path}: rename one of them")
        return
    shutil.copyfile(path, target)
