"""MAT files: to version 7 by SciPy, of version 7.3, which is HDF5, by h5py.

Vectors stand under their own names; those inside a struct are called ``struct.field``, columns of a matrix ``name[0]``,
cells of a cell array and elements of a struct array likewise. A cell array of numbers is a vector. Objects (tables,
timetables, strings) are left out, for only MATLAB knows what they hold.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .column_map import ColumnMap
from .extras import needed, read_by
from .first_bytes import first_bytes
from .source import MOST, Source
from .table import source_of

HDF5_MARK = b"MATLAB 7.3 MAT-file"
"""Begin of a MAT file of version 7.3."""
OBJECT = "an object of MATLAB (table, timetable, timeseries, string): save its columns as vectors, as by table2struct"


def open_mat(path: Path, columns: ColumnMap) -> tuple[Source, ColumnMap]:
    """A MAT file of any version."""
    if first_bytes(path, len(HDF5_MARK)) == HDF5_MARK:
        variables = read_by(_of_hdf5, path, needed("h5py", "hdf5", "MAT files of version 7.3"))
    else:
        variables = read_by(_of_version_7, path, needed("scipy.io", "mat", "MAT files"))
    arrays: dict[str, NDArray[Any]] = {}
    left_out: dict[str, str] = {}
    for name, value in variables.items():
        _vectors(name, value, arrays, left_out)
    return source_of(str(path), arrays, columns, left_out), columns


def _of_version_7(path: Path, library: Any) -> dict[str, Any]:
    """The variables of a file to version 7: structs are mappings, cells and struct arrays lists or object arrays."""
    found = library.loadmat(path, simplify_cells=True)
    opaque = found.pop("None", None)  # SciPy's name for objects
    variables = {name: value for name, value in found.items() if not name.startswith("__")}
    if opaque is not None:
        variables |= {entry["s0"].decode(): entry for entry in np.atleast_1d(opaque)}
    return variables


def _of_hdf5(path: Path, library: Any) -> dict[str, Any]:
    """The variables of a file of version 7.3, in the form of `_of_version_7`."""
    with library.File(path, "r") as file:
        return {name: _value(file, file[name]) for name in file if not name.startswith("#")}


def _value(file: Any, item: Any) -> Any:
    kind = item.attrs.get("MATLAB_class", b"struct")
    if "MATLAB_object_decode" in item.attrs:
        return np.void(b"")
    if not hasattr(item, "dtype"):  # a group: a struct, or a struct array whose fields are references
        fields = {name: _value(file, item[name]) for name in item}
        arrays = [name for name in item if _holds_references(item[name]) and not _is_cell(item[name])]
        if not arrays:
            return fields
        return [{name: fields[name][k] for name in arrays} for k in range(len(fields[arrays[0]]))]
    if item.attrs.get("MATLAB_empty", 0):
        return np.empty(0)
    if _holds_references(item):  # to the cells
        return [_value(file, file[reference]) for reference in item[()].T.ravel(order="F")]
    if kind == b"char":
        return "".join(map(chr, item[()].T.ravel()))
    return np.squeeze(item[()].T)  # MATLAB's order is that of columns


def _holds_references(item: Any) -> bool:
    return hasattr(item, "dtype") and item.dtype.kind == "O"


def _is_cell(item: Any) -> bool:
    return bool(item.attrs.get("MATLAB_class") == b"cell")


def _vectors(name: str, value: Any, found: dict[str, NDArray[Any]], left_out: dict[str, str]) -> None:
    """Adds the vectors of a variable by their names."""
    if isinstance(value, np.void):
        left_out[name] = OBJECT
    elif isinstance(value, Mapping):
        for field, part in value.items():
            _vectors(f"{name}.{field}", part, found, left_out)
    elif isinstance(value, list) or (isinstance(value, np.ndarray) and value.dtype == object):
        cells = value if isinstance(value, list) else value.ravel(order="F").tolist()
        if cells and all(np.ndim(cell) == 0 and np.asarray(cell).dtype.kind in "biuf" for cell in cells):
            found[name] = np.array(cells, dtype=np.float64)
            return
        for k, cell in enumerate(cells[:MOST]):
            _vectors(f"{name}[{k}]", cell, found, left_out)
    elif isinstance(value, np.ndarray) and value.ndim == 1:
        found[name] = value
    elif isinstance(value, np.ndarray) and value.ndim == 2 and value.shape[1] <= MOST:
        found.update({f"{name}[{k}]": value[:, k] for k in range(value.shape[1])})
