"""ROS 1 and ROS 2 bags, by `rosbags <https://gitlab.com/ternaris/rosbags>`_; no ROS is needed.

A stream is a topic. A bag is a file (``.bag``, ``.db3``, ``.mcap``) or the folder of a ROS 2 recording. Each topic is
decoded apart from the others: one whose type is not known, or whose definition cannot be read, keeps none from being
read.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from .._errors import DataError, UsageError
from .extras import needed
from .first_bytes import first_bytes
from .messages import Message, source_of
from .ros_types import Decode, RosTypes, full_name
from .source import Source


def open_rosbag(path: Path, clock: str, taught: Sequence[str] = ()) -> Source:
    """A bag as a source.

    Args:
        path: the bag.
        clock: ``header`` or ``log``, as for `source_of`.
        taught: ``.msg`` files of types whose definitions the bag does not hold.

    Raises:
        DataError: it is no bag.
    """
    needed("rosbags.rosbag2", "ros", "ROS bags")
    if not path.exists():
        raise UsageError(f"{path}: there is no such bag")
    known = RosTypes(taught)

    def messages(topics: frozenset[str]) -> Iterator[Message]:
        with _opened(path) as (bag, encoding):
            wanted = [c for c in bag.connections if c.topic in topics]
            decoders = {c.id: _decoder(known, c, encoding) for c in wanted}
            for connection, at, raw in bag.messages(connections=wanted):
                try:
                    yield connection.topic, at, decoders[connection.id](raw)
                except DataError as error:
                    raise DataError(f"{path}: {connection.topic}, message at {at} ns: {error}") from None

    left_out: dict[str, str] = {}

    def first() -> Iterator[Message]:
        with _opened(path) as (bag, encoding):
            for connection in bag.connections:
                for _, at, raw in bag.messages(connections=[connection]):
                    try:
                        message = _decoder(known, connection, encoding)(raw)
                    except DataError as error:
                        left_out[connection.topic] = str(error)
                    else:
                        yield connection.topic, at, message
                    break

    # the library raises errors of many kinds for files that are none of its own
    try:
        source = source_of(str(path), list(first()), messages, clock, left_out)
    except Exception as error:
        raise DataError(f"{path}: this bag cannot be read: {error}") from None
    if left_out and not source.contents:
        told = "; ".join(f"{topic} ({reason})" for topic, reason in left_out.items())
        raise DataError(f"{path}: no topic of this bag can be decoded: {told}")
    return source


@contextmanager
def _opened(path: Path) -> Iterator[tuple[Any, str]]:
    """The library's reader of a bag, known by its first bytes whatever its name, and the encoding of its messages."""
    begin = first_bytes(path, 16)
    if begin.startswith(b"#ROSBAG V"):
        with needed("rosbags.rosbag1", "ros", "ROS bags").Reader(path) as bag:
            yield bag, "ros1"
        return
    rosbag2 = needed("rosbags.rosbag2", "ros", "ROS bags").Reader
    if path.is_dir() or path.suffix in rosbag2.STORAGE_PLUGINS:
        with rosbag2(path) as bag:
            yield bag, "cdr"
        return
    bag = rosbag2.STORAGE_PLUGINS[".mcap" if begin.startswith(b"\x89MCAP0") else ".db3"](path)
    bag.open()
    try:
        yield bag, "cdr"
    finally:
        bag.close()


def _decoder(types: RosTypes, connection: Any, encoding: str) -> Decode:
    held = connection.msgdef
    return types.decoder(full_name(connection.msgtype), held.data or "", held.format.name == "IDL", encoding)
