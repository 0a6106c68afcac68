"""Formats of messages: one after the other, decoded one by one, into streams."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

import numpy as np

from .._errors import DataError
from .source import Source, Stream, number_fields

Message = tuple[str, int, Any]
"""Stream, time at which it was recorded in ns, and what it says."""
Getters = dict[str, Callable[[Any], float]]
STAMPS = (("header.stamp.sec", "header.stamp.nanosec"), ("header.stamp.secs", "header.stamp.nsecs"))


def source_of(
    name: str,
    first: Iterable[Message],
    messages: Callable[[frozenset[str]], Iterator[Message]],
    clock: str,
    left_out: Mapping[str, str] | None = None,
) -> Source:
    """A source of messages.

    Args:
        name: the file.
        first: the first message of each stream, which says what fields it has.
        messages: the messages of these streams, in the order of the file.
        clock: ``header``: time stamps of the messages where they have a header; ``log``: those of the recording.
        left_out: streams that cannot be decoded, each with the reason.
    """
    getters: dict[str, Getters] = {stream: dict(number_fields(message)) for stream, _, message in first}

    def read(wanted: Mapping[str, frozenset[str]]) -> Mapping[str, Stream]:
        return {
            stream: _stream(name, stream, getters[stream], fields, gathered, clock)
            for (stream, fields), gathered in zip(wanted.items(), _gathered(wanted, messages), strict=True)
        }

    return Source(name, {stream: tuple(fields) for stream, fields in getters.items()}, read, left_out or {}, messages)


def _gathered(
    wanted: Mapping[str, frozenset[str]], messages: Callable[[frozenset[str]], Iterator[Message]]
) -> list[list[tuple[int, Any]]]:
    kept: dict[str, list[tuple[int, Any]]] = {stream: [] for stream in wanted}
    for stream, at, message in messages(frozenset(wanted)):
        kept[stream].append((at, message))
    return list(kept.values())


def _stream(
    name: str,
    stream: str,
    getters: Getters,
    fields: frozenset[str],
    gathered: list[tuple[int, Any]],
    clock: str,
) -> Stream:
    values = {field: np.array([_number(getters[field], m) for _, m in gathered]) for field in fields}
    header = next(((s, n) for s, n in STAMPS if s in getters and n in getters), None)
    if clock == "header" and header is not None:
        seconds, nanoseconds = (getters[part] for part in header)
        stamps = np.array([int(seconds(m)) * 10**9 + int(nanoseconds(m)) for _, m in gathered], dtype=np.int64)
        if not stamps.all():
            raise DataError(
                f"{name}: {stream} has messages whose header has no time; clock = 'log' uses that of the log"
            )
        return Stream(stamps, 1e9, values, "time stamps of the messages' headers")
    stamps = np.array([at for at, _ in gathered], dtype=np.int64)
    return Stream(stamps, 1e9, values, "time at which the log recorded them")


def _number(get: Callable[[Any], float], message: Any) -> float:
    """A field of one message; NaN where this one has it not, as in a list that is shorter."""
    try:
        return get(message)
    except (AttributeError, IndexError, KeyError, TypeError):
        return float("nan")
