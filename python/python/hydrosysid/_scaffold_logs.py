"""Logs of other formats for `init`: each becomes a CSV in the campaign's folder, its columns guessed, guesses told."""

from __future__ import annotations

import re
import tempfile
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _native
from ._errors import DataError, UsageError
from ._formats import ColumnMap, Source, format_of, open_source
from ._formats.autopilot import Told, closed_loop, told
from ._formats.guess import Guess, guess
from ._formats.make import run_and_origin
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
OWN = ("body_frame", "earth_frame", "missing", "duplicates", "sort", "clock", "time_unit")
"""Reading options that hold for logs of other formats as for CSV."""


class Findings:
    """What is learned where logs are converted, for the text of the campaign.

    Args:
        folder: the campaign's folder.
        options: reading options that somebody has said.
        msg: definitions of ROS messages.
        taken: names in the folder that other logs have.
    """

    def __init__(self, folder: Path, options: Mapping[str, Any], msg: tuple[str, ...], taken: set[str]) -> None:
        self.folder, self.options, self.msg, self.taken = folder, dict(options), msg, set(taken)
        self.guessed: list[str] = []
        self.unread: list[str] = []
        self.warned: list[str] = []
        self.converted: list[str] = []
        self.closed_loop: dict[str, list[str]] = {}
        self.not_placed: dict[str, list[str]] = {}
        self.autopilot: dict[str, Any] = {}
        self.placed: set[str] = set()
        self.plain = bool(taken)

    def convert(self, path: Path) -> list[tuple[str, str]]:
        """Writes a log as CSV into the folder, groups with clocks of their own each as one; path and name of each."""
        kind = KINDS.get(format_of(path) or "")
        try:
            if kind is None:
                self.plain = True
                tables, left_out, coarse = _tables(path, self.options)
                self.guessed += [f"{path.name}: {reason}" for reason in (*left_out, *coarse)]
                self.warned += [f"{path.name}: {reason}" for reason in coarse]
                made = [self._write(_named(path, group), data) for group, data in tables.items()]
            else:
                made = self._signals(path, kind)
        except DataError as error:
            self.guessed.append(f"{path.name} could not be read: {error}")
            self.unread.append(f"not read: {path.name}: {error}")
            return []
        return [(str(self.folder / name), name) for name in made]

    def left(self) -> dict[str, Any]:
        """The reading options that the CSV logs are read with.

        Raises:
            UsageError: a column that no log has.
        """
        columns = {name: entry for name, entry in self.options.get("columns", {}).items() if name not in self.placed}
        if columns and not self.plain:
            said = ", ".join(f"columns.{name} = {entry!r}" for name, entry in columns.items())
            raise UsageError(f"{said}: no log has such a field; the campaign lists the existing ones")
        rest = {
            key: value for key, value in self.options.items() if key != "columns" and (self.plain or key not in OWN)
        }
        return rest | ({"columns": columns} if columns else {})

    def learned(self) -> dict[str, Any]:
        """All of it, as the writer of the text takes it."""
        return {
            "guessed": self.guessed,
            "converted": self.converted,
            "closed_loop": self.closed_loop,
            "not_placed": self.not_placed,
            **self.autopilot,
        }

    def _signals(self, path: Path, kind: str) -> list[str]:
        source, columns = open_source(path, ColumnMap(msg=self.msg))
        said = told(path, source, kind)
        found = guess(source, kind, said.parameters)
        self._overrule(source, found)
        found.reasons += [*source.notes, *said.notes]
        read = _run(source, found, columns)
        if read is None:
            self.guessed.append(f"nothing of {path.name} could be recognised; it has {source.listed(400)}")
            self.unread.append(f"not read: {path.name}: nothing in it could be recognised")
            return []
        run, origin = read
        stretches = _stretches(said, run, origin or 0)
        run = _with_modes(run, stretches)
        made = self._write(path, _native.csv_of(run._native(), origin))
        self.converted.append(made)
        self.guessed += [f"{path.name}: {reason}" for reason in found.reasons]
        self.not_placed[made] = _not_placed(source, found)
        self.closed_loop[made] = [
            f'{start:.1f} to {end:.1f} s: mode {mode}, a controller steers; where = "closed_loop < 0.5" leaves it out'
            for start, end, mode in stretches
        ]
        self._vehicle(path, found, run)
        return [made]

    def _overrule(self, source: Source, found: Guess) -> None:
        """Takes columns and options that somebody has said, those that this log has."""
        for name, entry in self.options.get("columns", {}).items():
            address = entry if isinstance(entry, str) else entry.get("name", "")
            if any(stream and address.startswith(f"{stream}:") for stream in source.contents):
                found.columns[name] = {"name": address} if isinstance(entry, str) else dict(entry)
                found.reasons = [reason for reason in found.reasons if not reason.startswith(f"{name} is ")]
                self.placed.add(name)
        found.options |= {key: self.options[key] for key in OWN if key in self.options}

    def _vehicle(self, path: Path, found: Guess, run: Run) -> None:
        """Keeps what the parameters say of the vehicle; all logs are of one."""
        if found.frame is None:
            return
        first = self.autopilot.setdefault("ardusub_frame", found.frame)
        if first != found.frame:
            text = f"FRAME_CONFIG = {found.frame}, and {first} in the first log: these are two vehicles"
            self.guessed.append(f"{path.name}: {text}; make a campaign of each")
            return
        self.autopilot.setdefault("directions", found.directions)
        self.autopilot.setdefault("neutral", [_rest(run, k, trim) for k, trim in enumerate(found.trims, 1)])
        if found.span is not None:
            self.autopilot.setdefault("span", found.span)

    def _write(self, path: Path, data: bytes) -> str:
        """Writes the CSV that a log becomes under a name that no other log has; a file that is there stays."""
        names = [f"{path.stem or path.name}.csv", f"{path.name}.csv"]
        for name in (*names, *(f"{path.name}.{k}.csv" for k in range(2, 1000))):
            target = self.folder / name
            if name in self.taken or (target.exists() and (target.is_dir() or target.read_bytes() != data)):
                continue
            self.taken.add(name)
            target.write_bytes(data)
            return name
        raise UsageError(f"{self.folder} is full of files called {names[1]}: choose another folder")


