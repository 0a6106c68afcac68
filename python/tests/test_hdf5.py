"""HDF5 and MAT files of version 7.3, written as MATLAB and h5py lay them out, and MAT cell arrays of both versions."""

from pathlib import Path
from typing import Any

import h5py
import hydrosysid as hs
import numpy as np
import pandas as pd
import pytest
import scipy.io
import xarray as xr

T = np.arange(40) / 10.0
RNG = np.random.default_rng(3)
U, GYRO, MATRIX = RNG.standard_normal(40), RNG.standard_normal(40), RNG.standard_normal((40, 3))


class Matlab73:
    """A MAT file of version 7.3: HDF5 behind 512 bytes that say so; arrays by columns, cells as references."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.file = h5py.File(path, "w", userblock_size=512)
        self.references = self.file.create_group("#refs#")

    def array(self, place: Any, name: str, value: np.ndarray) -> None:
        item = place.create_dataset(name, data=np.atleast_2d(value).T if value.ndim == 1 else value.T)
        if value.ndim == 1:  # a column, n × 1, is stored as 1 × n
            del place[name]
            item = place.create_dataset(name, data=value[None, :])
        item.attrs["MATLAB_class"] = np.bytes_("double")

    def reference(self, value: np.ndarray) -> Any:
        name = f"r{len(self.references)}"
        self.array(self.references, name, value)
        return self.references[name].ref

    def cells(self, place: Any, name: str, values: list[np.ndarray], of_struct: bool = False) -> None:
        item = place.create_dataset(name, (len(values), 1), dtype=h5py.ref_dtype)
        for k, value in enumerate(values):
            item[k, 0] = self.reference(value)
        if not of_struct:  # the fields of a struct array are references, too, and have no class
            item.attrs["MATLAB_class"] = np.bytes_("cell")

    def close(self) -> None:
        self.file.close()
        with self.path.open("r+b") as file:
            file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")


def test_mat_of_version_7_3(tmp_path: Path) -> None:
    path = tmp_path / "dive.mat"
    mat = Matlab73(path)
    mat.array(mat.file, "t", T)
    mat.array(mat.file, "m", MATRIX)
    dvl = mat.file.create_group("dvl")
    dvl.attrs["MATLAB_class"] = np.bytes_("struct")
    mat.array(dvl, "u", U[::2])
    mat.array(dvl, "t", T[::2])
    mat.cells(mat.file, "c", [T, GYRO])
    runs = mat.file.create_group("runs")
    runs.attrs["MATLAB_class"] = np.bytes_("struct")
    mat.cells(runs, "u", [U, 2.0 * U], of_struct=True)
    table = mat.file.create_dataset("table", data=np.zeros((1, 6), dtype=np.uint32))
    table.attrs["MATLAB_class"], table.attrs["MATLAB_object_decode"] = np.bytes_("table"), 3
    word = mat.file.create_dataset("who", data=np.frombuffer("rov".encode("utf-16-le"), dtype=np.uint16)[:, None])
    word.attrs["MATLAB_class"] = np.bytes_("char")
    mat.close()
    columns = {
        "u": {"name": "dvl.u", "time": "dvl.t", "unit": "mm/s"},
        "v": {"name": "m[1]", "time": "t"},
        "r": {"name": "c[1]", "time": "c[0]"},
        "w": {"name": "runs[1].u", "time": "t"},
    }
    run = hs.Run.from_mat(path, columns=columns)
    np.testing.assert_array_equal(run["u"][0], T[::2])
    np.testing.assert_array_equal(run["u"][1], U[::2] / 1e3)
    np.testing.assert_array_equal(run["v"][1], MATRIX[:, 1])
    np.testing.assert_array_equal(run["r"][1], GYRO)
    np.testing.assert_array_equal(run["w"][1], 2.0 * U)
    (told,) = [f.message for f in run.findings if f.code == "L215"]
    assert "table is left out" in told
    assert "table2struct" in told
    with pytest.raises(hs.DataError, match=r"columns\.p: table cannot be read.*table2struct"):
        hs.Run.from_mat(path, columns={"t": "t", "p": "table.p"})
    path.rename(tmp_path / "dive.csv")
    np.testing.assert_array_equal(hs.convert(tmp_path / "dive.csv", columns=columns)["w"][1], 2.0 * U)


def test_cell_arrays_of_mat(tmp_path: Path) -> None:
    cells = np.empty(3, dtype=object)
    cells[:] = [T, MATRIX, 5.0]
    numbers = np.empty(40, dtype=object)
    numbers[:] = U.tolist()
    runs = np.zeros(2, dtype=[("u", object), ("t", object)])
    runs["u"][:], runs["t"][:] = [U, GYRO], [T, T]
    scipy.io.savemat(tmp_path / "a.mat", {"c": cells, "numbers": numbers, "runs": runs, "who": "rov"})
    columns = {
        "v": {"name": "c[1][2]", "time": "c[0]"},
        "u": {"name": "numbers", "time": "c[0]"},
        "r": {"name": "runs[1].u", "time": "runs[1].t"},
    }
    run = hs.Run.from_mat(tmp_path / "a.mat", columns=columns)
    np.testing.assert_array_equal(run["v"][1], MATRIX[:, 2])
    np.testing.assert_array_equal(run["u"][1], U)
    np.testing.assert_array_equal(run["r"][1], GYRO)


def test_a_number_in_brackets_is_no_unit(tmp_path: Path) -> None:
    cells = np.empty(2, dtype=object)
    cells[:] = [T, U]
    scipy.io.savemat(tmp_path / "a.mat", {"data": cells})
    run = hs.convert(tmp_path / "a.mat", columns={"t": "data[0]", "u": "data[1]"})
    np.testing.assert_array_equal(run["u"], [T, U])


def test_hdf5(tmp_path: Path) -> None:
    path = tmp_path / "dive.h5"
    with h5py.File(path, "w") as file:
        file["imu/t_ns"] = (T * 1e9).astype(np.int64)
        file["imu/gyro"] = MATRIX
        file["note"] = "a dive"
        file["image"] = np.zeros((3, 4, 5))
        log = np.zeros(40, dtype=[("t", float), ("u", np.float32), ("note", "S4")])
        log["t"], log["u"] = T, U
        file["log"] = log
    columns = {"u": {"name": "log.u", "time": "log.t"}, "r": {"name": "imu/gyro[2]", "time": "log.t", "unit": "deg/s"}}
    run = hs.Run.from_hdf5(path, columns=columns)
    np.testing.assert_array_equal(run["u"][1], U.astype(np.float32).astype(float))
    np.testing.assert_array_equal(run["r"][1], MATRIX[:, 2] * np.pi / 180.0)
    exact = hs.Run.from_hdf5(path, columns={"t": "imu/t_ns", "q": "imu/gyro[1]"}, time_unit="ns")
    np.testing.assert_array_equal(exact["q"][0], (T * 1e9).astype(np.int64) / 1e9)
    path.rename(tmp_path / "dive.bin")
    np.testing.assert_array_equal(hs.convert(tmp_path / "dive.bin", columns=columns)["u"][1], run["u"][1])
    with pytest.raises(hs.UsageError, match=r"columns\.u = 'log\.v' is not there; there are .*log\.u"):
        hs.convert(tmp_path / "dive.bin", columns={"u": {"name": "log.v", "time": "log.t"}})


def test_netcdf_of_version_4_is_one_whatever_its_name(tmp_path: Path) -> None:
    pytest.importorskip("h5netcdf")
    dataset = xr.Dataset({"u": ("t_dvl", U[::2])}, coords={"t_dvl": T[::2]})
    dataset.to_netcdf(tmp_path / "a.nc", engine="h5netcdf")
    (tmp_path / "b.h5").write_bytes((tmp_path / "a.nc").read_bytes())
    for name in ("a.nc", "b.h5"):
        run = hs.convert(tmp_path / name)
        np.testing.assert_array_equal(run["u"], np.array([T[::2], U[::2]]))


def test_a_table_of_pandas_in_hdf5_becomes_a_campaign(tmp_path: Path) -> None:
    table = pd.DataFrame({"time": T, "heading": np.sin(T), "pwm1": 1500.0 + 100.0 * np.sign(np.sin(T))})
    with h5py.File(tmp_path / "dive.h5", "w") as file:
        for name in table:
            file[str(name)] = table[name].to_numpy()
    text = hs.init([tmp_path / "dive.h5"], tmp_path / "dive")
    assert 'psi = "heading"' in text or "heading" in text
    assert (tmp_path / "dive" / "dive.csv").is_file()
