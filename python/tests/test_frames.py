"""Axes of single channels, and velocities along earth axes, alike in CSV and in every other format."""

from collections.abc import Mapping
from pathlib import Path

import h5py
import hydrosysid as hs
import numpy as np
import pyarrow as pa
import pyarrow.ipc
import pyarrow.parquet
import pytest
import scipy.io
import xarray as xr

FORMS = ["csv", "parquet", "arrows", "npz", "mat", "h5"]
N = 50
T = np.arange(N) / 10.0
PHI, THETA, PSI = 0.1 * np.sin(T), 0.2 * np.cos(T), 2.0 + 0.5 * T
NED = np.random.default_rng(11).standard_normal((N, 3))
TABLE = {"t": T, "roll": PHI, "pitch": THETA, "yaw": PSI, "vn": NED[:, 0], "ve": NED[:, 1], "vd": NED[:, 2]}
COLUMNS = {
    "phi": "roll",
    "theta": "pitch",
    "psi": "yaw",
    **{c: {"name": n, "frame": "ned"} for c, n in (("u", "vn"), ("v", "ve"), ("w", "vd"))},
}


def body() -> np.ndarray:
    """Rᵀ(φ, θ, ψ) (north, east, down), written out by elementary turns."""
    turned = []
    for phi, theta, psi, v in zip(PHI, THETA, PSI, NED, strict=True):
        z = np.array([[np.cos(psi), -np.sin(psi), 0], [np.sin(psi), np.cos(psi), 0], [0, 0, 1]])
        y = np.array([[np.cos(theta), 0, np.sin(theta)], [0, 1, 0], [-np.sin(theta), 0, np.cos(theta)]])
        x = np.array([[1, 0, 0], [0, np.cos(phi), -np.sin(phi)], [0, np.sin(phi), np.cos(phi)]])
        turned.append((z @ y @ x).T @ v)
    return np.array(turned)


def write(folder: Path, form: str, columns: Mapping[str, np.ndarray] = TABLE) -> Path:
    path = folder / f"dive.{form}"
    table = pa.table(columns)
    if form == "csv":
        rows = [",".join(map(repr, row)) for row in zip(*(x.tolist() for x in columns.values()), strict=True)]
        path.write_text("\n".join([",".join(columns), *rows]) + "\n")
    elif form == "parquet":
        pyarrow.parquet.write_table(table, path)
    elif form == "arrows":
        with pyarrow.ipc.new_stream(path, table.schema) as stream:
            stream.write_table(table)
    elif form == "npz":
        np.savez(path, **columns)
    elif form == "h5":
        with h5py.File(path, "w") as file:
            for name, values in columns.items():
                file[name] = values
    else:
        scipy.io.savemat(path, columns)
    return path


@pytest.mark.parametrize("form", FORMS)
def test_velocities_along_earth_axes_become_those_of_the_body(tmp_path: Path, form: str) -> None:
    path = write(tmp_path, form)
    run = hs.convert(path, columns=COLUMNS)
    # products of three sines and cosines
    np.testing.assert_allclose(np.c_[run["u"][1], run["v"][1], run["w"][1]], body(), atol=1e-14)
    assert any(f.code == "L214" and "sampled with it" in f.message for f in run.findings)
    with pytest.raises(hs.HydrosysidError, match="missing: psi"):
        hs.convert(path, columns={k: v for k, v in COLUMNS.items() if k != "psi"})
    without = {k: v for k, v in COLUMNS.items() if k != "w"}
    for columns in (COLUMNS | {"w": {"name": "vd"}}, without):
        told = r"columns\.w: velocities along earth axes are rotated together: give the same frame for u, v and w"
        with pytest.raises(hs.UsageError, match=told):
            hs.convert(path, columns=columns)


@pytest.mark.parametrize("form", FORMS)
def test_an_attitude_under_its_own_names_need_not_be_said(tmp_path: Path, form: str) -> None:
    own = {"roll": "phi [deg]", "pitch": "theta", "yaw": "psi"}
    table = {own.get(name, name): x for name, x in TABLE.items()}
    table["phi [deg]"] = np.rad2deg(PHI)
    velocities = {c: COLUMNS[c] for c in "uvw"}
    run = hs.convert(write(tmp_path, form, table), columns=velocities)
    # products of three sines and cosines, and degrees there and back
    np.testing.assert_allclose(np.c_[run["u"][1], run["v"][1], run["w"][1]], body(), atol=1e-14)
    np.testing.assert_array_equal(run["psi"][1], PSI)
    with pytest.raises(hs.HydrosysidError, match="phi, theta, psi; missing: phi, theta"):
        hs.convert(write(tmp_path, form, {k: table[k] for k in ("t", "psi", "vn", "ve", "vd")}), columns=velocities)