def _run(source: Source, found: Guess, columns: ColumnMap) -> tuple[Run, int | None] | None:
    """The run of the columns that were guessed, and its t = 0; those that cannot be read are left out and told."""
    wanted = dict(found.columns)
    while wanted:
        try:
            return run_and_origin(
                source, ColumnMap.of({"columns": wanted, "clock": columns.clock, "msg": columns.msg, **found.options})
            )
        except (DataError, UsageError) as error:
            # velocities along earth axes need each other; of the rest the one that is named is at fault
            named = [n for n in wanted if _names(str(error).removeprefix(f"{source.name}: "), n)]
            earth = [n for n in ("u", "v", "w") if wanted.get(n, {}).get("frame") in ("ned", "enu")]
            bad = named or earth or list(wanted)[-1:]
            found.reasons.append(f"{', '.join(bad)} left out: {str(error).splitlines()[0]}")
            for n in bad:
                del wanted[n]
    return None


def _names(message: str, channel: str) -> bool:
    """Whether the message of a refusal begins with a channel: V1 is not V12."""
    return re.match(rf"(columns\.)?{re.escape(channel)}(?!\w)", message) is not None


def _not_placed(source: Source, found: Guess) -> list[str]:
    """The fields that became no channel, a line a stream."""
    used = {entry["name"] for entry in found.columns.values()}
    lines = []
    for stream, fields in source.contents.items():
        # of a quaternion that was taken as angles nothing is left
        left = [f for f in fields if not any(u == f"{stream}:{f}" or _is_part(u, f"{stream}:{f}") for u in used)]
        if left:
            lines.append(f"{stream}: {', '.join(left)}")
    return lines


def _is_part(angle: str, part: str) -> bool:
    """Whether a field is a part of the quaternion whose angle was taken."""
    of, _, which = angle.rpartition(".")
    return which in ("roll", "pitch", "yaw") and (part in [f"{of}.{c}" for c in "xyzw"] or part.startswith(f"{of}["))


def _stretches(said: Told, run: Run, origin: int) -> list[tuple[float, float, str]]:
    """Stretches under a controller on the clock of the run, s."""
    end = max(stamps[-1] for stamps, _ in run.signals.values())
    found = closed_loop(said.modes, origin + round(end * 1e9))
    return [((start - origin) / 1e9, (stop - origin) / 1e9, mode) for start, stop, mode in found]


def _with_modes(run: Run, stretches: list[tuple[float, float, str]]) -> Run:
    """The run with ``closed_loop``: 1 where a mode steers, at the stamps of the first command."""
    command = next((n for n in run.signals if n.startswith("V") and n[1:].isdigit()), None)
    if not stretches or command is None:
        return run
    stamps = run.signals[command][0]
    steers = np.zeros(len(stamps))
    for start, end, _ in stretches:
        steers[(stamps >= start) & (stamps < end)] = 1.0
    signals = dict(run.signals) | {"closed_loop": (stamps, steers)}
    made = Run(signals, name=run.name)
    made._set(run.name, run.kind, run.role, run.gaps, signals, run.findings, dict(run.units))
    return made


