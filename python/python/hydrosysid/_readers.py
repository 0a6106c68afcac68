"""Runs from logs in other formats: `Run.from_rosbag` and its neighbours."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ._errors import UsageError

if TYPE_CHECKING:
    from ._formats import ColumnMap, Source
    from ._run import Run

File = str | PathLike[str]
Columns = Mapping[str, str | Mapping[str, Any]]


class Readers:
    """The readers of `Run`. Each sensor keeps its own time stamps, and nothing is resampled.

    All of them take the same keywords:

    * ``columns``: canonical name = its source: ``STREAM:FIELD`` (``FIELD`` in a plain table), or a table with
      ``name``, ``unit``, ``scale``, ``sign``, ``frame`` (``frd``, ``flu``, ``ned``, ``enu``), ``valid`` (a field; where
      it is 0 there is no sample) and ``time``. Of a quaternion ``q`` the angles are ``q.roll``, ``q.pitch``, ``q.yaw``.
      ``u``, ``v``, ``w`` with ``frame = "ned"`` or ``"enu"`` are rotated to body axes by ``phi``, ``theta``, ``psi``.
    * ``body_frame``, ``earth_frame``: axes of all channels that name none.
    * ``missing = "no_sample"``, ``duplicates = "first"``, ``sort = True``, ``time_unit``, ``clock = "log"``.
    * ``msg``: ``.msg`` files, or folders of them, with ROS types whose definitions a log does not contain.
    * ``map``: a TOML file with these options, as for ``hydrosysid convert --map``.
    * ``name``, ``kind``, ``role``, ``gaps`` of the run.
    """

    __slots__ = ()

    @classmethod
    def from_rosbag(cls, path: File, *, columns: Columns | None = None, **options: Any) -> Run:
        """A run from a ROS 1 bag, or a ROS 2 bag (its folder, ``.db3`` or ``.mcap``); needs ``hydrosysid[ros]``.

        Args:
            path: the bag.
            columns: ``{"u": "/dvl:twist.linear.x", "psi": "/odom:pose.pose.orientation.yaw"}``.
            options: as for `Readers`; ROS writes ``body_frame="flu", earth_frame="enu"``.
        """
        from ._formats.rosbag import open_rosbag

        return _read(path, columns, options, lambda p, c: (open_rosbag(p, c.clock, c.msg), c))

    @classmethod
    def from_mcap(cls, path: File, *, columns: Columns | None = None, **options: Any) -> Run:
        """A run from an MCAP log of ROS or JSON messages; needs ``hydrosysid[ros]``.

        Args:
            path: the log.
            columns: ``{"u": {"name": "/dvl:velocity.x", "valid": "velocity_valid"}}``.
            options: as for `Readers`.
        """
        from ._formats.mcap_log import open_mcap

        return _read(path, columns, options, lambda p, c: (open_mcap(p, c.clock, c.msg), c))

    @classmethod
    def from_dataflash(cls, path: File, *, columns: Columns | None = None, **options: Any) -> Run:
        """A run from an ArduPilot DataFlash log; needs ``hydrosysid[ardupilot]``.

        Args:
            path: the log, ``.BIN``.
            columns: ``{"V1": {"name": "RCOU:C1", "unit": "us"}, "psi": {"name": "XKF1[0]:Yaw", "unit": "deg"}}``.
            options: as for `Readers`.
        """
        from ._formats.dataflash import open_dataflash

        return _read(path, columns, options, lambda p, c: (open_dataflash(p), c))

    @classmethod
    def from_tlog(cls, path: File, *, columns: Columns | None = None, **options: Any) -> Run:
        """A run from a MAVLink telemetry log, as ground stations write them; needs ``hydrosysid[ardupilot]``.

        Args:
            path: the log, ``.tlog``.
            columns: ``{"phi": "ATTITUDE:roll", "V1": {"name": "SERVO_OUTPUT_RAW:servo1_raw", "unit": "us"}}``.
            options: as for `Readers`.
        """
        from ._formats.telemetry import open_telemetry

        return _read(path, columns, options, lambda p, c: (open_telemetry(p), c))

    @classmethod
    def from_ulog(cls, path: File, *, columns: Columns | None = None, **options: Any) -> Run:
        """A run from a PX4 ULog file; needs ``hydrosysid[px4]``.

        Args:
            path: the log, ``.ulg``.
            columns: ``{"r": "vehicle_angular_velocity:xyz[2]", "psi": "vehicle_attitude:q.yaw"}``.
            options: as for `Readers`.
        """
        from ._formats.ulog import open_ulog

        return _read(path, columns, options, lambda p, c: (open_ulog(p), c))

    @classmethod
    def from_mat(cls, path: File, *, columns: Columns | None = None, **options: Any) -> Run:
        """A run from a MAT file; needs ``hydrosysid[mat]``, of version 7.3 ``hydrosysid[hdf5]``.

        Args:
            path: the file.
            columns: ``{"u": {"name": "dvl.u", "time": "dvl.t"}, "t": "t"}``; vectors under their own names when absent.
                The second column of a matrix is ``m[1]``, the second cell of a cell array ``c[1]``.
            options: as for `Readers`.
        """
        from ._formats.mat import open_mat

        return _read(path, columns, options, open_mat)

    @classmethod
    def from_hdf5(cls, path: File, *, columns: Columns | None = None, **options: Any) -> Run:
        """A run from an HDF5 file; needs ``hydrosysid[hdf5]``.

        Args:
            path: the file.
            columns: ``{"u": {"name": "dvl/velocity[0]", "time": "dvl/t"}}``: the path of a dataset, of one of several
                columns with its number, of a table with its field: ``log.u``.
            options: as for `Readers`.
        """
        from ._formats.hdf5 import open_hdf5

        return _read(path, columns, options, open_hdf5)

    @classmethod
    def from_parquet(cls, path: File, *, columns: Columns | None = None, **options: Any) -> Run:
        """A run from a Parquet file; needs ``hydrosysid[parquet]``. Arguments as for `from_mat`."""
        from ._formats.open import open_parquet

        return _read(path, columns, options, open_parquet)

    @classmethod
    def from_arrow(cls, table: Any, *, columns: Columns | None = None, **options: Any) -> Run:
        """A run from an Arrow table, an IPC file (Feather) or stream; needs ``hydrosysid[arrow]``.

        Arguments as for `from_mat`.
        """
        from ._formats import table as tables
        from ._formats.open import open_arrow

        if isinstance(table, str | PathLike):
            return _read(table, columns, options, open_arrow)
        return _table("Arrow table", tables.of_arrow(table), columns, options)

    @classmethod
    def from_pandas(cls, frame: Any, *, columns: Columns | None = None, **options: Any) -> Run:
        """A run from a pandas frame; a time index serves as ``columns={"t": "index"}``. Arguments as for `from_mat`."""
        from ._formats import table

        return _table("pandas frame", table.of_pandas(frame), columns, options)

    @classmethod
    def from_polars(cls, frame: Any, *, columns: Columns | None = None, **options: Any) -> Run:
        """A run from a polars frame. Arguments as for `from_mat`."""
        from ._formats import table

        return _table("polars frame", table.of_polars(frame), columns, options)

    @classmethod
    def from_xarray(cls, dataset: Any, *, columns: Columns | None = None, **options: Any) -> Run:
        """A run from an xarray dataset; the time of each variable is the coordinate of its dimension.

        Arguments as for `from_mat`.
        """
        from ._formats import run_of
        from ._formats import table as tables

        map_, run = _options(columns, options)
        arrays, map_ = tables.of_xarray(dataset, map_)
        source: Source = tables.source_of("xarray dataset", arrays, map_)
        return run_of(source, map_, **({"name": "run"} | run))

    @classmethod
    def from_numpy(cls, arrays: Any, *, columns: Columns | None = None, **options: Any) -> Run:
        """A run from a mapping of arrays, a structured array, or an ``.npz`` or ``.npy`` file of these.

        >>> import hydrosysid as hs
        >>> t = np.array([0, 100, 200])
        >>> run = hs.Run.from_numpy({"t": t, "speed": [1.0, 2.0, 4.0]}, time_unit="ms",
        ...     columns={"u": {"name": "speed", "unit": "kn"}})
        >>> run["u"][0].tolist(), run["u"][1].round(4).tolist()
        ([0.0, 0.1, 0.2], [0.5144, 1.0289, 2.0578])
        """
        from ._formats.open import open_numpy

        if isinstance(arrays, str | PathLike):
            return _read(arrays, columns, options, open_numpy)
        names = arrays.keys() if isinstance(arrays, Mapping) else getattr(arrays.dtype, "names", None)
        if not names:
            raise UsageError("from_numpy takes a mapping of arrays, a structured array, or the path of a file of such")
        return _table("arrays", {name: np.asanyarray(arrays[name]) for name in names}, columns, options)


def _options(columns: Columns | None, options: Mapping[str, Any]) -> tuple[ColumnMap, dict[str, Any]]:
    """The column map, and what is said of the run itself."""
    from ._formats import ColumnMap

    given = dict(options)
    run: dict[str, Any] = {key: given.pop(key) for key in ("name", "kind", "role", "gaps") if key in given}
    file = given.pop("map", None)
    if columns is not None:
        given["columns"] = columns
    return (ColumnMap.of(given) if file is None else ColumnMap.from_file(file, given)), run


def _read(
    path: File,
    columns: Columns | None,
    options: Mapping[str, Any],
    opened: Callable[[Path, ColumnMap], tuple[Source, ColumnMap]],
) -> Run:
    from ._formats import run_of

    map_, run = _options(columns, options)
    source, map_ = opened(Path(path), map_)
    return run_of(source, map_, **({"name": fspath(path)} | run))


def _table(name: str, arrays: Mapping[str, Any], columns: Columns | None, options: Mapping[str, Any]) -> Run:
    from ._formats import run_of
    from ._formats.table import source_of

    map_, run = _options(columns, options)
    return run_of(source_of(name, arrays, map_), map_, **({"name": "run"} | run))
