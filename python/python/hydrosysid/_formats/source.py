"""What a log holds, whatever its format: streams of samples, each with its own time stamps."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from operator import attrgetter, itemgetter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._arrays import nanoseconds
from .._errors import DataError, UsageError

Array = NDArray[np.float64]
PER_SECOND = {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9, "min": 1 / 60, "h": 1 / 3600}
SPELLINGS = {"µs": "us", "μs": "us"}


@dataclass(frozen=True, eq=False)
class Stream:
    """Samples that came together.

    Attributes:
        stamps: time stamps, whole ticks or seconds, (n).
        per_second: ticks a second.
        fields: values by name as they are stored, (n) each.
        clock: what the stamps are, for people.
    """

    stamps: NDArray[Any]
    per_second: float
    fields: Mapping[str, NDArray[Any]]
    clock: str = "time stamps of the file"


@dataclass(frozen=True, eq=False)
class Source:
    """A log that is open.

    Attributes:
        name: the file, for messages.
        contents: names of the fields of each stream; the one stream of a plain table is called ``""``.
        read: reads the fields that are asked for, by stream.
        left_out: streams that cannot be decoded, each with the reason.
        messages: the messages of these streams as they are, each with its stream and time, ns since 1970; `None` where
            the format has none that hold more than numbers.
    """

    name: str
    contents: Mapping[str, tuple[str, ...]]
    read: Callable[[Mapping[str, frozenset[str]]], Mapping[str, Stream]]
    left_out: Mapping[str, str] = field(default_factory=dict)
    messages: Callable[[frozenset[str]], Iterable[tuple[str, int, Any]]] | None = None

    @property
    def notes(self) -> tuple[str, ...]:
        """What was left out on opening, and why."""
        return tuple(f"{stream} left out: {why}" for stream, why in self.left_out.items())

    def address(self, stream: str, field: str) -> str:
        """How a map writes a field: ``STREAM:FIELD``, or ``FIELD`` in a plain table."""
        return f"{stream}:{field}" if stream else field

    def listed(self, most: int = 40) -> str:
        """The fields that are there, for a message."""
        every = [self.address(stream, field) for stream, fields in self.contents.items() for field in fields]
        more = f" and {len(every) - most} more" if len(every) > most else ""
        return ", ".join(every[:most]) + more if every else "nothing that is a number"


def name_and_unit(column: str) -> tuple[str, str | None]:
    """Name and unit of a column; a number right behind a name is an index, and part of it.

    >>> name_and_unit("speed [kn]"), name_and_unit("V1 [1]"), name_and_unit("data[0]")
    (('speed', 'kn'), ('V1', '1'), ('data[0]', None))
    """
    parts = re.fullmatch(r"(.*\S)(\s*)\[(.*)\]", column.strip())
    if parts is None or (not parts[2] and parts[3].isdigit()):
        return column.strip(), None
    return parts[1], parts[3].strip() or None


def ticks(times: NDArray[Any], unit: str | None, what: str = "time stamps") -> tuple[NDArray[Any], float]:
    """Time stamps as whole ticks or seconds, and ticks a second; a 64-bit float would round a wall clock in ns.

    `what` names them in a refusal.

    >>> ticks(np.array(["2024-07-01T10:40:00.1"], dtype="datetime64[ms]"), None)
    (array([1719830400100000000]), 1000000000.0)
    """
    if times.dtype.kind in "mM":
        if np.isnat(times).any():
            raise DataError(f"sample {int(np.argmax(np.isnat(times))) + 1} has no time stamp (NaT): leave it out")
        return nanoseconds(times, what), 1e9
    per_second = PER_SECOND.get(SPELLINGS.get(unit or "s", unit or "s"))
    if per_second is None:
        known = ", ".join(PER_SECOND)
        raise UsageError(
            f"{what}: the unit {unit!r} is not one of {known}; give it as unit of columns.t, or as time_unit"
        )
    return times.astype(np.int64 if times.dtype.kind in "iu" else np.float64), per_second


def number_fields(value: Any, path: str = "") -> Iterable[tuple[str, Callable[[Any], float]]]:
    """Names of the numbers in a message of attributes, lists and numbers, each with how to get it from such a message.

    >>> from types import SimpleNamespace as Message
    >>> [name for name, _ in number_fields(Message(linear=Message(x=1.0), data=[1, 2], frame="base"))]
    ['linear.x', 'data[0]', 'data[1]']
    """
    if isinstance(value, bool | int | float | np.number | np.bool_):
        yield path, float
        return
    for step, part, name in _parts(value, path):
        for deeper, get in number_fields(part, name):
            yield deeper, _then(step, get)


MOST = 64
"""Entries of a list that have a name each."""


def _parts(value: Any, path: str) -> Iterable[tuple[Callable[[Any], Any], Any, str]]:
    """The parts of a value: how to get one from such a value, the part itself, and its name."""
    if isinstance(value, list | tuple | np.ndarray):
        return [(itemgetter(k), value[k], f"{path}[{k}]") for k in range(min(len(value), MOST))]
    before = f"{path}." if path else ""
    if isinstance(value, Mapping):
        return [(itemgetter(key), part, f"{before}{key}") for key, part in value.items()]
    names = getattr(value, "__slots__", ()) or (vars(value) if hasattr(value, "__dict__") else ())
    there = [name for name in names if not name.startswith("_") and hasattr(value, name)]
    return [(attrgetter(name), getattr(value, name), f"{before}{name}") for name in there]


def _then(step: Callable[[Any], Any], get: Callable[[Any], float]) -> Callable[[Any], float]:
    return lambda message: get(step(message))
