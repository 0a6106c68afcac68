"""Which field of a log of another format is which channel: what autopilots, ROS and MAVLink call things.

Each rule is ``stream pattern, field pattern, channel, options``; the first that matches a channel wins. Patterns are
those of `fnmatch`; ``[`` and ``]`` of a name are written ``(`` and ``)`` there.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from typing import Any

from .source import Source

Rule = tuple[str, str, str, Mapping[str, Any]]
DEG: Mapping[str, Any] = {"unit": "deg"}
NED: Mapping[str, Any] = {"frame": "ned"}
PULSE: Mapping[str, Any] = {"unit": "us"}
PLAIN: Mapping[str, Any] = {}
DVL: Mapping[str, Any] = {"frame": "frd"}
"""Reports of a DVL as it makes them (Water Linked A50, marine_acoustic_msgs): x forward, z where it points, down."""
VALID = "velocity_valid"
"""Field of a DVL's report that tells which of its velocities are any."""

ARDUPILOT: list[Rule] = [
    ("ATT*", "Roll", "phi", DEG),
    ("ATT*", "Pitch", "theta", DEG),
    ("ATT*", "Yaw", "psi", DEG),
    ("IMU(0)", "GyrX", "p", PLAIN),
    ("IMU(0)", "GyrY", "q", PLAIN),
    ("IMU(0)", "GyrZ", "r", PLAIN),
    ("XKF1(0)", "PD", "z", PLAIN),
    ("NKF1(0)", "PD", "z", PLAIN),
    ("CTUN", "Alt", "z", {"sign": -1}),
    ("BAT(0)", "Volt", "supply_V", PLAIN),
    ("BAT", "Volt", "supply_V", PLAIN),
]
AIDED: list[Rule] = [
    (stream, name, channel, NED if channel in "uvw" else PLAIN)
    for stream in ("XKF1(0)", "NKF1(0)")
    for name, channel in (("VN", "u"), ("VE", "v"), ("VD", "w"), ("PN", "x"), ("PE", "y"))
]
AIDS = ("VISO", "VISP", "GPS", "BCN", "OF")
"""Begins of messages of DataFlash that tell of a sensor that aids the EKF's velocities."""
MAVLINK_AIDED: list[Rule] = [
    ("*LOCAL_POSITION_NED", name, channel, NED if channel in "uvw" else PLAIN)
    for name, channel in (("vx", "u"), ("vy", "v"), ("vz", "w"), ("x", "x"), ("y", "y"), ("z", "z"))
]
MAVLINK_AIDS = ("VISION_POSITION_DELTA", "VISION_SPEED_ESTIMATE", "GPS_INPUT", "GPS_RAW_INT", "OPTICAL_FLOW")
"""The same of MAVLink."""
MAVLINK: list[Rule] = [
    ("*ATTITUDE", "roll", "phi", PLAIN),
    ("*ATTITUDE", "pitch", "theta", PLAIN),
    ("*ATTITUDE", "yaw", "psi", PLAIN),
    ("*ATTITUDE", "rollspeed", "p", PLAIN),
    ("*ATTITUDE", "pitchspeed", "q", PLAIN),
    ("*ATTITUDE", "yawspeed", "r", PLAIN),
    ("*VFR_HUD", "alt", "z", {"sign": -1}),
    ("*GLOBAL_POSITION_INT", "relative_alt", "z", {"sign": -1, "scale": 1e-3}),
    ("*SYS_STATUS", "voltage_battery", "supply_V", {"scale": 1e-3}),
    ("*BATTERY_STATUS", "voltages(0)", "supply_V", {"scale": 1e-3}),
    *[("*SERVO_OUTPUT_RAW", f"servo{k}_raw", f"V{k}", PULSE) for k in range(1, 17)],
]
BLUEOS = "mavlink/*/1/"
"""Topics of the MCAP logs of BlueOS that hold MAVLink of an autopilot: system, component, message, as JSON."""
PX4: list[Rule] = [
    *[
        ("vehicle_attitude", f"q.{angle}", channel, PLAIN)
        for angle, channel in (("roll", "phi"), ("pitch", "theta"), ("yaw", "psi"))
    ],
    *[("vehicle_angular_velocity", f"xyz({k})", channel, PLAIN) for k, channel in enumerate("pqr")],
    *[("vehicle_local_position", f"v{a}", channel, NED) for a, channel in zip("xyz", "uvw", strict=True)],
    *[("vehicle_local_position", a, a, PLAIN) for a in "xyz"],
    ("battery_status*", "voltage_v", "supply_V", PLAIN),
    *[("actuator_motors*", f"control({k})", f"V{k + 1}", {"unit": "1"}) for k in range(12)],
    *[("actuator_outputs*", f"output({k})", f"V{k + 1}", PULSE) for k in range(16)],
]
ROS: list[Rule] = [
    *[
        ("*", f"*{path}orientation.{angle}", channel, PLAIN)
        for path in ("pose.pose.", "pose.", "")
        for angle, channel in (("roll", "phi"), ("pitch", "theta"), ("yaw", "psi"))
    ],
    *[("*", f"*twist.twist.linear.{a}", channel, PLAIN) for a, channel in zip("xyz", "uvw", strict=True)],
    *[("*dvl*", f"velocity.{a}", channel, DVL) for a, channel in zip("xyz", "uvw", strict=True)],
    *[("*dvl*", f"*linear.{a}", channel, PLAIN) for a, channel in zip("xyz", "uvw", strict=True)],
    *[("*dvl*", f"v{a}", channel, PLAIN) for a, channel in zip("xyz", "uvw", strict=True)],
    *[("*", f"*angular_velocity.{a}", channel, PLAIN) for a, channel in zip("xyz", "pqr", strict=True)],
    *[("*", f"*twist.twist.angular.{a}", channel, PLAIN) for a, channel in zip("xyz", "pqr", strict=True)],
    *[("*", f"*pose.pose.position.{a}", a, PLAIN) for a in "xyz"],
    *[("*", f"*pose.position.{a}", a, PLAIN) for a in "xyz"],
    *[("*wrench*", f"*force.{a}", f"tau_{c}", PLAIN) for a, c in zip("xyz", "uvw", strict=True)],
    *[("*wrench*", f"*torque.{a}", f"tau_{c}", PLAIN) for a, c in zip("xyz", "pqr", strict=True)],
    *[("*depth*", f, "z", {"frame": "ned"}) for f in ("data", "depth")],
    *[("*rc/out*", f"channels({k})", f"V{k + 1}", PULSE) for k in range(16)],
    *[
        (topic, f"*({k})", f"V{k + 1}", PLAIN)
        for topic in ("*thruster*", "*motor*", "*pwm*", "*actuator*", "*rcout*")
        for k in range(12)
    ],
    ("*battery*", "voltage", "supply_V", PLAIN),
]

