"""Which format a file is in, by its first bytes, and how it is opened."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._errors import DataError, UsageError
from . import hdf5, table
from .column_map import ColumnMap
from .dataflash import open_dataflash
from .extras import needed, read_by
from .first_bytes import first_bytes
from .mat import open_mat
from .mcap_log import open_mcap
from .rosbag import open_rosbag
from .source import Source
from .telemetry import open_telemetry
from .ulog import open_ulog

Opened = tuple[Source, ColumnMap]


def _table(name: str, arrays: dict[str, NDArray[Any]], columns: ColumnMap) -> Opened:
    return table.source_of(name, arrays, columns), columns


def open_parquet(path: Path, columns: ColumnMap) -> Opened:
    """A Parquet file."""
    found = read_by(needed("pyarrow.parquet", "parquet", "Parquet files").read_table, path)
    return _table(str(path), table.of_arrow(found), columns)


def open_arrow(path: Path, columns: ColumnMap) -> Opened:
    """An Arrow IPC file (Feather), or an IPC stream."""
    arrow = needed("pyarrow.feather", "arrow", "Arrow files")
    ipc = needed("pyarrow.ipc", "arrow", "Arrow files")
    stream = first_bytes(path, len(STREAM_MARK)) == STREAM_MARK
    found = read_by(lambda p: ipc.open_stream(p.read_bytes()).read_all() if stream else arrow.read_table(p), path)
    return _table(str(path), table.of_arrow(found), columns)


def open_numpy(path: Path, columns: ColumnMap) -> Opened:
    """An ``.npz`` of vectors, or an ``.npy`` with named fields."""
    found = read_by(np.load, path, allow_pickle=False)
    names = found.files if hasattr(found, "files") else found.dtype.names
    if not names:
        raise DataError(f"{path}: an .npy file needs named fields (a structured array); or save the channels as .npz")
    return _table(str(path), {name: np.asarray(found[name]) for name in names}, columns)


def open_netcdf(path: Path, columns: ColumnMap) -> Opened:
    """A netCDF file, as xarray writes it; version 4, which is HDF5, by h5netcdf."""
    engine = None
    if hdf5.begins(first_bytes(path, LOOKED_AT)):
        engine = needed("h5netcdf", "hdf5", "netCDF files of version 4").__name__
    dataset = read_by(needed("xarray", "xarray", "netCDF files").load_dataset, path, engine=engine)
    arrays, columns = table.of_xarray(dataset, columns, str(path))
    return _table(str(path), arrays, columns)


def open_hdf5(path: Path, columns: ColumnMap) -> Opened:
    """An HDF5 file, netCDF-4 among them."""
    return open_netcdf(path, columns) if hdf5.is_netcdf(path) else hdf5.open_hdf5(path, columns)


FORMATS: dict[str, Callable[[Path, ColumnMap], Opened]] = {
    ".bag": lambda path, columns: (open_rosbag(path, columns.clock, columns.msg), columns),
    ".db3": lambda path, columns: (open_rosbag(path, columns.clock, columns.msg), columns),
    ".mcap": lambda path, columns: (open_mcap(path, columns.clock, columns.msg), columns),
    ".tlog": lambda path, columns: (open_telemetry(path), columns),
    ".bin": lambda path, columns: (open_dataflash(path), columns),
    ".ulg": lambda path, columns: (open_ulog(path), columns),
    ".mat": open_mat,
    ".h5": open_hdf5,
    ".hdf5": open_hdf5,
    ".parquet": open_parquet,
    ".arrow": open_arrow,
    ".arrows": open_arrow,
    ".feather": open_arrow,
    ".nc": open_netcdf,
    ".npz": open_numpy,
    ".npy": open_numpy,
}
"""How a file is opened, by the end of its name; a folder is a ROS 2 bag, everything else is CSV."""
STREAM_MARK = b"\xff\xff\xff\xff"
"""Begin of an Arrow IPC stream."""
SIGNATURES: tuple[tuple[bytes, str], ...] = (
    (b"\xa3\x95", ".bin"),
    (b"ULog\x01\x12\x35", ".ulg"),
    (b"\x89MCAP0\r\n", ".mcap"),
    (b"#ROSBAG V", ".bag"),
    (b"SQLite format 3\0", ".db3"),
    (b"MATLAB 5.0 MAT-file", ".mat"),
    (b"MATLAB 7.3 MAT-file", ".mat"),
    (b"CDF\x01", ".nc"),
    (b"CDF\x02", ".nc"),
    (b"CDF\x05", ".nc"),
    (b"PAR1", ".parquet"),
    (b"ARROW1", ".feather"),
    (b"FEA1", ".feather"),
    (STREAM_MARK, ".arrows"),
    (b"\x93NUMPY", ".npy"),
)
"""First bytes of logs, whatever their names, and the format that they are of."""
LOOKED_AT = 1 << 16
"""How many bytes of a file tell its format."""
TEXT_DATAFLASH = re.compile(rb"(?:^|\A\xef\xbb\xbf)FMT, *128, *\d+, *FMT *,", re.MULTILINE)
"""The line with which a DataFlash log in its text form tells how its lines are made."""
YEARS = range(946_684_800_000_000, 4_102_444_800_000_000)
"""From 2000 to 2100, µs since 1970."""
NO_TEXT = re.compile(rb"[\x00-\x08\x0e-\x1f]")
"""Bytes that no text holds."""


def format_of(path: Path) -> str | None:
    """The format of a file, as the end of a name in `FORMATS`; `None` is CSV.

    The first bytes tell it. The name counts where they tell nothing: no such file, an empty one, or bytes that are no
    text and begin like no known log, as MAT files of version 4.
    """
    if path.is_dir():
        return ".db3"
    begin = first_bytes(path, LOOKED_AT)
    known = next((name for mark, name in SIGNATURES if begin.startswith(mark)), None)
    if known is None and _is_npz(begin):
        known = ".npz"
    # behind the marks: a MAT file of version 7.3 is an HDF5 file with a block of its own
    if known is None and hdf5.begins(begin):
        known = ".h5"
    if known is None and begin[8:9] in (b"\xfe", b"\xfd") and int.from_bytes(begin[:8], "big") in YEARS:
        known = ".tlog"
    if known is None and TEXT_DATAFLASH.search(begin[:4096]):
        known = ".bin"
    end = path.suffix.lower()
    # of one file signature there are several formats: a name says which
    if known == ".h5" and end == ".nc":
        known = end
    if known is not None or (begin and not NO_TEXT.search(begin[:4096])):
        return known
    return end if end in FORMATS else None


def _is_npz(begin: bytes) -> bool:
    """Whether this begins a zip of NumPy arrays: its first entry is called ``….npy``."""
    length = int.from_bytes(begin[26:28], "little")
    return begin.startswith(b"PK\x03\x04") and begin[30 : 30 + length].endswith(b".npy")


def is_known(path: Path) -> bool:
    """Whether the file is in one of these formats, by its first bytes or its name."""
    return format_of(path) is not None


def open_source(path: Path, columns: ColumnMap) -> Opened:
    """Opens a file in one of these formats."""
    known = format_of(path)
    if known is None:
        raise UsageError(f"{path}: the format is none of {', '.join(sorted(FORMATS))}")
    return FORMATS[known](path, columns)
