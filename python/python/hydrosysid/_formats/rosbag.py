"""ROS 1 and ROS 2 bags, by `rosbags <https://gitlab.com/ternaris/rosbags>`_; no ROS is needed.

A stream is a topic. A bag is a file (``.bag``, ``.db3``, ``.mcap``) or the folder of a ROS 2 recording.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

from .._errors import DataError, UsageError
from .extras import needed
from .messages import Message, source_of
from .source import Source


def open_rosbag(path: Path, clock: str) -> Source:
    """A bag as a source.

    Raises:
        DataError: it is no bag.
    """
    highlevel = needed("rosbags.highlevel", "ros", "ROS bags")
    if not path.exists():
        raise UsageError(f"{path}: there is no such bag")

    def opened() -> Any:
        # bags of earlier ROS 2 do not hold the definitions of their messages: the usual ones are known
        typesys = needed("rosbags.typesys", "ros", "ROS bags")
        return highlevel.AnyReader([path], default_typestore=typesys.get_typestore(typesys.Stores.LATEST))

    def messages(topics: frozenset[str]) -> Iterator[Message]:
        with opened() as bag:
            connections = [c for c in bag.connections if c.topic in topics]
            for connection, at, raw in bag.messages(connections=connections):
                yield connection.topic, at, bag.deserialize(raw, connection.msgtype)

    unknown: list[str] = []

    def first() -> Iterator[Message]:
        with opened() as bag:
            for connection in bag.connections:
                for _, at, raw in bag.messages(connections=[connection]):
                    # a topic of a type that nobody has defined is left out; the others are read
                    try:
                        decoded = bag.deserialize(raw, connection.msgtype)
                    except Exception as error:
                        kind = f"{connection.msgtype}: {type(error).__name__} {error}"
                        unknown.append(f"{connection.topic} left out, its type cannot be read ({kind})")
                        break
                    yield connection.topic, at, decoded
                    break

    # the library raises errors of many kinds for files that are none of its own
    try:
        source = source_of(str(path), list(first()), messages, clock)
        return replace(source, notes=tuple(unknown))
    except Exception as error:
        raise DataError(f"{path}: this is no bag that can be read: {error}") from None