MOST_CHOICES = 4
"""Fields that are named beside the one that was taken."""
FIRST_MOTOR = 33
"""SERVOn_FUNCTION of motor 1 of ArduPilot."""
NEUTRAL = 1500.0
"""Pulse at which ArduSub lets a motor rest, µs (AP_Motors6DOF.cpp)."""


@dataclass
class Guess:
    """What was guessed of a log: columns, and what its parameters and modes say.

    Attributes:
        columns: canonical name = where it stands, as a column map has it.
        options: the reading options beside the columns.
        reasons: a sentence for each guess.
        frame: FRAME_CONFIG of ArduSub.
        directions: MOT_n_DIRECTION of motors 1, 2, …
        trims: SERVOn_TRIM of the outputs of motors 1, 2, …, µs; `None` where it is the usual 1500, or not told.
        span: from 1500 µs to the farther one of MOT_PWM_MIN and MOT_PWM_MAX, µs.
    """

    columns: dict[str, dict[str, Any]] = field(default_factory=dict)
    options: dict[str, Any] = field(default_factory=dict)
    reasons: list[str] = field(default_factory=list)
    frame: int | None = None
    directions: list[int] = field(default_factory=list)
    trims: list[float | None] = field(default_factory=list)
    span: float | None = None


def guess(source: Source, kind: str, parameters: Mapping[str, float]) -> Guess:
    """The columns of a log of this `kind` (``ardupilot``, ``mavlink``, ``px4`` or ``ros``)."""
    made = Guess(options={"missing": "no_sample", "duplicates": "first", "sort": True})
    rules = {"ardupilot": ARDUPILOT, "mavlink": MAVLINK, "px4": PX4, "ros": ROS}[kind]
    blueos = kind == "ros" and any(fnmatchcase(stream, BLUEOS + "*") for stream in source.contents)
    if blueos:
        kind, rules = "mavlink", _of_blueos(MAVLINK)
        made.reasons.append("a log of BlueOS: MAVLink in forward-starboard-down and north-east-down axes")
    if kind == "ardupilot" and any(s.startswith(AIDS) for s in source.contents):
        rules = [*AIDED, *rules]
        made.reasons.append("velocities and position are the EKF's: the log has a sensor (DVL, GPS, …) that aids it")
    elif kind == "mavlink" and any(s.rpartition("/")[2].startswith(MAVLINK_AIDS) for s in source.contents):
        rules = [*(_of_blueos(MAVLINK_AIDED) if blueos else MAVLINK_AIDED), *rules]
        made.reasons.append("velocities and position are the EKF's: the log has a sensor (DVL, GPS, …) that aids it")
    elif kind in ("ardupilot", "mavlink"):
        made.reasons.append("the EKF's velocities are left out: nothing aids them, so they do not show the motion")
    _apply(made, source, rules)
    if kind == "ros" and made.columns:
        made.options |= {"body_frame": "flu", "earth_frame": "enu"}
        made.reasons.append("axes are those of ROS (REP 103): body forward-left-up, earth east-north-up")
    _outputs(made, source, kind, parameters)
    made.frame = int(parameters["FRAME_CONFIG"]) if "FRAME_CONFIG" in parameters else None
    directions = [parameters.get(f"MOT_{k}_DIRECTION") for k in range(1, 13)]
    made.directions = [int(d) for d in directions if d is not None][: sum(c[0] == "V" for c in made.columns)]
    if {"MOT_PWM_MIN", "MOT_PWM_MAX"} <= set(parameters):
        made.span = max(parameters["MOT_PWM_MAX"] - NEUTRAL, NEUTRAL - parameters["MOT_PWM_MIN"])
    return made