def test_the_attitude_of_a_dataset_keeps_its_own_time() -> None:
    attitude = {"phi": PHI, "theta": THETA, "psi": PSI}
    variables = {name: ("t_dvl", x[::2]) for name, x in zip(("vn", "ve", "vd"), NED.T, strict=True)}
    dataset = xr.Dataset(
        variables | {name: ("t_imu", x) for name, x in attitude.items()}, coords={"t_dvl": T[::2], "t_imu": T}
    )
    run = hs.Run.from_xarray(dataset, columns={c: COLUMNS[c] for c in "uvw"})
    np.testing.assert_allclose(np.c_[run["u"][1], run["v"][1], run["w"][1]], body()[::2], atol=1e-14)
    np.testing.assert_array_equal(run["psi"], [T, PSI])


def test_every_format_says_the_same(tmp_path: Path) -> None:
    """To the last bit, by a map and by the campaign's own reader."""
    said = {form: hs.convert(write(tmp_path, form), columns=COLUMNS) for form in ("csv", "parquet", "arrows", "npz")}
    for run in said.values():
        for channel in ("u", "v", "w", "psi"):
            np.testing.assert_array_equal(run[channel], said["csv"][channel])
    east = dict(zip("uvw", ("ve", "vn", "vd"), strict=True))
    enu = COLUMNS | {c: {"name": n, "frame": "enu", "sign": -1 if c == "w" else 1} for c, n in east.items()}
    again = hs.Run.from_csv(tmp_path / "dive.csv", columns=enu)
    np.testing.assert_array_equal(again["v"][1], said["csv"]["v"][1])


def test_a_frame_of_one_channel(tmp_path: Path) -> None:
    columns = {"r": {"name": "yaw", "frame": "flu"}, "v": "ve", "z": {"name": "vd", "frame": "enu"}}
    for form in ("csv", "npz"):
        run = hs.convert(write(tmp_path, form), columns=columns)
        np.testing.assert_array_equal(run["r"][1], -PSI)
        np.testing.assert_array_equal(run["v"][1], NED[:, 1])
        np.testing.assert_array_equal(run["z"][1], -NED[:, 2])
    with pytest.raises(hs.UsageError, match="body"):
        hs.convert(tmp_path / "dive.csv", columns={"r": {"name": "yaw", "frame": "body"}})


def test_sensors_at_their_own_rates_in_csv(tmp_path: Path) -> None:
    """The attitude comes in every second row; it is interpolated, and what lies beyond it is left out and told."""
    path = tmp_path / "dive.csv"
    rows = ["t,roll,pitch,yaw,vn,ve,vd"]
    for k, values in enumerate(zip(*(x.tolist() for x in TABLE.values()), strict=True)):
        cells = [repr(x) for x in values]
        rows.append(",".join(cells[:1] + (["", "", ""] if k % 2 else cells[1:4]) + cells[4:]))
    path.write_text("\n".join(rows) + "\n")
    run = hs.Run.from_csv(path, columns=COLUMNS, missing="no_sample")
    np.testing.assert_array_equal(run["u"][0], T[:-1])
    np.testing.assert_allclose(np.c_[run["u"][1], run["v"][1], run["w"][1]][::2], body()[:-1:2], atol=1e-14)
    assert any(f.code == "L214" and "1 samples lie outside" in f.message for f in run.findings)


def test_parquet_tells_its_own_errors(tmp_path: Path) -> None:
    """pyarrow's `ArrowNotImplementedError` is a `NotImplementedError`, and no word of MATLAB."""
    path = write(tmp_path, "parquet")
    data = bytearray(path.read_bytes())
    path.write_bytes(bytes(data[: len(data) // 2]) + data[-8:])
    with pytest.raises(hs.DataError, match=r"dive\.parquet: this file cannot be read: (?!.*MATLAB)."):
        hs.Run.from_parquet(path, columns=COLUMNS)
    import pyarrow.parquet as library

    def unknown(_: Path) -> None:
        raise pa.ArrowNotImplementedError("Unsupported encoding: BYTE_STREAM_SPLIT")

    patch = pytest.MonkeyPatch()
    patch.setattr(library, "read_table", unknown)
    with patch.context(), pytest.raises(hs.DataError, match="Unsupported encoding: BYTE_STREAM_SPLIT"):
        hs.Run.from_parquet(write(tmp_path, "npz"), columns=COLUMNS)
    patch.undo()
