"""MAVLink telemetry logs (``.tlog``), as ground stations write them, by `pymavlink`.

A stream is a message type, ``ATTITUDE``; of components other than the autopilot it is one of its own,
``HEARTBEAT[255.190]`` (system and component). Values stand as the messages define them: angles of ``ATTITUDE`` in rad,
outputs of ``SERVO_OUTPUT_RAW`` in µs. Time is that at which the ground station received a message.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from .._errors import DataError, UsageError
from .extras import needed
from .messages import Message, source_of
from .source import Source

AUTOPILOT = 1
"""Number of the component that is the autopilot."""


def open_telemetry(path: Path) -> Source:
    """A telemetry log as a source.

    Raises:
        DataError: it holds no messages.
    """
    library = needed("pymavlink.dialects.v20.ardupilotmega", "ardupilot", "telemetry logs")
    if not path.exists():
        raise UsageError(f"{path}: there is no such log")

    def every() -> Iterator[tuple[str, int, Any]]:
        decoder = library.MAVLink(None)
        for stamp, frame in _frames(path.read_bytes()):
            try:
                message = decoder.decode(bytearray(frame))
            except library.MAVError:
                continue  # a message of another dialect, or one that was cut short on its way
            yield _stream(message), stamp * 1000, message

    def messages(streams: frozenset[str]) -> Iterator[Message]:
        return ((stream, at, message.to_dict()) for stream, at, message in every() if stream in streams)

    first: dict[str, Message] = {}
    for stream, at, message in every():
        if stream not in first:
            first[stream] = (stream, at, message.to_dict())
    if not first:
        raise DataError(f"{path}: this is not a telemetry log: it has no MAVLink message")
    return source_of(str(path), first.values(), messages, "log")


def _frames(data: bytes) -> Iterator[tuple[int, bytes]]:
    """Stamp (µs) and bytes of each message: the stamp in eight bytes, then a frame of MAVLink 1 or 2."""
    at = 0
    while at + 12 <= len(data):
        magic, length, signed = data[at + 8], data[at + 9], data[at + 10] & 1
        if magic not in (0xFE, 0xFD):
            at += 1  # to the next message
            continue
        end = at + 8 + (length + 8 if magic == 0xFE else length + 12 + 13 * signed)
        if end <= len(data):
            yield int.from_bytes(data[at : at + 8], "big"), data[at + 8 : end]
        at = end


def _stream(message: Any) -> str:
    """Type of a message, with system and component where it is not the autopilot's."""
    system, component = message.get_srcSystem(), message.get_srcComponent()
    name = str(message.get_type())
    return name if component == AUTOPILOT else f"{name}[{system}.{component}]"