def _rest(run: Run, thruster: int, trim: float | None) -> float | None:
    """SERVOn_TRIM of an output where it is the pulse at which the output mostly stands; ArduSub itself has 1500."""
    if trim is None or f"V{thruster}" not in run.signals:
        return None
    values, counts = np.unique(np.round(run.signals[f"V{thruster}"][1]), return_counts=True)
    return trim if abs(values[np.argmax(counts)] - trim) < 1.5 else None


def _tables(path: Path, options: Mapping[str, Any]) -> tuple[dict[str, bytes], list[str], list[str]]:
    """Columns of a plain table as CSV under their own names, what was left out, and which time stamps are coarse.

    A group with its own clock is a table: ``dvl/t, dvl/u, imu/t, imu/r`` become two, of ``t, u`` and ``t, r``; columns
    without a group of their own are those of the usual length.
    """
    timed: Mapping[str, Any] = {"columns": {"_": {"name": "_", "time": "_"}}}
    source, _ = open_source(path, ColumnMap.of(timed))
    names = source.contents.get("", ())
    try:
        stream = source.read({"": frozenset(names)})[""] if names else None
    except UsageError as error:  # its time is in a unit that is not known
        raise DataError(str(error)) from None
    if stream is None or not stream.fields:
        raise DataError(f"{path}: it holds no column of numbers")
    fields = {name: stream.fields[name] for name in names}
    clocks = {name.rpartition("/")[0] for name in fields if _is_clock(name)} - {""}
    groups: dict[str, dict[str, NDArray[Any]]] = {}
    for name, values in fields.items():
        group, _, own = name.rpartition("/")
        if group in clocks:
            groups.setdefault(group, {})[own] = values
        else:
            groups.setdefault("", {})[name] = values
    if len(stream.stamps) > 0:
        # the column `t` is the time of a plain table, and no field of it
        seconds = np.asarray(stream.stamps, dtype=np.float64) / stream.per_second
        groups[""] = {"t": seconds, **groups.get("", {})}
    left_out: list[str] = []
    coarse: list[str] = []
    tables = {}
    for group, columns in groups.items():
        usual, _ = Counter(len(values) for values in columns.values()).most_common(1)[0]
        others = [f"{name} ({len(values)})" for name, values in columns.items() if len(values) != usual]
        if others:
            left_out.append(f"left out, not as long as the {usual} rows of the others: {', '.join(others)}")
        whole = {name: values for name, values in columns.items() if len(values) == usual}
        coarse += _coarse(whole, options)
        tables[group] = _csv(whole)
    return (tables if len(tables) > 1 else {"": next(iter(tables.values()))}), left_out, coarse


def _coarse(columns: Mapping[str, NDArray[Any]], options: Mapping[str, Any]) -> list[str]:
    """What there is to say of a time that stands still over several rows, as whole seconds do at 10 rows a second."""
    said = options.get("columns", {}).get("t")
    said = said.get("name") if isinstance(said, Mapping) else said
    clocks = [
        name for name in columns if (name == said if said else _is_clock(name) or columns[name].dtype.kind in "mM")
    ]
    found = []
    for name in clocks:
        steps = np.flatnonzero(columns[name][1:] != columns[name][:-1])
        rows, stamps = len(columns[name]), len(steps) + 1
        if stamps == rows:
            return []  # a clock that tells every row from the next
        # the first and the last stamp may have begun before the log, or go on after it
        each = np.median(np.diff(steps)) if stamps > 3 else 1
        if each >= 2:
            found.append(
                f"{name!r} has {stamps} time stamps for {rows} rows, about {each:.0f} rows each: its resolution is "
                f'coarser than the rows, and duplicates = "first" keeps {stamps} of them. Log finer stamps, or use '
                "another column as columns.t"
            )
    return found if "duplicates" not in options else []


def _is_clock(name: str) -> bool:
    """Whether a dataset is the time of its group, by its name."""
    return name.rpartition("/")[2].partition("[")[0].strip().lower() in ("t", "time", "timestamp", "stamp")


def _named(path: Path, group: str) -> Path:
    """The log's name with that of the group: ``dive.h5``, ``dvl`` → ``dive_dvl.h5``."""
    return path.with_name(f"{path.stem}_{group.replace('/', '_')}{path.suffix}") if group else path


def _csv(columns: Mapping[str, NDArray[Any]]) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "table.csv"
        write_columns(target, dict(columns))
        return target.read_bytes()
