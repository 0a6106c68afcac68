"""Input arrays: converted once, or refused with a message that names them.

NumPy turns masked, complex and dated arrays into doubles that mean something else: the value under a mask, the real
part, a count of ticks; and it drops units. Here a masked or absent value (None, pandas.NA) is NaN, dates are time
stamps or nothing, what carries units is converted to SI, and complex numbers are refused.
"""

from __future__ import annotations

import datetime
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._errors import DataError, UsageError
from ._quantities import without_units

Vector = NDArray[np.float64]
FINER = ("ps", "fs", "as")
"""Units of NumPy below a nanosecond: all that 64 bits hold of them is less than 292 years."""
DATED = (np.datetime64, np.timedelta64, datetime.date, datetime.timedelta)


def numbers(values: Any, name: str) -> NDArray[np.float64]:
    """An array of doubles in SI units, NaN where a value is masked or absent; an array is passed through.

    Raises:
        UsageError: not numbers.
    """
    given = _given(values, name)
    inside = {type(value) for value in given.flat} if given.dtype.kind == "O" else {given.dtype.type}
    if any(issubclass(kind, complex | np.complexfloating) for kind in inside):
        raise UsageError(f"{name} holds complex numbers: give its real part or its absolute value")
    if any(issubclass(kind, DATED) for kind in inside):
        raise UsageError(f"{name} holds dates or durations: only time stamps (t) can; give numbers")
    try:
        if np.ma.isMaskedArray(given):
            masked: Any = given
            return np.asarray(masked.astype(np.float64).filled(np.nan))
        return np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise UsageError(f"{name}: {error}") from None


def _given(values: Any, name: str) -> NDArray[Any]:
    try:
        given: NDArray[Any] = np.asanyarray(without_units(values, name))
    except (TypeError, ValueError) as error:  # rows of unequal length
        raise UsageError(f"{name}: {error}") from None
    if given.dtype.kind == "O" and not np.ma.isMaskedArray(given):
        absent = np.array([value is None or type(value).__name__ == "NAType" for value in given.flat], dtype=bool)
        if absent.any():
            given = np.where(absent.reshape(given.shape), np.nan, given)
    return given


def stamps_of(values: Any, name: str = "t") -> NDArray[Any]:
    """Time stamps as an array; instants and durations of Python become those of NumPy, in universal time."""
    given = _given(values, name)
    if given.dtype.kind != "O" or not given.size:
        return given
    utc = datetime.UTC
    inside = list(given.flat)
    if all(isinstance(stamp, datetime.datetime) for stamp in inside):
        plain = [s if s.tzinfo is None else s.astimezone(utc).replace(tzinfo=None) for s in inside]
        return np.array(plain, dtype="datetime64[us]")
    if all(isinstance(stamp, datetime.timedelta) for stamp in inside):
        return np.array(inside, dtype="timedelta64[us]")
    return given


def is_dated(values: Any) -> bool:
    """Whether these are instants of a calendar."""
    return stamps_of(values).dtype.kind == "M"


def seconds(values: Any, name: str, origin: np.datetime64 | None = None) -> NDArray[np.float64]:
    """Time stamps in seconds: numbers as they are, durations, and instants of a calendar since `origin`.

    >>> seconds(np.array([0, 250], dtype="timedelta64[ms]"), "t").tolist()
    [0.0, 0.25]

    Raises:
        UsageError: instants without an origin; not numbers.
        DataError: a stamp that is NaT or masked.
    """
    values = without_units(values, name, ("s",))
    given = stamps_of(values, name)
    if given.dtype.kind not in "mM":
        return numbers(values, name)
    without = np.isnat(given) | np.ma.getmaskarray(given)
    if without.any():
        raise DataError(f"{name}[{int(np.argmax(without))}] is not a time stamp: leave that sample out")
    if given.dtype.kind == "M" and origin is None:
        raise UsageError(f"{name} holds dates, but this run counts seconds: give seconds")
    passed = nanoseconds(np.asarray(given), name)
    if origin is not None and given.dtype.kind == "M":
        start = int(nanoseconds(np.asarray(origin), name))
        if len(passed) and int(passed.max()) - start > np.iinfo(np.int64).max:
            raise DataError(f"{name}: the run lasts longer than the 292 years that 64 bits of nanoseconds hold")
        passed = passed - start
    return np.asarray(passed / 1e9)


def nanoseconds(times: NDArray[Any], name: str) -> NDArray[np.int64]:
    """Instants since 1970 or durations as whole nanoseconds.

    Raises:
        DataError: one that does not fit 64 bits of nanoseconds, which NumPy would wrap around.
    """
    made = times.astype(f"{times.dtype.kind}8[ns]")
    if np.datetime_data(times.dtype)[0] not in FINER:
        wrapped = np.atleast_1d(made.astype(times.dtype) != times)
        if wrapped.any():
            k = int(np.argmax(wrapped))
            kind, span = ("date", "from 1678 to 2261") if times.dtype.kind == "M" else ("duration", "up to 292 years")
            value = np.atleast_1d(times)[k]
            raise DataError(f"{name}: the time stamp of sample {k + 1} is {value}: a {kind} {span} can be read")
    return np.asarray(made.astype(np.int64))


def shaped(values: Any, name: str, dimensions: int = 1) -> NDArray[np.float64]:
    """An array of doubles with the given number of dimensions, in its memory order; finiteness is not checked.

    Raises:
        UsageError: not numbers, or the wrong shape.
    """
    found = numbers(values, name)
    if found.ndim != dimensions:
        raise UsageError(f"{name} has the shape {found.shape}: {dimensions} dimension(s) are expected")
    return found if found.flags.aligned else found.copy()


def array(values: Any, name: str, dimensions: int = 1) -> NDArray[np.float64]:
    """A C-contiguous array of doubles with the given number of dimensions, all finite.

    Raises:
        UsageError: not numbers, or the wrong shape.
        DataError: a value is not finite.
    """
    found = shaped(values, name, dimensions)
    if not np.isfinite(found).all():
        place = tuple(int(i) for i in np.argwhere(~np.isfinite(found))[0])
        where = place[0] if dimensions == 1 else place
        raise DataError(f"{name}[{where}] is {found[place]}: only finite numbers can be used")
    return np.ascontiguousarray(found)


def increasing(time: Vector, name: str) -> None:
    """Refuses time stamps that do not increase."""
    steps = np.diff(time)
    if (steps <= 0.0).any():
        k = int(np.argmax(steps <= 0.0)) + 1
        raise DataError(f"{name}[{k}] = {time[k]} does not follow {time[k - 1]}: time must increase")
