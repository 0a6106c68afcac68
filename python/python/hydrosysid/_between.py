"""Channels interpolated to other instants than their samples."""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import NDArray

from ._units import unit_of

Array = NDArray[np.float64]

COMMAND = re.compile(r"tau_.*|V[0-9]+|(acting_)?F[0-9]+")
"""Channels of what was commanded: forces, commands of thrusters, their forces."""


def read_at(time: Array, name: str, stamps: Array, values: Array, *, held: bool) -> Array:
    """A channel at `time`: linearly interpolated; outside its samples the nearest one.

    Args:
        time: instants, s.
        name: name of the channel: angles go the short way around, commands may be held.
        stamps: instants of its samples, s, increasing.
        values: its samples.
        held: commands keep their value until the next sample.

    >>> stamps, heading = np.array([0.0, 1.0]), np.array([3.0, -3.0])
    >>> read_at(np.array([0.5]), "psi", stamps, heading, held=False).round(4).tolist()
    [-3.1416]
    >>> read_at(np.array([0.5]), "tau_u", stamps, heading, held=True).tolist()
    [3.0]
    """
    if held and COMMAND.fullmatch(name):
        before = np.searchsorted(stamps, time, side="right") - 1
        return np.asarray(values[np.maximum(before, 0)])
    if unit_of(name) == "rad":
        return _turned(time, stamps, values)
    return np.interp(time, stamps, values)


def _turned(time: Array, stamps: Array, values: Array) -> Array:
    """An angle, rad, in the range in which it is logged: −π to π, 0 to 2π, or counting turns."""
    turning = np.unwrap(values)
    between = np.interp(time, stamps, turning)
    if np.array_equal(turning, values):
        return between
    begin = 0.0 if values.min() >= 0.0 else -np.pi
    return np.asarray(begin + (between - begin) % (2.0 * np.pi))
