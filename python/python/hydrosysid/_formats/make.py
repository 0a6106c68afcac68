"""From a source and a column map to a run: stamps to seconds, values to SI units and body axes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _native
from .._errors import DataError, Finding, UsageError, found
from .._run import Run, _commands
from .column_map import ATTITUDE, EARTH_VELOCITIES, ColumnMap, ColumnSource
from .source import Array, Source, Stream, name_and_unit, ticks

WALL_CLOCK = 1e8
"""Beyond three years a stamp is a wall clock, s; the same bound as for CSV."""
ANGLES = ("roll", "pitch", "yaw")


def run_of(source: Source, columns: ColumnMap, **run: Any) -> Run:
    """The run that `columns` makes of `source`; `run` are name, kind, role and gaps as for `Run`.

    Raises:
        UsageError: a field that is not there; the message lists those that are.
        DataError: time that does not increase, values that are missing.
    """
    return run_and_origin(source, columns, **run)[0]


def run_and_origin(source: Source, columns: ColumnMap, **run: Any) -> tuple[Run, int | None]:
    """The same, and the instant of its t = 0, ns since 1970; `None` where the log has no wall clock.

    Raises:
        UsageError: a field that is not there; the message lists those that are.
        DataError: time that does not increase, values that are missing.
    """
    findings: list[Finding] = []
    columns = columns if columns.columns else _own_names(source, columns)
    columns = columns.with_attitude(source.contents.get("", ()), source.name)
    chosen = {name: _address(source, name, entry) for name, entry in columns.columns.items() if name != "t"}
    if not chosen:
        raise UsageError(f"{source.name}: no channel is mapped; give columns = {{u = …}}; there are {source.listed()}")
    wanted: dict[str, set[str]] = {}
    for name, (stream, field) in chosen.items():
        entry = columns.columns[name]
        extra = [f for f in (entry.valid, entry.time) if f is not None]
        for one in (field, *extra):
            wanted.setdefault(stream, set()).update(_parts(source, stream, one, name))
    streams = source.read({stream: frozenset(names) for stream, names in wanted.items()})
    signals, units = {}, {}
    for name, (stream, field) in chosen.items():
        signals[name], units[name] = _samples(source, streams[stream], (stream, field), name, columns, findings)
    seconds, origin = _seconds(source, signals, findings)
    for clock in sorted({streams[stream].clock for stream, _ in chosen.values()}):
        names = sorted(name for name, (stream, _) in chosen.items() if streams[stream].clock == clock)
        findings.append(found("L211", f"{source.name}: {', '.join(names)}: {clock}"))
    for stream, reason in source.left_out.items():
        findings.append(found("L215", f"{source.name}: {stream} is left out, it cannot be read: {reason}"))
    turned = _to_body(source, columns, seconds, findings)
    made = Run(turned, **({"name": source.name} | run))
    made._set(made.name, made.kind, made.role, made.gaps, dict(made.signals), tuple(findings), _commands(units))
    return made, origin


def _own_names(source: Source, columns: ColumnMap) -> ColumnMap:
    """A plain table whose columns are called ``name`` or ``name [unit]`` needs no map."""
    if set(source.contents) != {""}:
        raise UsageError(f"{source.name}: name the fields of the channels with columns; there are {source.listed()}")
    named = {}
    for header in source.contents[""]:
        name, _ = name_and_unit(header)
        if name in named:
            raise UsageError(f"{source.name}: two columns are called {name!r}; name the right one with columns")
        named[name] = ColumnSource(header)
    return ColumnMap(**(vars(columns) | {"columns": named}))


def _address(source: Source, name: str, entry: ColumnSource) -> tuple[str, str]:
    """Stream and field of a channel."""
    for stream, fields in source.contents.items():
        if stream == "" and entry.name in fields:
            return "", entry.name
        if stream and entry.name.startswith(f"{stream}:"):
            return stream, entry.name[len(stream) + 1 :]
    for stream, reason in source.left_out.items():
        if entry.name == stream or entry.name.startswith(tuple(f"{stream}{mark}" for mark in ":.[/")):
            raise DataError(f"{source.name}: columns.{name}: {stream} cannot be read: {reason}")
    raise UsageError(f"{source.name}: columns.{name} = {entry.name!r} is not there; there are {source.listed()}")


def _parts(source: Source, stream: str, field: str, name: str) -> tuple[str, ...]:
    """The fields that give `field`: itself, or the quaternion of whose angles it is one."""
    there = source.contents[stream]
    if field in there:
        return (field,)
    of, _, angle = field.rpartition(".")
    # messages of ROS say x, y, z, w; arrays of PX4 begin with w
    for parts in ([f"{of}.{c}" for c in "xyzw"], [f"{of}[{k}]" for k in (1, 2, 3, 0)]):
        if angle in ANGLES and all(part in there for part in parts):
            return tuple(parts)
    fields = ", ".join(there)
    where = f"{stream} has no field {field!r}" if stream else f"there is no column {field!r}"
    raise UsageError(f"{source.name}: columns.{name}: {where}; it has {fields}")


def _samples(
    source: Source,
    stream: Stream,
    address: tuple[str, str],
    name: str,
    columns: ColumnMap,
    findings: list[Finding],
) -> tuple[tuple[str, NDArray[Any], float, Array], str]:
    """Name, stamps, ticks a second and SI values of a channel; and the unit that it has."""
    entry, field = columns.columns[name], address[1]
    parts = _parts(source, address[0], field, name)
    if any(stream.fields[part].dtype.kind in "mMc" for part in parts):
        raise UsageError(f"{source.name}: columns.{name} = {entry.name!r} holds dates or complex numbers, not values")
    if len(parts) == 1:
        values = stream.fields[field].astype(np.float64)
    else:
        angles = _native.euler(*(np.ascontiguousarray(stream.fields[part], dtype=np.float64) for part in parts))
        values = angles[ANGLES.index(field.rpartition(".")[2])]
    stamps, per_second = stream.stamps, stream.per_second
    if entry.time is not None:
        unit = columns.time_unit or name_and_unit(entry.time)[1]
        stamps, per_second = ticks(stream.fields[entry.time], unit, f"{source.name}: columns.{name}.time")
    if len(stamps) != len(values):
        raise DataError(f"{source.name}: {name} has {len(values)} values for {len(stamps)} time stamps")
    there = np.ones(len(values), dtype=bool)
    if entry.valid is not None:
        there &= stream.fields[entry.valid] != 0.0
    if columns.missing == "no_sample":
        there &= ~np.isnan(values)
    if columns.sort:
        order = np.argsort(stamps, kind="stable")
        stamps, values, there = stamps[order], values[order], there[order]
    if columns.duplicates == "first" and len(stamps):
        there[1:] &= stamps[1:] != stamps[:-1]
    if (left := int((~there).sum())) > 0:
        text = f"{source.name}: {name}: {left} of {len(there)} samples were left out (invalid, missing or repeated)"
        findings.append(found("L213", text))
    if not there.any():
        raise DataError(f"{source.name}: {name} has no sample")
    stamps, values = stamps[there], values[there]
    _finite(source, name, stamps, values)
    written = None if address[0] else name_and_unit(field)[1]
    name, unit, values = _si(source, name, np.ascontiguousarray(values), columns, written)
    return (name, stamps, per_second, values), unit


def _si(source: Source, name: str, values: Array, columns: ColumnMap, written: str | None) -> tuple[str, str, Array]:
    """Name, unit and values in SI; `written` is the unit in the column's name, used where the map says none."""
    said = columns.si_options(name)
    if written is None or columns.columns[name].unit is not None:
        return _native.to_si(name, values, said)
    try:
        return _native.to_si(name, values, columns.si_options(name, written))
    except UsageError as error:
        # what an auxiliary channel is written in need not be known
        if not _native.to_si(name, np.empty(0), said)[1]:
            return _native.to_si(name, values, said)
        why = str(error).removeprefix(f"columns.{name}: ")
        raise UsageError(f"{source.name}: columns.{name} = {columns.columns[name].name!r}: {why}") from None


