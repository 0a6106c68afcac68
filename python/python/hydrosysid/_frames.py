"""Runs from data frames of any library, with the columns as they are called, as they are mapped, or guessed."""

from __future__ import annotations

import csv
import json
import tempfile
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import _native
from ._errors import DataError, UsageError, found
from ._formats import table
from ._quantities import quantity_of

if TYPE_CHECKING:
    from ._run import Run


def run_of_frame(kind: type[Run], frame: Any, columns: Mapping[str, Any] | None, guess: bool, options: Any) -> Run:
    """The run made from a frame, as described for `Run.from_frame`.

    Raises:
        UsageError: no such column, both `guess` and `columns`, or not a data frame.
    """
    if guess:
        if columns is not None:
            raise UsageError("columns names each channel, and guess finds them: give one of the two")
        return _guessed(kind, _plain(frame), dict(options))
    home = type(frame).__module__.partition(".")[0]
    names = _names(frame)
    if any(quantity_of(frame[name]) is not None for name in names):
        taken = {name: name for name in names} if columns is None else _simple(columns)
        return kind({channel: frame[source] for channel, source in taken.items()}, **options)
    there = [*map(str, names), *_index_of(frame)]
    absent = [] if columns is None else [source for source in _sources(columns) if source not in there]
    if absent:
        raise UsageError(f"the frame has no column {', '.join(map(repr, absent))}; it has {', '.join(there)}")
    units: Mapping[str, str] = options.pop("units", None) or {}
    if units:
        whole = {str(name): str(name) for name in names} if columns is None else dict(columns)
        columns = whole | {channel: _with_unit(whole.get(channel, channel), unit) for channel, unit in units.items()}
    readers: dict[str, Any] = {
        "polars": kind.from_polars,
        "pyarrow": kind.from_arrow,
        "xarray": kind.from_xarray,
    }
    made: Run = readers.get(home, kind.from_pandas)(frame, columns=columns, **options)
    return made


def _names(frame: Any) -> list[Any]:
    for attribute in ("column_names", "columns", "data_vars"):
        names = getattr(frame, attribute, None)
        if names is not None:
            return list(names)
    raise UsageError(f"a data frame is expected, not {type(frame).__name__}")


def _index_of(frame: Any) -> list[str]:
    """How the index of a pandas frame is called; the coordinates of a dataset."""
    if hasattr(frame, "coords"):
        return [str(name) for name in frame.coords]
    index = getattr(frame, "index", None)
    return [] if index is None else [str(getattr(index, "name", None) or "index")]


def _sources(columns: Mapping[str, Any]) -> list[str]:
    return [entry if isinstance(entry, str) else entry["name"] for entry in columns.values()]


def _simple(columns: Mapping[str, Any]) -> dict[str, str]:
    told = [name for name, entry in columns.items() if not isinstance(entry, str)]
    if told:
        raise UsageError(f"columns.{told[0]}: the columns of this frame carry units: give only the name")
    return dict(columns)


def _with_unit(entry: Any, unit: str) -> dict[str, Any]:
    return ({"name": entry} if isinstance(entry, str) else dict(entry)) | {"unit": unit}


def _plain(frame: Any) -> dict[str, NDArray[Any]]:
    """Columns of a frame by name."""
    home = type(frame).__module__.partition(".")[0]
    if home == "xarray":
        raise UsageError("the variables of a dataset have their own times: name the channels with columns")
    readers = {"polars": table.of_polars, "pyarrow": table.of_arrow}
    return readers.get(home, table.of_pandas)(frame)


def _guessed(kind: type[Run], arrays: dict[str, NDArray[Any]], options: dict[str, Any]) -> Run:
    """The run that `init` would make of a log with these columns; every guess is a finding of it."""
    run = {key: options.pop(key) for key in ("name", "kind", "role", "gaps") if key in options}
    with tempfile.TemporaryDirectory() as folder:
        log = Path(folder) / "frame.csv"
        write_columns(log, arrays)
        figures = (None,) * 5
        text, *_ = _native.init_campaign([(log, log.name)], "", figures, None, json.dumps(options), "{}")
        campaign = tomllib.loads(text)
        if not campaign.get("run"):
            raise DataError(f"no column of the frame could be recognised; it has {', '.join(arrays)}")
        reading = campaign.get("log", {}) | campaign["run"][0].get("log", {})
        made = kind.from_csv(log, **({"name": "frame"} | run | reading))
    own = [found("K201", f"{made.name}: {guess}") for guess in _guesses(text)]
    made._set(made.name, made.kind, made.role, made.gaps, dict(made.signals), (*own, *made.findings), dict(made.units))
    return made


def _guesses(text: str) -> list[str]:
    """What a campaign's text says was guessed of how its log is read; of vehicle and model nothing becomes of a run."""
    said, table = [], ""
    for line in text.splitlines():
        if line.startswith("["):
            table = line.strip("[]")
        if line.startswith("# guessed: ") and table.removeprefix("run.").split(".")[0] == "log":
            said.append(line.removeprefix("# guessed: "))
    return said


def write_columns(target: Path, arrays: Mapping[str, NDArray[Any]]) -> None:
    """Columns of one length as CSV; dates in ISO 8601, nothing where a value is absent."""
    with target.open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(arrays)
        rows.writerows(zip(*([_cell(x) for x in _listed(column)] for column in arrays.values()), strict=True))


def _listed(column: NDArray[Any]) -> list[Any]:
    return list(np.datetime_as_string(column) if column.dtype.kind == "M" else column.tolist())


def _cell(value: Any) -> str:
    if isinstance(value, bool):
        return str(int(value))
    if value is None or value != value:
        return ""
    return repr(value) if isinstance(value, float) else str(value)
