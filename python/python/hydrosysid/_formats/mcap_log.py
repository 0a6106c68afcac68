"""MCAP logs of any writer, by the `mcap <https://mcap.dev>`_ library: messages of ROS 2 (CDR), ROS 1, and JSON.

A stream is a topic.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

from .._errors import DataError, UsageError
from .extras import needed
from .messages import Message, source_of
from .source import Source


def open_mcap(path: Path, clock: str) -> Source:
    """An MCAP log as a source.

    Raises:
        DataError: it is no MCAP log, or its messages are in another encoding.
    """
    reader = needed("mcap.reader", "ros", "MCAP logs")
    decoders: dict[tuple[str, int], Callable[[bytes], Any]] = {}

    unknown: dict[str, str] = {}

    def every(topics: frozenset[str] | None) -> Iterator[tuple[str, int, Callable[[bytes], Any], bytes]]:
        with path.open("rb") as file:
            for schema, channel, message in reader.make_reader(file).iter_messages(topics=topics):
                key = (channel.message_encoding, schema.id if schema else 0)
                if channel.topic in unknown:
                    continue
                # a topic that cannot be decoded is left out; the others are read
                if key not in decoders:
                    try:
                        decoders[key] = _decoder(path, channel.message_encoding, schema)
                    except Exception as error:
                        unknown[channel.topic] = str(error)
                        continue
                yield channel.topic, message.log_time, decoders[key], message.data

    def messages(topics: frozenset[str]) -> Iterator[Message]:
        for topic, at, decode, raw in every(topics):
            yield topic, at, decode(raw)

    def first() -> Iterator[Message]:
        seen = set()
        for topic, at, decode, raw in every(None):
            if topic not in seen:
                seen.add(topic)
                yield topic, at, decode(raw)

    if not path.exists():
        raise UsageError(f"{path}: there is no such log")
    try:
        begun = list(first())
        if unknown and not begun:
            raise DataError(next(iter(unknown.values())))
        source = source_of(str(path), begun, messages, clock)
        return replace(source, notes=tuple(f"{topic} left out: {why}" for topic, why in unknown.items()))
    except (UsageError, DataError):
        raise
    except Exception as error:  # the library raises errors of many kinds for files that are none of its own
        raise DataError(f"{path}: this is no MCAP log that can be read: {error}") from None


def _decoder(path: Path, encoding: str, schema: Any) -> Callable[[bytes], Any]:
    """How a message of this encoding becomes something with fields."""
    if encoding == "json":
        return json.loads
    if encoding in ("cdr", "ros1") and schema is not None and schema.encoding in ("ros2msg", "ros2idl", "ros1msg"):
        typesys = needed("rosbags.typesys", "ros", "MCAP logs of ROS")
        store = typesys.get_typestore(typesys.Stores.EMPTY)
        text, name = schema.data.decode(), _full(schema.name)
        read = typesys.get_types_from_idl if schema.encoding == "ros2idl" else typesys.get_types_from_msg
        store.register(read(text) if schema.encoding == "ros2idl" else read(text, name))
        decode = store.deserialize_cdr if encoding == "cdr" else store.deserialize_ros1
        return lambda raw: decode(raw, name)
    what = f"{encoding} with a schema in {schema.encoding}" if schema else f"{encoding} without a schema"
    raise DataError(f"{path}: messages in {what} cannot be read; CDR and ROS 1 of ROS and JSON can")


def _full(name: str) -> str:
    """``package/msg/Type`` from that, or from the ``package/Type`` of ROS 1."""
    package, _, kind = name.rpartition("/")
    return f"{package if package.endswith('/msg') else package + '/msg'}/{kind}"
