"""ArduPilot DataFlash logs (``.BIN``, and their text form ``.log``), by `pymavlink`.

A stream is a message type, ``XKF1``; of types with instances each is one, ``XKF1[0]``. Values stand as the format
defines them: angles of ``XKF1`` in degrees, outputs of ``RCOU`` in µs. Time is that since the autopilot began.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from .._errors import DataError, UsageError
from .extras import needed
from .first_bytes import first_bytes
from .source import Source, Stream

HEAD = b"\xa3\x95"
"""Begin of every message of a binary log."""
TIMES = {"TimeUS": 1e6, "TimeMS": 1e3}
FIRMWARE = {"MSG": "Message", "VER": "FWS"}
"""Messages that name the firmware, and the field that does; a MSG may say anything else, too."""
VEHICLE = re.compile(r"(?:Ardu|APM:|Antenna)?(Sub|Rover|Copter|Plane|Blimp|Tracker) [Vv]\d")
"""The vehicle in ``ArduSub V4.1.0 (f2af3c7e)``."""


def open_dataflash(path: Path) -> Source:
    """A DataFlash log as a source.

    Raises:
        DataError: it holds no messages with time stamps.
    """
    library = needed("pymavlink.DFReader", "ardupilot", "DataFlash logs")
    if not path.exists():
        raise UsageError(f"{path}: there is no such log")
    text = _is_text(path)
    if not text and first_bytes(path, len(HEAD)) != HEAD:
        raise DataError(f"{path}: this is not a DataFlash log: it begins with neither A3 95 nor an FMT line")

    def messages(types: list[str] | None = None) -> Iterator[tuple[str, Any]]:
        log = (library.DFReader_text if text else library.DFReader_binary)(str(path))
        try:
            while (message := log.recv_match(type=types)) is not None:
                instance = message.fmt.instance_field
                name = message.get_type()
                yield (name if instance is None else f"{name}[{getattr(message, instance)}]"), message
        finally:
            log.close()

    contents: dict[str, tuple[str, ...]] = {}
    try:
        for name, message in messages():
            if name not in contents and _time(message) is not None:
                fields = [f for f in message.get_fieldnames() if isinstance(getattr(message, f), int | float)]
                contents[name] = tuple(f for f in fields if f not in TIMES)
    except Exception as error:  # the library raises errors of many kinds for files that are none of its own
        raise DataError(f"{path}: this DataFlash log cannot be read: {error}") from None
    if not contents:
        raise DataError(f"{path}: this is not a DataFlash log: it has no message with a time stamp")

    def read(wanted: Mapping[str, frozenset[str]]) -> Mapping[str, Stream]:
        stamps: dict[str, list[int]] = {name: [] for name in wanted}
        values: dict[str, list[list[float]]] = {name: [] for name in wanted}
        ticks: dict[str, float] = {}
        for name, message in messages([name.partition("[")[0] for name in wanted]):
            if name in wanted and (stamp := _time(message)) is not None:
                ticks[name] = TIMES[stamp]
                stamps[name].append(getattr(message, stamp))
                values[name].append([float(getattr(message, field)) for field in sorted(wanted[name])])
        return {
            name: Stream(
                np.array(stamps[name], dtype=np.int64),
                ticks[name],
                dict(zip(sorted(wanted[name]), np.array(values[name]).T, strict=True)),
                "time since the autopilot began",
            )
            for name in wanted
        }

    return Source(str(path), contents, read)


def told_by_dataflash(path: Path) -> tuple[dict[str, float], str | None, list[tuple[int, int]]]:
    """Parameters of a DataFlash log, its vehicle, and when (ns) this went into which mode (its number).

    The vehicle is named as its firmware is (``Sub``, ``Rover``, ``Copter``, …); `None` where no message names it.
    """
    library = needed("pymavlink.DFReader", "ardupilot", "DataFlash logs")
    text = _is_text(path)
    parameters: dict[str, float] = {}
    vehicle: str | None = None
    modes: list[tuple[int, int]] = []
    log = (library.DFReader_text if text else library.DFReader_binary)(str(path))
    try:
        while (message := log.recv_match(type=["PARM", "MODE", "MSG", "VER"])) is not None:
            kind = message.get_type()
            if kind == "PARM":
                parameters[str(message.Name)] = float(message.Value)
            elif kind in FIRMWARE:
                named = VEHICLE.match(str(getattr(message, FIRMWARE[kind], "")))
                vehicle = named[1] if named else vehicle
            elif (stamp := _time(message)) is not None:
                modes.append((round(getattr(message, stamp) * 1e9 / TIMES[stamp]), int(message.ModeNum)))
    finally:
        log.close()
    return parameters, vehicle, modes


def _is_text(path: Path) -> bool:
    begin = first_bytes(path, 8000)
    return b"FMT," in begin and not begin.startswith(HEAD)


def _time(message: Any) -> str | None:
    return next((t for t in TIMES if t in message.get_fieldnames()), None)
