"""What the log of an autopilot says of the vehicle beside its signals: parameters, and the modes in which it was.

DataFlash has both in messages of their own, MAVLink (``.tlog``, or JSON in the MCAP logs of BlueOS) as
``PARAM_VALUE`` and ``HEARTBEAT``, mavros as ``mavros_msgs/Param`` and ``mavros_msgs/State``.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

from .dataflash import told_by_dataflash
from .source import Source

SUB, ROVER = "Sub", "Rover"
"""Vehicles of ArduPilot whose modes are known here, by the names of their firmware."""
MODES: Mapping[str, Mapping[int, str]] = {
    SUB: {
        0: "STABILIZE",
        1: "ACRO",
        2: "ALT_HOLD",
        3: "AUTO",
        4: "GUIDED",
        7: "CIRCLE",
        9: "SURFACE",
        16: "POSHOLD",
        19: "MANUAL",
        20: "MOTOR_DETECT",
        21: "SURFTRAK",
    },
    ROVER: {
        0: "MANUAL",
        1: "ACRO",
        3: "STEERING",
        4: "HOLD",
        5: "LOITER",
        6: "FOLLOW",
        7: "SIMPLE",
        8: "DOCK",
        9: "CIRCLE",
        10: "AUTO",
        11: "RTL",
        12: "SMART_RTL",
        15: "GUIDED",
        16: "INITIALISING",
    },
}
"""Modes of vehicles by their numbers (ArduPilot, ArduSub/mode.h and Rover/mode.h): one number is not one mode."""
OPEN_LOOP = frozenset({"MANUAL", "HOLD", "INITIALISING"})
"""Modes in which no controller steers: MANUAL hands commands through, the others, of Rover, stop the motors."""
UNKNOWN = "number "
"""Begin of the name of a mode of which only the number is known."""
ARDUPILOT = 3
"""MAV_AUTOPILOT_ARDUPILOTMEGA."""
VEHICLES = {10: ROVER, 11: ROVER, 12: SUB}
"""Vehicles by MAV_TYPE_GROUND_ROVER, MAV_TYPE_SURFACE_BOAT and MAV_TYPE_SUBMARINE."""
NAMES = {
    "MAV_AUTOPILOT_ARDUPILOTMEGA": ARDUPILOT,
    "MAV_TYPE_GROUND_ROVER": 10,
    "MAV_TYPE_SURFACE_BOAT": 11,
    "MAV_TYPE_SUBMARINE": 12,
}
"""The same where BlueOS writes names."""


@dataclass
class Told:
    """What a log tells of its vehicle.

    Attributes:
        parameters: parameters of the autopilot by name, the last value of each.
        modes: from when on (ns, on the clock of the log) it was in which mode.
        notes: what was taken for granted, for people.
    """

    parameters: dict[str, float] = field(default_factory=dict)
    modes: list[tuple[int, str]] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)


def told(path: Path, source: Source, kind: str) -> Told:
    """Parameters and modes of a log of this `kind` (``ardupilot``, ``mavlink``, ``px4`` or ``ros``)."""
    if kind == "ardupilot":
        parameters, vehicle, modes = told_by_dataflash(path)
        named = [(at, mode_name(vehicle or SUB, number)) for at, number in modes]
        assumed = ["no message names the vehicle: its modes are read as those of ArduSub"]
        return Told(parameters, named, assumed if modes and vehicle is None else [])
    if source.messages is None:
        return Told()
    readers = {
        stream: reader for stream in source.contents for pattern, reader in READERS if fnmatchcase(stream, pattern)
    }
    made = Told()
    for stream, at, message in source.messages(frozenset(readers)) if readers else ():
        readers[stream](made, at, message)
    return made


def mode_name(vehicle: str, number: int) -> str:
    """A mode of a vehicle of ArduPilot; ``number N`` of those that are not known.

    >>> mode_name("Sub", 0), mode_name("Rover", 0), mode_name("Copter", 0)
    ('STABILIZE', 'MANUAL', 'number 0')
    """
    return MODES.get(vehicle, {}).get(number, f"{UNKNOWN}{number}")


def closed_loop(modes: list[tuple[int, str]], end: int) -> list[tuple[int, int, str]]:
    """Stretches in modes that steer: from, to, mode; `end` is that of the log. All in ns.

    Of a mode of which only the number is known nothing is claimed.

    >>> closed_loop([(0, "MANUAL"), (10, "ALT_HOLD"), (30, "number 99")], 40)
    [(10, 30, 'ALT_HOLD')]
    """
    following = itertools.pairwise([*modes, (end, "")])
    return [(start, stop, mode) for (start, mode), (stop, _) in following if _steers(mode) and stop > start]


def _steers(mode: str) -> bool:
    return mode not in OPEN_LOOP and not mode.startswith(UNKNOWN)


def _parameter(made: Told, _: int, message: Any) -> None:
    """``PARAM_VALUE`` of MAVLink."""
    fields = _fields(message)
    name = fields.get("param_id", "")
    name = name if isinstance(name, str) else "".join(name)
    made.parameters[name.rstrip("\0")] = float(fields["param_value"])


def _mavros_parameter(made: Told, _: int, message: Any) -> None:
    """``mavros_msgs/Param``: a whole number where it is not 0, else a real one."""
    value = message.value
    made.parameters[str(message.param_id)] = float(value.integer or value.real)


def _heartbeat(made: Told, at: int, message: Any) -> None:
    """``HEARTBEAT`` of ArduSub or ArduRover; a gimbal or a ground station has modes of its own."""
    fields = _fields(message)
    kind = fields.get("type") if "mavtype" not in fields else fields["mavtype"]
    vehicle = VEHICLES.get(_number(kind))
    if _number(fields.get("autopilot")) == ARDUPILOT and vehicle is not None:
        _add(made, at, mode_name(vehicle, int(fields["custom_mode"])))


def _mavros_state(made: Told, at: int, message: Any) -> None:
    """``mavros_msgs/State``."""
    if getattr(message, "connected", True) and getattr(message, "mode", ""):
        _add(made, at, str(message.mode))


def _add(made: Told, at: int, mode: str) -> None:
    if not made.modes or made.modes[-1][1] != mode:
        made.modes.append((at, mode))


def _fields(message: Any) -> Mapping[str, Any]:
    """The fields of a message of MAVLink, which BlueOS puts beside a header."""
    found: Mapping[str, Any] = message.get("message", message)
    return found


def _number(value: Any) -> Any:
    """A number that BlueOS writes as ``{"type": NAME}``."""
    named = value.get("type") if isinstance(value, Mapping) else value
    return NAMES.get(named, named) if isinstance(named, str) else named


READERS = (
    ("PARAM_VALUE", _parameter),
    ("HEARTBEAT", _heartbeat),
    ("mavlink/*/1/PARAM_VALUE", _parameter),
    ("mavlink/*/1/HEARTBEAT", _heartbeat),
    ("*/param/param_value", _mavros_parameter),
    ("*mavros/state", _mavros_state),
)
"""Patterns of the names of streams, and what takes their messages."""
