"""The column map: which field of a log is which channel, in which unit, with which sign, in which axes."""

from __future__ import annotations

import difflib
import json
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields, replace
from os import PathLike, fspath
from pathlib import Path
from typing import Any

from .._errors import UsageError
from .source import PER_SECOND, name_and_unit

BODY, EARTH = ("frd", "flu"), ("ned", "enu")
WORDS = {
    "body_frame": BODY,
    "earth_frame": EARTH,
    "missing": ("error", "no_sample"),
    "duplicates": ("error", "first"),
    "clock": ("header", "log"),
    "time_unit": tuple(PER_SECOND),
}
EARTH_VELOCITIES = ("u", "v", "w")
"""Channels that may be logged along earth axes; they are rotated by the attitude."""
ATTITUDE = ("phi", "theta", "psi")


@dataclass(frozen=True)
class ColumnSource:
    """Where a channel stands, and how it is written.

    Attributes:
        name: ``STREAM:FIELD``, or ``FIELD`` in a plain table.
        unit: unit in the log; SI when absent.
        scale: factor after the conversion of units.
        sign: 1 or −1.
        frame: ``frd`` or ``flu``, ``ned`` or ``enu``, for this channel alone. ``ned`` or ``enu`` for ``u``, ``v``,
            ``w`` says that they are logged along earth axes: they are turned to body axes.
        valid: field of the same stream; where it is 0 there is no sample.
        time: field with the time stamps, where a table has several.
    """

    name: str
    unit: str | None = None
    scale: float = 1.0
    sign: int = 1
    frame: str | None = None
    valid: str | None = None
    time: str | None = None


@dataclass(frozen=True)
class ColumnMap:
    """How a log in another format is read: ``columns`` and the options beside them.

    Attributes:
        columns: canonical name = where it stands. All fields of a plain table under their own names when empty.
        body_frame: axes of velocities, rates, forces: ``frd`` or ``flu``.
        earth_frame: axes of positions and angles: ``ned`` or ``enu``.
        missing: what NaN means: ``error``, or ``no_sample``.
        duplicates: what to do with a repeated time stamp: ``error``, or keep the ``first``.
        sort: sort each channel by time.
        clock: time stamps of ROS messages: those in their ``header``, where they have one, or those of the ``log``.
        time_unit: unit of time stamps that are numbers.
        msg: definitions of ROS messages that a log does not hold: ``.msg`` files, or folders of such.
    """

    columns: Mapping[str, ColumnSource] = field(default_factory=dict)
    body_frame: str = "frd"
    earth_frame: str = "ned"
    missing: str = "error"
    duplicates: str = "error"
    sort: bool = False
    clock: str = "header"
    time_unit: str | None = None
    msg: tuple[str, ...] = ()

    @classmethod
    def of(cls, options: Mapping[str, Any], where: str = "the column map") -> ColumnMap:
        """A map from plain data, as a TOML file or keywords hold it.

        Raises:
            UsageError: an unknown key or word; the message names it, and the nearest that there is.
        """
        known = [f.name for f in fields(cls)]
        _known(options, known, where)
        for key, words in WORDS.items():
            if options.get(key) is not None and options[key] not in words:
                raise UsageError(f"{where}: {key} = {options[key]!r} is none of {', '.join(words)}")
        given = options.get("columns") or {}
        if not isinstance(given, Mapping):
            raise UsageError(f"{where}: columns must be a table: canonical name = its source")
        columns = {name: _source(name, entry, where) for name, entry in given.items()}
        rest = {key: value for key, value in options.items() if key not in ("columns", "msg") and value is not None}
        return cls(columns=columns, msg=_files(options.get("msg"), where), **rest)

    @classmethod
    def from_file(cls, path: str | PathLike[str], options: Mapping[str, Any] | None = None) -> ColumnMap:
        """A map from a TOML file; `options` win over what stands there, and ``msg`` is found from its folder."""
        table = read_toml(path)
        if "msg" in table:
            table["msg"] = [str(Path(path).parent / file) for file in _files(table["msg"], str(path))]
        return cls.of(table | dict(options or {}), str(path))

    def earth_velocity(self, where: str) -> str | None:
        """The earth axes that ``u``, ``v``, ``w`` are logged along, where they are; `where` begins a refusal.

        Raises:
            UsageError: not the three of them in one frame, in the words of the reader of CSV.
        """
        frames = {name: entry.frame for name in EARTH_VELOCITIES if (entry := self.columns.get(name)) is not None}
        earth = next((frame for frame in frames.values() if frame in EARTH), None)
        other = next((name for name in EARTH_VELOCITIES if frames.get(name) != earth), None)
        if earth is not None and other is not None:
            text = "velocities along earth axes are rotated together: give the same frame for u, v and w"
            raise UsageError(f"{where}: columns.{other}: {text}")
        return earth

    def with_attitude(self, fields: Iterable[str], where: str) -> ColumnMap:
        """The map with the attitude that turns velocities along earth axes, where `fields` of a plain table are it.

        As in CSV, ``phi``, ``theta``, ``psi`` under their own names need not be said.
        """
        if self.earth_velocity(where) is None:
            return self
        taken = {entry.name for entry in self.columns.values()}
        own = {name_and_unit(field)[0]: field for field in fields if field not in taken}
        time = self.columns["u"].time
        added = {a: ColumnSource(own[a], time=time) for a in ATTITUDE if a in own and a not in self.columns}
        return replace(self, columns={**self.columns, **added})

    def si_options(self, name: str, unit: str | None = None) -> str:
        """The options of the library's reader for one channel, as JSON; `unit` where the map says none."""
        source = self.columns.get(name, ColumnSource(name))
        said = {"name": source.name, "scale": source.scale, "sign": source.sign}
        given = {"unit": unit if source.unit is None else source.unit, "frame": source.frame}
        said |= {key: value for key, value in given.items() if value is not None}
        options = {"columns": {name: said}, "body_frame": self.body_frame, "earth_frame": self.earth_frame}
        return json.dumps(options)


