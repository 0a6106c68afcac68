"""Which format a file is in, by its first bytes or else by its name, and how it is opened."""

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
from .telemetry import open_telemetry
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
    ".tlog": lambda path, columns: (open_telemetry(path), columns),
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
SIGNATURES: tuple[tuple[bytes, str], ...] = (
    (b"\xa3\x95", ".bin"),
    (b"FMT, 128, 89, FMT,", ".bin"),
    (b"ULog\x01\x12\x35", ".ulg"),
    (b"\x89MCAP0\r\n", ".mcap"),
    (b"#ROSBAG V", ".bag"),
    (b"SQLite format 3\0", ".db3"),
    (b"MATLAB 5.0 MAT-file", ".mat"),
    (b"MATLAB 7.3 MAT-file", ".mat"),
    (b"PAR1", ".parquet"),
    (b"ARROW1", ".feather"),
    (b"\x93NUMPY", ".npy"),
)
"""First bytes of logs, whatever their names, and the format that they are of."""
YEARS = range(946_684_800_000_000, 4_102_444_800_000_000)
"""From 2000 to 2100, µs since 1970."""


def _format(path: Path) -> str | None:
    """The format of a file, as the end of a name in `FORMATS`: by its first bytes, else by its name."""
    begin = b""
    if path.is_file():
        with path.open("rb") as file:
            begin = file.read(32)
    known = next((name for mark, name in SIGNATURES if begin.startswith(mark)), None)
    if known is None and begin[8:9] in (b"\xfe", b"\xfd") and int.from_bytes(begin[:8], "big") in YEARS:
        known = ".tlog"
    end = path.suffix.lower()
    return known or (end if end in FORMATS else None)


def is_known(path: Path) -> bool:
    """Whether the file is in one of these formats, by its first bytes or its name."""
    return path.is_dir() or _format(path) is not None


def open_source(path: Path, columns: ColumnMap) -> Opened:
    """Opens a file in one of these formats."""
    if path.is_dir():
        return open_rosbag(path, columns.clock), columns
    known = _format(path)
    if known is None:
        raise UsageError(f"{path}: this is in none of the formats {', '.join(sorted(FORMATS))}")
    return FORMATS[known](path, columns)
