"""A run: the measurements of one experiment, each sensor with its own time stamps."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from os import PathLike, fspath
from types import MappingProxyType
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from . import _native
from ._arrays import array, increasing, is_dated, numbers, seconds, stamps_of
from ._errors import DataError, Finding, UsageError
from ._files import write
from ._html import document, html_table
from ._plain import build
from ._quantities import in_si, quantity_of
from ._readers import Readers
from ._units import COMMAND, COMMAND_UNITS, units_of
from ._view import frame

Array = NDArray[np.float64]
KINDS = ("bollard", "towing", "constant_velocity", "oscillatory", "zigzag", "free")
ROLES = ("train", "validate")


class Run(Readers):
    """One run in SI units, under the names of the log format: ``u``, ``tau_u``, ``psi``, …

    Arrays that carry units (pint, astropy) are converted; masked and absent values (None, ``pandas.NA``) are NaN.

    Args:
        data: channels by name; keywords add to it.
        t: time stamps, s, of all channels without their own; or dates (datetime64), of which the first
            becomes 0, or durations (timedelta64).
        name: name shown to people.
        kind: ``bollard``, ``towing``, ``constant_velocity``, ``oscillatory``, ``zigzag`` or ``free``.
        role: ``train`` takes part in the fit, ``validate`` does not.
        gaps: time stamps at which a gap ends; nothing is integrated across one.
        missing: what NaN and masked values mean: ``error``, or ``no_sample`` where a sensor has no new sample at this
            instant.
        units: units of commands that are not in V: ``{"V1": "us"}``, or ``"1"``; a pulse in us becomes a command by the
            thruster's ``neutral`` and ``span``.
        channels: values, one per time stamp, or a pair (time stamps, values).

    Raises:
        DataError: time that does not increase, values that are not finite.
        UsageError: invalid shapes or words.

    >>> run = Run(t=[0.0, 0.1, 0.2], u=[0.0, 0.1, 0.15], tau_u=([0.0, 0.2], [5.0, 5.0]))
    >>> run.channels
    ('tau_u', 'u')
    >>> run["tau_u"][0].tolist()
    [0.0, 0.2]
    """

    __slots__ = ("findings", "gaps", "kind", "name", "role", "signals", "units")

    name: str
    kind: str
    role: str
    gaps: tuple[float, ...]
    signals: Mapping[str, tuple[Array, Array]]
    findings: tuple[Finding, ...]
    units: Mapping[str, str]

    def __init__(
        self,
        data: Mapping[str, Any] | None = None,
        /,
        *,
        t: Any = None,
        name: str = "run",
        kind: str = "free",
        role: str = "train",
        gaps: Iterable[float] = (),
        missing: Literal["error", "no_sample"] = "error",
        units: Mapping[str, str] | None = None,
        **channels: Any,
    ) -> None:
        given = dict(data or {}) | channels
        stamps = given.pop("t", None) if t is None else t
        for word, words, what in (
            (kind, KINDS, "kind"),
            (role, ROLES, "role"),
            (missing, MISSING, "missing"),
        ):
            if word not in words:
                raise UsageError(f"run {name!r}: {what} = {word!r} is none of {', '.join(words)}")
        origin = _origin([stamps, *(values[0] for values in given.values() if _is_pair(values))], f"run {name!r}")
        time = None if stamps is None else _time(stamps, f"run {name!r}: t", origin)
        signals: dict[str, tuple[Array, Array]] = {}
        told = dict(units or {})
        for channel, values in given.items():
            label = f"run {name!r}: {channel}"
            if _is_pair(values):
                own, values = _time(values[0], f"{label} (its time)", origin), values[1]
            elif time is not None:
                own = time
            else:
                raise UsageError(f"{label} has no time stamps: give t, or a pair (t, {channel})")
            quantity = quantity_of(values)
            if quantity is not None:
                values, unit = in_si(quantity, label, units_of(channel))
                if COMMAND.fullmatch(channel):
                    told.setdefault(channel, unit)
            signals[channel] = _signal(own, values, label, missing == "no_sample")
        if not signals:
            raise UsageError(f"run {name!r} has no channel")
        for channel, unit in told.items():
            if channel not in signals or not COMMAND.fullmatch(channel) or unit not in COMMAND_UNITS:
                text = f"units[{channel!r}] = {unit!r}: a command V1, V2, … that is there has one of "
                raise UsageError(f"run {name!r}: {text}{', '.join(COMMAND_UNITS)}")
        ends = tuple(array(seconds(list(gaps), f"run {name!r}: gaps", origin), f"run {name!r}: gaps").tolist())
        self._set(name, kind, role, ends, signals, (), told)

    def _set(
        self,
        name: str,
        kind: str,
        role: str,
        gaps: tuple[float, ...],
        signals: dict[str, tuple[Array, Array]],
        findings: tuple[Finding, ...],
        units: dict[str, str],
    ) -> None:
        shown = MappingProxyType(dict(sorted(signals.items())))
        volts_left_out = MappingProxyType({channel: unit for channel, unit in sorted(units.items()) if unit != "V"})
        whole = (findings, gaps, kind, name, role, shown, volts_left_out)
        for key, value in zip(self.__slots__, whole, strict=True):
            object.__setattr__(self, key, value)

    def with_role(self, role: str) -> Run:
        """The same run with another role, ``train`` or ``validate``.

        Raises:
            UsageError: no such role.
        """
        if role not in ROLES:
            raise UsageError(f"run {self.name!r}: role = {role!r} is none of {', '.join(ROLES)}")
        run = object.__new__(type(self))
        run._set(self.name, self.kind, role, self.gaps, dict(self.signals), self.findings, dict(self.units))
        return run

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, Any], **options: Any) -> Run:
        """A run from a mapping of channels, ``t`` among them; options as for `Run`."""
        return cls(arrays, **options)

    @classmethod
    def from_frame(
        cls,
        frame: Any,
        *,
        columns: Mapping[str, str | Mapping[str, Any]] | None = None,
        guess: bool = False,
        **options: Any,
    ) -> Run:
        """A run from a data frame of pandas or polars, an Arrow table or an xarray dataset.

        Args:
            frame: one column per channel, ``t`` among them, SI or with the unit in brackets, ``u [kn]``; nullable
                columns, and columns that carry units themselves (pint-pandas), are understood.
            columns: canonical name = name in the frame, or a table of name, unit, sign and frame, as for `Readers`;
                only these are taken. All columns when absent.
            guess: infer from names, units and values which column is which channel, as `init` does; every guess about
                how they are read is one of the run's `findings`. What is given as options is not guessed.
            options: ``name``, ``kind``, ``role``, ``gaps`` and ``units`` as for `Run`, and reading options as for
                `Readers`; with `guess` those of ``[log]`` in a campaign.

        Raises:
            DataError: missing values, time that does not increase, no column that can be recognised.
            UsageError: no such column; the message lists the existing ones.
        """
        from ._frames import run_of_frame

        return run_of_frame(cls, frame, columns, guess, options)

    @classmethod
    def from_csv(
        cls,
        path: str | PathLike[str],
        *,
        name: str | None = None,
        kind: str = "free",
        role: str = "train",
        required: Iterable[str] = (),
        **log: Any,
    ) -> Run:
        """A run from a log; units and frames are converted on reading.

        Args:
            path: the CSV file.
            name: name shown to people; that of the file when absent.
            kind: as for `Run`.
            role: as for `Run`.
            required: columns that must be present.
            log: the reading options of ``[log]`` in a campaign: ``delimiter``, ``columns``, ``missing``, …

        Raises:
            DataError: the log was refused; its `findings` name file, line and column.
        """
        signals, units, gaps, found = _native.read_log(fspath(path), json.dumps(log), list(required))
        findings = tuple(build(Finding, entry) for entry in json.loads(found))
        run = cls(signals, name=name or fspath(path), kind=kind, role=role, gaps=gaps)
        run._set(run.name, kind, role, run.gaps, dict(run.signals), findings, _commands(units))
        return run

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the channels."""
        return tuple(self.signals)

    def __getitem__(self, channel: str) -> tuple[Array, Array]:
        """Time stamps and values of a channel, both read-only."""
        return self.signals[channel]

    def with_channels(self, channels: Mapping[str, tuple[Any, Any]]) -> Run:
        """The same run with further channels, each a pair (time stamps, values); one with the same name is replaced."""
        for channel, values in channels.items():
            if _is_pair(values) and is_dated(values[0]):
                seconds(values[0], f"{channel} (its time)")
        added = Run(channels, name=self.name)
        run = object.__new__(Run)
        run._set(
            self.name,
            self.kind,
            self.role,
            self.gaps,
            {**self.signals, **added.signals},
            self.findings,
            dict(self.units),
        )
        return run

    def to_frame(self, library: Literal["pandas", "polars"] | None = None) -> Any:
        """A data frame with a row for each instant at which some channel has a sample; NaN where one has none."""
        time = np.unique(np.concatenate([stamps for stamps, _ in self.signals.values()]))
        table = {"t": time}
        for channel, (stamps, values) in self.signals.items():
            table[channel] = np.full(len(time), np.nan)
            table[channel][np.searchsorted(time, stamps)] = values
        rows = [dict(zip(table, row, strict=True)) for row in zip(*(c.tolist() for c in table.values()), strict=True)]
        return frame(rows, library)

    def to_csv(self, path: str | PathLike[str], *, force: bool = False) -> None:
        """Writes the run as CSV that reads back to the same bits; read it with ``missing = "no_sample"`` where sensors
        have their own rates.

        Args:
            path: file to write, atomically.
            force: replace an existing file.
        """
        write(path, _native.csv_of(self._native(), None), force)

    def _native(self) -> tuple[str, str, str, list[float], dict[str, str], dict[str, tuple[Array, Array]]]:
        return (self.name, self.kind, self.role, list(self.gaps), dict(self.units), dict(self.signals))

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"a Run does not change: {name} cannot be set")

    def __reduce__(self) -> tuple[Any, ...]:
        state = (self.name, self.kind, self.role, self.gaps, dict(self.signals), self.findings, dict(self.units))
        return (_unpickled, state)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Run):
            return NotImplemented
        same = (self.name, self.kind, self.role, self.gaps, self.units) == (
            other.name,
            other.kind,
            other.role,
            other.gaps,
            other.units,
        )
        return (
            same
            and self.channels == other.channels
            and all(np.array_equal(a, b) for c in self.channels for a, b in zip(self[c], other[c], strict=True))
        )

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        longest = max(len(stamps) for stamps, _ in self.signals.values())
        return f"<Run {self.name!r}: {self.kind}, {self.role}, {longest} samples of {' '.join(self.channels)}>"

    def _repr_html_(self) -> str:
        rows = [
            {"channel": c, "samples": len(t), "from, s": t[0].item(), "to, s": t[-1].item()}
            for c, (t, _) in self.signals.items()
            if len(t)
        ]
        return document(repr(self)[1:-1], [html_table(rows)], findings=self.findings)


