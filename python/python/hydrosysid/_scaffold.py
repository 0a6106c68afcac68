"""The verb `init` on logs of any format: what is no CSV becomes one in the campaign's folder, its columns guessed."""

from __future__ import annotations

import json
import shutil
from collections import Counter
from collections.abc import Iterable, Mapping
from os import PathLike, fspath
from pathlib import Path
from typing import Any

import numpy as np

from . import _native
from ._errors import DataError, UsageError
from ._files import may_write, write
from ._formats import ColumnMap, Source, format_of, is_known, open_source, run_of
from ._formats.dataflash import told
from ._formats.guess import CLOSED, Guess, guess
from ._frames import write_columns
from ._run import Run

KINDS = {
    ".bin": "ardupilot",
    ".tlog": "mavlink",
    ".ulg": "px4",
    ".bag": "ros",
    ".db3": "ros",
    ".mcap": "ros",
}
"""What names a log has, by its format."""


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
    """The text of a commented campaign from logs as they come off a vehicle; every guess is a comment ``# guessed:``.

    Args:
        logs: CSV, and with `output` any other format that `convert` reads; several of one dive are put together.
        output: folder, or campaign file (``.toml``), to write. Logs outside the folder are copied into it, those of
            other formats as CSV.
        vehicle: one that comes with the program (`vehicles`), or a vehicle file.
        name: name of the vehicle; that of the vehicle file when empty.
        mass: dry mass, kg.
        volume: displaced volume, m³.
        weight: weight in air, N.
        buoyancy: buoyancy, N.
        length: characteristic length, m.
        force: replace a campaign that is there.
        msg: definitions of ROS messages that bags do not hold: ``.msg`` files, or folders of such.
        log: reading options of ``[log]``; they win over guesses.

    Raises:
        UsageError: no such vehicle or log, a log of another format without `output`, or a campaign that is there.
    """
    file = None if output is None else campaign_file(Path(output))
    folder = Path() if file is None else may_write(file, force).parent
    if file is not None:
        folder.mkdir(parents=True, exist_ok=True)
    learned: dict[str, Any] = {"guessed": [], "closed_loop": {}}
    shown: list[tuple[str, str]] = []
    for given in map(Path, logs):
        if not given.exists():
            raise UsageError(f"{given}: there is no such log")
        if not is_known(given):
            shown.append(_beside(given, folder, file is not None))
            continue
        if file is None:
            raise UsageError(f"{given}: say with output where to write what it becomes as CSV")
        made = _converted(given, folder, learned, tuple(fspath(file) for file in msg))
        if made is not None:
            shown.append((str(folder / made), made))
    figures = (mass, volume, weight, buoyancy, length)
    chosen = None if vehicle is None else str(vehicle)
    text, companions = _native.init_campaign(shown, name, figures, chosen, json.dumps(log), json.dumps(learned))
    if file is not None:
        for source, beside in companions:
            shutil.copyfile(source, folder / beside)
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
    target = folder / path.name
    if target.exists() and target.read_bytes() != path.read_bytes():
        raise UsageError(f"{target} is there already and is another log than {path}: rename one of them")
    shutil.copyfile(path, target)
    return str(target), path.name


def _converted(path: Path, folder: Path, learned: dict[str, Any], msg: tuple[str, ...]) -> str | None:
    """Writes a log of another format as CSV into the folder, and notes what was learned; its name, where it has any."""
    made = f"{path.stem or path.name}.csv"
    kind = KINDS.get(format_of(path) or "")
    try:
        if kind is None:
            _table(path, folder / made)
            return made
        source, columns = open_source(path, ColumnMap(msg=msg))
        parameters, modes = told(path) if kind == "ardupilot" else ({}, [])
        found = guess(source, kind, parameters, modes)
        found.reasons += source.notes
        run = _run(source, found, columns)
    except DataError as error:
        learned["guessed"].append(f"{path.name} could not be read: {error}")
        return None
    if run is None:
        learned["guessed"].append(f"nothing of {path.name} could be placed; it has {source.listed(400)}")
        return None
    run = _with_modes(run, modes)
    run.to_csv(folder / made, force=True)
    learned["guessed"] += [f"{path.name}: {reason}" for reason in found.reasons]
    if found.frame is not None:
        learned["ardusub_frame"] = found.frame
        learned["directions"] = found.directions
    learned["log"] = {"missing": "no_sample"}
    learned["closed_loop"][made] = [
        f'{start:.1f} to {end:.1f} s: mode {mode}, a controller steers; where = "closed_loop < 0.5" leaves it out'
        for start, end, mode in found.closed_loop
    ]
    return made


def _run(source: Source, found: Guess, columns: ColumnMap) -> Run | None:
    """The run of the columns that were guessed; those that cannot be read are left out and told."""
    wanted = dict(found.columns)
    while wanted:
        try:
            return run_of(
                source, ColumnMap.of({"columns": wanted, "clock": columns.clock, "msg": columns.msg, **found.options})
            )
        except (DataError, UsageError) as error:
            # velocities along earth axes need each other; of the rest the one that is named is at fault
            named = [n for n in wanted if f"{source.name}: {n}" in str(error) or f"columns.{n}" in str(error)]
            earth = [n for n in ("u", "v", "w") if wanted.get(n, {}).get("frame") in ("ned", "enu")]
            bad = named or earth or list(wanted)[-1:]
            found.reasons.append(f"{', '.join(bad)} left out: {str(error).splitlines()[0]}")
            for n in bad:
                del wanted[n]
    return None


def _with_modes(run: Run, modes: list[tuple[float, int]]) -> Run:
    """The run with ``closed_loop``: 1 where a mode steers, at the stamps of the first command."""
    command = next((n for n in run.signals if n.startswith("V") and n[1:].isdigit()), None)
    if not modes or command is None:
        return run
    stamps = run.signals[command][0]
    which = np.searchsorted(np.array([at for at, _ in modes]), stamps, side="right") - 1
    steers = np.array([0.0 if k < 0 else float(modes[k][1] in CLOSED) for k in which])
    if not steers.any():
        return run
    signals = dict(run.signals) | {"closed_loop": (stamps, steers)}
    made = Run(signals, name=run.name)
    made._set(run.name, run.kind, run.role, run.gaps, signals, run.findings, dict(run.units))
    return made


def _table(path: Path, target: Path) -> None:
    """Columns of a plain table as CSV under their own names, those of the usual length."""
    timed: Mapping[str, Any] = {"columns": {"_": {"name": "_", "time": "_"}}}
    source, _ = open_source(path, ColumnMap.of(timed))
    names = frozenset(source.contents.get("", ()))
    fields = source.read({"": names})[""].fields if names else {}
    if not fields:
        raise DataError(f"{path}: it holds no column of numbers")
    usual, _ = Counter(len(values) for values in fields.values()).most_common(1)[0]
    columns = [name for name in source.contents[""] if len(fields[name]) == usual]
    write_columns(target, {name: fields[name] for name in columns})
