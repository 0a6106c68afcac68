"""The SI units of channels, by their canonical names."""

from __future__ import annotations

import re

COMMAND = re.compile(r"V[1-9][0-9]*")
"""The command of a thruster."""
FORCE = re.compile(r"F[1-9][0-9]*")
COMMAND_UNITS = ("V", "1", "us")
"""Units that a command may have."""
VELOCITIES = dict(zip(["surge", "sway", "heave", "roll", "pitch", "yaw"], ["u", "v", "w", "p", "q", "r"], strict=True))
"""The velocity of each degree of freedom."""
_GROUPS = {
    "m/s": "u v w",
    "rad/s": "p q r",
    "m": "x y z",
    "rad": "phi theta psi",
    "N": "tau_u tau_v tau_w",
    "N*m": "tau_p tau_q tau_r",
}
_UNITS = {name: unit for unit, names in _GROUPS.items() for name in names.split()}


def unit_of(channel: str) -> str:
    """SI unit of a channel; empty where its name does not tell.

    >>> unit_of("psi"), unit_of("F3"), unit_of("wind")
    ('rad', 'N', '')
    """
    return _UNITS.get(channel, "N" if FORCE.fullmatch(channel) else "")


def units_of(channel: str) -> tuple[str, ...]:
    """Units in which a channel may be held, those of a command in order of preference."""
    if COMMAND.fullmatch(channel):
        return COMMAND_UNITS
    return tuple(filter(None, [unit_of(channel)]))