def read_toml(path: str | PathLike[str]) -> dict[str, Any]:
    """The tables of a TOML file.

    Raises:
        UsageError: it cannot be read, or is no TOML; the message names the line.
    """
    try:
        return tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise UsageError(f"{path}: {error}") from None


def _source(name: str, entry: Any, where: str) -> ColumnSource:
    if isinstance(entry, ColumnSource):
        return entry
    if isinstance(entry, str):
        return ColumnSource(entry)
    place = f"{where}: columns.{name}"
    if not isinstance(entry, Mapping) or not isinstance(entry.get("name"), str):
        raise UsageError(f'{place} = {entry!r} must be the name of a field, or a table {{ name = "…", unit = "…", … }}')
    _known(entry, [f.name for f in fields(ColumnSource)], place)
    frame = entry.get("frame")
    if frame is not None and frame not in BODY + EARTH:
        raise UsageError(f"{place}: frame = {frame!r} is none of {', '.join(BODY + EARTH)}")
    return ColumnSource(**entry)


def _files(given: Any, where: str) -> tuple[str, ...]:
    files = [given] if isinstance(given, str | PathLike) else list(given or ())
    if not all(isinstance(file, str | PathLike) for file in files):
        raise UsageError(f"{where}: msg = {given!r} must be a .msg file, a folder of .msg files, or a list of these")
    return tuple(fspath(file) for file in files)


def _known(given: Iterable[str], known: list[str], where: str) -> None:
    for key in given:
        if key not in known:
            near = difflib.get_close_matches(key, known, 1)
            meant = f", did you mean `{near[0]}`?" if near else f"; there are {', '.join(known)}"
            raise UsageError(f"{where}: unknown key `{key}`{meant}")
