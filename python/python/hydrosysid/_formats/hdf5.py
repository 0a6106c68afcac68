"""HDF5 files of any writer, by h5py.

A dataset stands under its path, ``dvl/velocity``; columns of one with two dimensions are ``dvl/velocity[0]``, fields of
a table (a compound type, as PyTables and pandas write it) ``log.u``.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .column_map import ColumnMap
from .extras import needed, read_by
from .source import MOST, Source
from .table import source_of

MARK = b"\x89HDF\r\n\x1a\n"
"""Begin of an HDF5 file, which may stand behind a block of the user's own of 512, 1024, 2048 … bytes."""


def begins(begin: bytes) -> bool:
    """Whether a file with these first bytes is one of HDF5."""
    place = 0
    while place < len(begin):
        if begin.startswith(MARK, place):
            return True
        place = 2 * place or 512
    return False


def open_hdf5(path: Path, columns: ColumnMap) -> tuple[Source, ColumnMap]:
    """An HDF5 file."""
    arrays: dict[str, NDArray[Any]] = read_by(_vectors, path, needed("h5py", "hdf5", "HDF5 files"))
    return source_of(str(path), arrays, columns), columns


def is_netcdf(path: Path) -> bool:
    """Whether an HDF5 file is one of netCDF-4: its writer leaves a mark of itself at the root."""
    try:
        with needed("h5py", "hdf5", "HDF5 files").File(path, "r") as file:
            return "_NCProperties" in file.attrs
    except OSError:
        return False


def _vectors(path: Path, library: Any) -> dict[str, NDArray[Any]]:
    """The columns of all datasets by name."""
    found: dict[str, NDArray[Any]] = {}

    def visit(name: str, item: Any) -> None:
        shape = getattr(item, "shape", None)
        if shape is None or len(shape) not in (1, 2):
            return
        if item.dtype.names is not None and len(shape) == 1:
            found.update({f"{name}.{field}": item[field] for field in item.dtype.names})
        elif len(shape) == 1:
            found[name] = item[()]
        elif shape[1] <= MOST:
            values = item[()]
            found.update({f"{name}[{k}]": values[:, k] for k in range(shape[1])})

    with library.File(path, "r") as file:
        file.visititems(visit)
    return {name: np.asarray(values) for name, values in found.items()}
