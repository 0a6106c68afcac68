"""Arrays at the door: converted once, refused with a message that names them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._errors import DataError, UsageError

Vector = NDArray[np.float64]


def array(values: Any, name: str, dimensions: int = 1) -> NDArray[np.float64]:
    """A C-contiguous array of doubles of so many dimensions, all finite.

    Raises:
        UsageError: no numbers, or another shape.
        DataError: a value is not finite.
    """
    try:
        found = np.ascontiguousarray(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise UsageError(f"{name}: {error}") from None
    if np.ndim(values) != dimensions:  # ascontiguousarray makes a list of a single number
        raise UsageError(f"{name} has the shape {np.shape(values)}: {dimensions} dimension(s) are expected")
    bad = ~np.isfinite(found)
    if bad.any():
        place = tuple(int(i) for i in np.argwhere(bad)[0])
        where = place[0] if dimensions == 1 else place
        raise DataError(f"{name}[{where}] is {found[place]}: only finite numbers can be used")
    return found


def increasing(time: Vector, name: str) -> None:
    """Refuses time stamps that do not increase."""
    steps = np.diff(time)
    if (steps <= 0.0).any():
        k = int(np.argmax(steps <= 0.0)) + 1
        raise DataError(f"{name}[{k}] = {time[k]} does not follow {time[k - 1]}: time must increase")