def _finite(source: Source, name: str, stamps: NDArray[Any], values: Array) -> None:
    bad = ~np.isfinite(values)
    if bad.any():
        k = int(np.argmax(bad))
        hint = "; missing = 'no_sample' leaves such samples out" if np.isnan(values[k]) else ""
        others = _and_more(int(bad.sum()) - 1, "more")
        raise DataError(f"{source.name}: {name}, sample {k + 1} is {values[k]}{others}{hint}")
    lost = ~np.isfinite(stamps)
    if lost.any():
        raise DataError(f"{source.name}: {name}, sample {int(np.argmax(lost)) + 1} has no time stamp: leave it out")
    # a difference would wrap where stamps lie more than 292 years apart
    step = np.flatnonzero(stamps[1:] <= stamps[:-1])
    if len(step):
        k = int(step[0]) + 1
        again = stamps[k] == stamps[k - 1]
        how = "duplicates = 'first' keeps the first" if again else "sort = true sorts by time"
        text = f"{source.name}: {name}, sample {k + 1}: the time stamp {stamps[k]} does not follow {stamps[k - 1]}"
        others = _and_more(len(step) - 1, "more cases")
        raise DataError(f"{text}{others}; {how}")


def _and_more(count: int, what: str) -> str:
    """How many there are beside the one that is named."""
    return f", and {count} {what}" if count else ""