def _of_blueos(rules: list[Rule]) -> list[Rule]:
    return [(BLUEOS + stream.lstrip("*"), f"message.{name}", channel, how) for stream, name, channel, how in rules]


def _apply(made: Guess, source: Source, rules: list[Rule]) -> None:
    """Places channels by the rules; what else a rule would have taken stands beside the reason as a choice."""
    others: dict[str, list[str]] = {}
    reasons: dict[str, str] = {}
    for stream_pattern, field_pattern, channel, options in rules:
        pattern = stream_pattern.replace("(", "[[]").replace(")", "[]]")
        wanted = field_pattern.replace("(", "[[]").replace(")", "[]]")
        for stream, fields in source.contents.items():
            if not fnmatchcase(stream.lower(), pattern.lower()):
                continue
            found = next((f for f in _with_angles(fields) if fnmatchcase(f, wanted)), None)
            if found is None:
                continue
            address = source.address(stream, found)
            if channel in made.columns:
                if address not in (made.columns[channel]["name"], *others.get(channel, ())):
                    others.setdefault(channel, []).append(address)
                continue
            if options is DVL and VALID in fields:
                options = {**options, "valid": VALID}
            made.columns[channel] = {"name": address, **options}
            more = "".join(f", {key} {value}" for key, value in options.items())
            reasons[channel] = f"{channel} is {address}{more}: its name"
    for channel, reason in reasons.items():
        more = " or ".join(json.dumps(other) for other in others.get(channel, ())[:MOST_CHOICES])
        made.reasons.append(f"{reason}; or columns.{channel} = {more}" if more else reason)


def _with_angles(fields: tuple[str, ...]) -> list[str]:
    """The fields, and the angles of the quaternions among them."""
    there = set(fields)
    found = list(fields)
    for name in fields:
        before = name.removesuffix("x") if name.endswith(".x") else None
        if before is not None and all(before + part in there for part in "yzw"):
            found += [before + angle for angle in ("roll", "pitch", "yaw")]
        if name.endswith("[0]") and f"{name[:-3]}[3]" in there and name[:-3].endswith("q"):
            found += [f"{name[:-3]}.{angle}" for angle in ("roll", "pitch", "yaw")]
    return found


def _outputs(made: Guess, source: Source, kind: str, parameters: Mapping[str, float]) -> None:
    """Outputs of the autopilot that drive motors, by the numbers of the motors."""
    functions = {
        int(v) - FIRST_MOTOR + 1: n
        for n in range(1, 17)
        if FIRST_MOTOR <= (v := parameters.get(f"SERVO{n}_FUNCTION", 0)) < FIRST_MOTOR + 12
    }
    stream, named = _output_fields(source, kind)
    # without parameters the channels of a ROS bag stay as they were placed by name
    if not stream or (kind == "ros" and not functions):
        return
    there = [k for k in range(1, 17) if named.format(k, k - 1) in source.contents[stream]]
    motors = functions or dict(enumerate(there[:8], 1))
    for channel in [c for c in made.columns if c[0] == "V"]:
        del made.columns[channel]
        made.reasons = [reason for reason in made.reasons if not reason.startswith(f"{channel} is ")]
    for motor, output in sorted(motors.items()):
        if output in there:
            made.columns[f"V{motor}"] = {"name": f"{stream}:{named.format(output, output - 1)}", **PULSE}
    trims = [parameters.get(f"SERVO{motors[motor]}_TRIM", NEUTRAL) for motor in sorted(motors)]
    made.trims = [None if trim == NEUTRAL else trim for trim in trims]
    why = "as SERVOn_FUNCTION of the log says" if functions else "in their order, as the log has no parameters"
    names, outputs = (", ".join(map(str, numbers)) for numbers in zip(*sorted(motors.items()), strict=True))
    made.reasons.append(f"the commands of thrusters {names} are the outputs {outputs} of {stream}, {why}")


def _output_fields(source: Source, kind: str) -> tuple[str, str]:
    """Stream of the outputs, and how their fields are called: by the number from 1 on, and from 0 on."""
    patterns = {
        "ardupilot": (("RCOU", "C{0}"),),
        "mavlink": (("SERVO_OUTPUT_RAW", "servo{0}_raw"), (BLUEOS + "SERVO_OUTPUT_RAW", "message.servo{0}_raw")),
        "ros": (("*rc/out", "channels[{1}]"),),
    }
    for pattern, named in patterns.get(kind, ()):
        stream = next((s for s in source.contents if fnmatchcase(s, pattern)), None)
        if stream is not None and source.contents[stream]:
            return stream, named
    return "", ""
