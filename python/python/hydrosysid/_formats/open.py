"""Which format a file is in, by its name, and how it is opened."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._errors import DataError, UsageError
from . import table
from .column_map import ColumnMap
from .dataflash import open_dataflash
from .extras import needed
from .mcap_log import open_mcap
from .rosbag import open_rosbag
from .source import Source
from .ulog import open_ulog

Opened = tuple[Source, ColumnMap]


def _table(name: str, arrays: dict[str, NDArray[Any]], columns: ColumnMap) -> Opened:
    return table.source_of(name, arrays, columns), columns


def _read(path: Path, reader: Callable[..., Any], *arguments: Any, **options: Any) -> Any:
    """What a library's reader returns, or an error that names the file."""
    if not path.exists():
        raise UsageError(f"{path}: there is no such file")
    try:
        return reader(path, *arguments, **options)
    except NotImplementedError:
        raise DataError(f"{path}: this is MATLAB's HDF5 form; save it with -v7 instead of -v7.3") from None
    except Exception as error:  # libraries raise errors of many kinds for files that are none of theirs
        raise DataError(f"{path}: this file cannot be read: {error}") from None


def open_parquet(path: Path, columns: ColumnMap) -> Opened:
    """A Parquet file."""
    found = _read(path, needed("pyarrow.parquet", "parquet", "Parquet files").read_table)
    return _table(str(path), table.of_arrow(found), columns)


def open_arrow(path: Path, columns: ColumnMap) -> Opened:
    """An Arrow IPC (Feather) file."""
    found = _read(path, needed("pyarrow.feather", "arrow", "Arrow files").read_table)
    return _table(str(path), table.of_arrow(found), columns)


def open_mat(path: Path, columns: ColumnMap) -> Opened:
    """A MAT file up to version 7."""
    found = _read(path, needed("scipy.io", "mat", "MAT files").loadmat, simplify_cells=True)
    return _table(str(path), table.of_mat({k: v for k, v in found.items() if not k.startswith("__")}), columns)


def open_numpy(path: Path, columns: ColumnMap) -> Opened:
    """An ``.npz`` of vectors, or an ``.npy`` with named fields."""
    found = _read(path, np.load, allow_pickle=False)
    names = found.files if hasattr(found, "files") else found.dtype.names
    if not names:
        raise DataError(f"{path}: an .npy file needs named fields (a structured array); or save the channels as .npz")
    return _table(str(path), {name: np.asarray(found[name]) for name in names}, columns)


def open_netcdf(path: Path, columns: ColumnMap) -> Opened:
    """A netCDF file, as xarray writes it."""
    dataset = _read(path, needed("xarray", "xarray", "netCDF files").load_dataset)
    arrays, columns = table.of_xarray(dataset, columns)
    return _table(str(path), arrays, columns)


FORMATS: dict[str, Callable[[Path, ColumnMap], Opened]] = {
    ".bag": lambda path, columns: (open_rosbag(path, columns.clock), columns),
    ".db3": lambda path, columns: (open_rosbag(path, columns.clock), columns),
    ".mcap": lambda path, columns: (open_mcap(path, columns.clock), columns),
    ".bin": lambda path, columns: (open_dataflash(path), columns),
    ".ulg": lambda path, columns: (open_ulog(path), columns),
    ".mat": open_mat,
    ".parquet": open_parquet,
    ".arrow": open_arrow,
    ".feather": open_arrow,
    ".nc": open_netcdf,
    ".npz": open_numpy,
    ".npy": open_numpy,
}
"""How a file is opened, by the end of its name; a folder is a ROS 2 bag, everything else is CSV."""


def is_known(path: Path) -> bool:
    """Whether the file is in one of these formats, judged by its name."""
    return path.is_dir() or path.suffix.lower() in FORMATS


def open_source(path: Path, columns: ColumnMap) -> Opened:
    """Opens a file in one of these formats."""
    if path.is_dir():
        return open_rosbag(path, columns.clock), columns
    return FORMATS[path.suffix.lower()](path, columns)
