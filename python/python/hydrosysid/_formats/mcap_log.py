"""MCAP logs of any writer, by the `mcap <https://mcap.dev>`_ library: messages of ROS 2 (CDR), ROS 1, and JSON.

A stream is a topic.
"""

from __future__ import annotations

import functools
import json
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

from .._errors import DataError, UsageError
from .extras import MissingExtra, needed
from .messages import Message, source_of
from .ros_types import RELEASES, RosTypes, full_name
from .source import Source


def open_mcap(path: Path, clock: str, taught: Sequence[str] = ()) -> Source:
    """An MCAP log as a source.

    Args:
        path: the log.
        clock: ``header`` or ``log``, as for `source_of`.
        taught: ``.msg`` files of types whose definitions the log does not hold.

    Raises:
        DataError: it is no MCAP log, or its messages are in another encoding.
    """
    reader = needed("mcap.reader", "ros", "MCAP logs")
    types = functools.cache(lambda: RosTypes(taught))
    left_out: dict[str, str] = {}
    decoders: dict[tuple[str, int], Callable[[bytes], Any]] = {}

    def every(topics: frozenset[str] | None) -> Iterator[tuple[str, int, Callable[[bytes], Any], bytes]]:
        with path.open("rb") as file:
            for schema, channel, message in reader.make_reader(file).iter_messages(topics=topics):
                key = (channel.message_encoding, schema.id if schema else 0)
                if channel.topic in left_out:
                    continue
                try:
                    if key not in decoders:
                        decoders[key] = _decoder(path, channel.message_encoding, schema, types)
                except (MissingExtra, UsageError):
                    raise
                except Exception as error:  # one topic of an unknown encoding keeps no other from being read
                    left_out[channel.topic] = str(error).removeprefix(f"{path}: ")
                else:
                    yield channel.topic, message.log_time, decoders[key], message.data

    def messages(topics: frozenset[str]) -> Iterator[Message]:
        for topic, at, decode, raw in every(topics):
            try:
                yield topic, at, decode(raw)
            except (DataError, ValueError) as error:
                raise DataError(f"{path}: {topic}, message at {at} ns: {error}") from None

    def first() -> Iterator[Message]:
        seen = set()
        for topic, at, decode, raw in every(None):
            if topic not in seen:
                seen.add(topic)
                try:
                    message = decode(raw)
                except Exception as error:
                    left_out[topic] = str(error) if isinstance(error, DataError) else f"{type(error).__name__} {error}"
                else:
                    yield topic, at, message

    if not path.exists():
        raise UsageError(f"{path}: there is no such log")
    try:
        source = source_of(str(path), list(first()), messages, clock, left_out)
    except (UsageError, DataError):
        raise
    except Exception as error:  # the library raises errors of many kinds for files that are none of its own
        raise DataError(f"{path}: this MCAP log cannot be read: {error}") from None
    if left_out and not source.contents:
        raise DataError(f"{path}: " + "; ".join(f"{topic}: {reason}" for topic, reason in left_out.items()))
    return source


def _decoder(path: Path, encoding: str, schema: Any, types: Callable[[], RosTypes]) -> Callable[[bytes], Any]:
    """How a message of this encoding becomes something with fields."""
    if encoding == "json":
        return json.loads
    written = schema.encoding if schema is not None else ""
    if encoding in RELEASES and schema is not None and written in ("ros2msg", "ros2idl", "ros1msg", ""):
        return types().decoder(full_name(schema.name), schema.data.decode(), written == "ros2idl", encoding)
    what = f"{encoding} with a schema in {written}" if schema else f"{encoding} without a schema"
    raise DataError(f"{path}: messages in {what} cannot be read; CDR and ROS 1 of ROS and JSON can")