def _seconds(
    source: Source,
    signals: Mapping[str, tuple[str, NDArray[Any], float, Array]],
    findings: list[Finding],
) -> tuple[dict[str, tuple[Array, Array]], int | None]:
    """Stamps in seconds; of a wall clock the first one is subtracted before it becomes a float, and told in ns."""
    starts = {name: stamps[0] / per_second for name, (_, stamps, per_second, _) in signals.items()}
    wall = [name for name, start in starts.items() if start > WALL_CLOCK]
    if wall and len(wall) < len(starts):
        others = ", ".join(sorted(set(starts) - set(wall)))
        text = f"{source.name}: {', '.join(wall)} have wall-clock stamps, {others} do not: no common time"
        raise DataError(text)
    first = min(signals.values(), key=lambda s: s[1][0] / s[2])
    zero = first[1][0] if wall else 0
    origin = None
    if wall:
        whole = np.issubdtype(first[1].dtype, np.integer)
        origin = int(zero) * round(1e9 / first[2]) if whole else round(float(zero) / first[2] * 1e9)
        at = np.datetime64(origin, "ns")
        findings.append(found("L212", f"{source.name}: t = 0 is {at} UTC"))
    seconds = {}
    for name, stamps, per_second, values in signals.values():
        if name in seconds:
            raise UsageError(f"{source.name}: two fields are mapped to the channel {name}; leave one of them out")
        start = zero if per_second == first[2] else zero / first[2] * per_second
        seconds[name] = ((stamps - start) / per_second, values)
    return seconds, origin


def _to_body(
    source: Source,
    columns: ColumnMap,
    signals: dict[str, tuple[Array, Array]],
    findings: list[Finding],
) -> dict[str, tuple[Array, Array]]:
    """Velocities that are logged along earth axes, turned by the attitude."""
    frame = columns.earth_velocity(source.name)
    if frame is None:
        return signals
    needed = {n: signals[n] for n in (*EARTH_VELOCITIES, *ATTITUDE) if n in signals}
    given = {n: (np.ascontiguousarray(t), np.ascontiguousarray(x)) for n, (t, x) in needed.items()}
    try:
        turned, how = _native.to_body(given, frame)
    except (UsageError, DataError) as error:
        raise type(error)(f"{source.name}: {error}") from None
    findings.append(found("L214", f"{source.name}: {how}"))
    return signals | {n: turned[n] for n in EARTH_VELOCITIES}