MISSING = ("error", "no_sample")


def _commands(units: Mapping[str, str]) -> dict[str, str]:
    return {channel: unit for channel, unit in units.items() if COMMAND.fullmatch(channel)}


def _unpickled(
    name: str, kind: str, role: str, gaps: Any, signals: dict[str, Any], findings: Any, units: dict[str, str]
) -> Run:
    run = object.__new__(Run)
    # buffers that crossed a wire may lie at odd places
    whole = {channel: (_frozen(time), _frozen(values)) for channel, (time, values) in signals.items()}
    run._set(name, kind, role, gaps, whole, findings, units)
    return run


def _is_pair(values: Any) -> bool:
    return isinstance(values, tuple) and len(values) == 2 and np.ndim(values[0]) == 1


def _origin(stamps: list[Any], label: str) -> np.datetime64 | None:
    """The first of all instants of a calendar, which becomes t = 0; stamps of a run are all such or none."""
    given = [stamps_of(values) for values in stamps if values is not None]
    dated = [values for values in given if values.dtype.kind == "M" and values.size]
    if not dated:
        return None
    if len(dated) < len([values for values in given if values.size]):
        raise UsageError(f"{label}: some time stamps are dates and some are not: give only one kind")
    return np.datetime64(min(np.min(values[~np.isnat(values)], initial=values.flat[0]) for values in dated))


def _time(values: Any, label: str, origin: np.datetime64 | None = None) -> Array:
    time = _frozen(array(seconds(values, label, origin), label))
    increasing(time, label)
    return time


def _signal(time: Array, values: Any, label: str, no_sample: bool) -> tuple[Array, Array]:
    if no_sample:
        raw = numbers(values, label)
        there = ~np.isnan(raw)
        if raw.shape == time.shape:
            time, values = _frozen(time[there]), raw[there]
    found = _frozen(array(values, label))
    if len(found) != len(time):
        raise DataError(f"{label} has {len(found)} values for {len(time)} time stamps")
    return time, found


def _frozen(values: Array) -> Array:
    """A copy that nobody else can change."""
    values = values.copy()
    values.flags.writeable = False
    return values
