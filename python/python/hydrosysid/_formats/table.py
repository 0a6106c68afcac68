"""Plain tables: data frames, Parquet, Arrow, MAT, HDF5, NumPy. One stream without a name.

Time is the column ``t``, or the one that the map says: ``columns.t`` for all, ``time`` for a single channel. Columns
that are no numbers are left aside.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._errors import UsageError
from .._quantities import quantity_of
from .column_map import ColumnMap, ColumnSource
from .source import Source, Stream, name_and_unit, ticks


def source_of(
    name: str, arrays: Mapping[str, NDArray[Any]], columns: ColumnMap, left_out: Mapping[str, str] | None = None
) -> Source:
    """Columns by name as a source; `left_out` names what could not be read, each with the reason.

    Raises:
        UsageError: no time stamps.
    """
    plain = {
        key: unmasked(values) for key, values in arrays.items() if values.ndim == 1 and values.dtype.kind in "biufmM"
    }
    for channel, entry in columns.columns.items():
        if entry.name in arrays and arrays[entry.name].dtype.kind == "c":
            raise UsageError(f"{name}: columns.{channel} = {entry.name!r} holds complex numbers: give their real part")
    # t is time wherever it is, under its own name or another
    own = next((key for key in plain if name_and_unit(key)[0] == "t"), None)
    given = columns.columns.get("t", None if own is None else ColumnSource(own))
    if given is not None and given.name not in plain:
        raise UsageError(f"{name}: columns.t = {given.name!r} is not there; there are {', '.join(plain)}")
    if given is not None and (given.scale, given.sign) != (1.0, 1):
        raise UsageError(f"{name}: columns.t: time accepts a unit (s, ms, us, ns), but no scale and no sign")
    timeless = [n for n, c in columns.columns.items() if n != "t" and c.time is None]
    if given is None and (timeless or not columns.columns):
        there = ", ".join(plain) or "no column of numbers"
        raise UsageError(f'{name}: no time stamps: give columns.t = "…"; there are {there}')
    times = {entry.time for entry in columns.columns.values()}
    fields = {key: x for key, x in plain.items() if given is None or key != given.name or key in times}

    def read(wanted: Mapping[str, frozenset[str]]) -> Mapping[str, Stream]:
        stamps, per_second = np.empty(0), 1.0
        if given is not None:
            unit = given.unit or columns.time_unit or name_and_unit(given.name)[1]
            stamps, per_second = ticks(plain[given.name], unit, f"{name}: columns.t = {given.name!r}")
        return {"": Stream(stamps, per_second, {field: plain[field] for field in wanted[""]})}

    shown = tuple(f for f in fields if plain[f].dtype.kind in "biuf" or columns.columns)
    return Source(name, {"": shown}, read, left_out or {})


def unmasked(values: NDArray[Any]) -> NDArray[Any]:
    """The array, NaN or NaT where a value is masked."""
    if not np.ma.isMaskedArray(values):
        return values
    masked: Any = values
    if values.dtype.kind in "mM":
        return np.asarray(masked.filled(np.array("NaT", dtype=values.dtype)))
    return np.asarray(masked.astype(np.float64).filled(np.nan)) if np.ma.is_masked(masked) else np.asarray(masked)


def of_pandas(frame: Any) -> dict[str, NDArray[Any]]:
    """Columns of a pandas frame; an index with a name is one, a nameless index of times is called ``index``."""
    columns = {str(name): _series(frame[name]) for name in frame.columns}
    index = frame.index
    if index.name is not None or index.dtype.kind in "mM":
        columns.setdefault(str(index.name or "index"), _series(index))
    return columns


def _series(series: Any) -> NDArray[Any]:
    if quantity_of(series) is not None:
        raise UsageError(f"the column {series.name!r} carries units: Run.from_frame reads such frames")
    kind = getattr(series.dtype, "kind", "O")
    if kind in "mM":
        # its own unit: pandas wraps instants that nanoseconds do not hold
        unit = getattr(getattr(series, "dt", series), "unit", "ns")
        return np.asarray(series.to_numpy(dtype=f"{kind}8[{unit}]"))
    if kind in "biuf" and not isinstance(series.dtype, np.dtype):
        # an extension type, which knows missing values
        lacks = series.isna().any()
        return np.asarray(series.to_numpy(dtype=np.float64, na_value=np.nan) if lacks else series.to_numpy())
    return np.asarray(series)


def of_polars(frame: Any) -> dict[str, NDArray[Any]]:
    """Columns of a polars frame."""
    return {name: frame[name].to_numpy() for name in frame.columns}


def of_arrow(table: Any) -> dict[str, NDArray[Any]]:
    """Columns of an Arrow table."""
    columns = zip(table.column_names, table.columns, strict=True)
    return {name: column.combine_chunks().to_numpy(zero_copy_only=False) for name, column in columns}


def of_xarray(
    dataset: Any, columns: ColumnMap, name: str = "xarray dataset"
) -> tuple[dict[str, NDArray[Any]], ColumnMap]:
    """Variables of an xarray dataset, and the map in which each has the coordinate of its dimension as its time.

    Raises:
        UsageError: a variable of several dimensions that the map asks for.
    """
    variables = {str(key): variable for key, variable in dataset.variables.items()}
    arrays = {key: np.asarray(variable.values) for key, variable in variables.items()}
    given = dict(columns.with_attitude(variables, name).columns)
    given = given or {str(key): ColumnSource(str(key)) for key in dataset.data_vars}
    timed = {}
    for channel, entry in given.items():
        dims = variables[entry.name].dims if entry.name in variables else ()
        if len(dims) > 1:
            raise UsageError(
                f"{entry.name} has the dimensions {', '.join(map(str, dims))}: select with .sel or .isel first"
            )
        own = entry.time if channel in columns.columns else None
        time = own or (str(dims[0]) if dims and str(dims[0]) in arrays else None)
        timed[channel] = ColumnSource(**(vars(entry) | {"time": time}))
    return arrays, ColumnMap(**(vars(columns) | {"columns": timed}))
