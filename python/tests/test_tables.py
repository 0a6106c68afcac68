"""Data frames, Parquet, Arrow, MAT, netCDF and NumPy: the numbers of the table, bit for bit."""

import subprocess
import sys
from pathlib import Path

import hydrosysid as hs
import numpy as np
import pandas as pd
import polars as pl
import pyarrow as pa
import pyarrow.feather as feather
import pyarrow.parquet as parquet
import pytest
import scipy.io
import xarray as xr

RNG = np.random.default_rng(3)
T = np.arange(40) * 0.05
U, GYRO = RNG.standard_normal(40), RNG.standard_normal(40)
COLUMNS = {"t": "time", "u": "speed", "r": {"name": "gyro", "unit": "deg/s", "sign": -1}}
TABLE = {"time": T, "speed": U, "gyro": GYRO, "note": np.array(["x"] * 40)}


def check(run: hs.Run) -> None:
    assert run.channels == ("r", "u")
    np.testing.assert_array_equal(run["u"][0], T)
    np.testing.assert_array_equal(run["u"][1], U)
    # the order of the reader of CSV: times −π, over 180
    np.testing.assert_array_equal(run["r"][1], GYRO * -np.pi / 180.0)


def test_every_table_gives_the_same_run(tmp_path: Path) -> None:
    numbers = {k: v for k, v in TABLE.items() if k != "note"}
    table = pa.table(TABLE)
    parquet.write_table(table, tmp_path / "a.parquet")
    feather.write_feather(table, tmp_path / "a.arrow")
    scipy.io.savemat(tmp_path / "a.mat", TABLE)
    np.savez(tmp_path / "a.npz", **TABLE)
    structured = np.array(list(zip(*numbers.values(), strict=True)), dtype=[(k, float) for k in numbers])
    np.save(tmp_path / "a.npy", structured)
    check(hs.Run.from_parquet(tmp_path / "a.parquet", columns=COLUMNS))
    check(hs.Run.from_arrow(tmp_path / "a.arrow", columns=COLUMNS))
    check(hs.Run.from_arrow(table, columns=COLUMNS))
    check(hs.Run.from_mat(tmp_path / "a.mat", columns=COLUMNS))
    check(hs.Run.from_numpy(tmp_path / "a.npz", columns=COLUMNS))
    check(hs.Run.from_numpy(tmp_path / "a.npy", columns=COLUMNS))
    check(hs.Run.from_numpy(structured, columns=COLUMNS))
    check(hs.Run.from_numpy(TABLE, columns=COLUMNS))
    check(hs.Run.from_pandas(pd.DataFrame(TABLE), columns=COLUMNS))
    check(hs.Run.from_pandas(pd.DataFrame(TABLE).set_index("time"), columns=COLUMNS))
    check(hs.Run.from_polars(pl.DataFrame(TABLE), columns=COLUMNS))


def test_a_plain_table_with_units_in_its_names_needs_no_map() -> None:
    run = hs.Run.from_pandas(
        pd.DataFrame({"t [ms]": np.arange(5) * 100, "u [kn]": np.arange(5.0), "note": list("abcde")})
    )
    np.testing.assert_array_equal(run["u"][0], np.arange(5) * 100 / 1e3)
    np.testing.assert_array_equal(run["u"][1], np.arange(5.0) * 1852.0 / 3600.0)
    assert run.channels == ("u",)


def test_a_unit_in_a_name_counts_whether_the_column_is_mapped_or_not() -> None:
    table = {"time [ms]": T * 1e3, "gyro [deg/s]": GYRO, "bath [degC]": U, "dvl/t [ms]": T * 2e3, "side": U}
    columns = {
        "t": "time [ms]",
        "r": "gyro [deg/s]",
        "bath": "bath [degC]",
        "v": {"name": "side", "time": "dvl/t [ms]"},
    }
    run = hs.Run.from_numpy(table, columns=columns)
    np.testing.assert_array_equal(run["r"], [T * 1e3 / 1e3, GYRO * np.pi / 180.0])
    np.testing.assert_array_equal(run["bath"][1], U)
    np.testing.assert_array_equal(run["v"][0], T * 2e3 / 1e3)
    said = hs.Run.from_numpy(table, columns=columns | {"r": {"name": "gyro [deg/s]", "unit": "rad/s"}})
    np.testing.assert_array_equal(said["r"][1], GYRO)


@pytest.mark.parametrize(
    ("names", "columns", "words"),
    [
        (
            ("time [sec]", "u"),
            {"t": "time [sec]", "u": "u"},
            r"columns\.t = 'time \[sec\]': the unit 'sec' is not one of s, ms",
        ),
        (("t [sec]", "u"), None, r"columns\.t = 't \[sec\]': the unit 'sec' is not one of s, ms"),
        (("t", "u [degC]"), None, r"columns\.u = 'u \[degC\]': unit = \"degC\" is not one of m/s, mm/s"),
        (
            ("t", "u"),
            {"t": {"name": "t", "unit": "sec"}, "u": "u"},
            r"columns\.t = 't': the unit 'sec' is not one of s",
        ),
    ],
)
def test_a_unit_that_is_not_known_is_told_with_its_column(
    names: tuple[str, str], columns: dict[str, object] | None, words: str
) -> None:
    with pytest.raises(hs.UsageError, match=words):
        hs.Run.from_numpy(dict(zip(names, (T, U), strict=True)), columns=columns)


def test_every_frame_is_read_by_one_function() -> None:
    table = {k: v for k, v in TABLE.items() if k != "note"}
    frames = [pd.DataFrame(table), pl.DataFrame(table), pa.table(table), pd.DataFrame(table).set_index("time")]
    for frame in frames:
        check(hs.Run.from_frame(frame, columns=COLUMNS))
    commands = pd.DataFrame({"t": T[:3], "V1": [1500.0, 1600.0, 1700.0]})
    assert dict(hs.Run.from_frame(commands, units={"V1": "us"}).units) == {"V1": "us"}
    with pytest.raises(hs.UsageError, match="a data frame is expected, not int"):
        hs.Run.from_frame(3)


def test_a_frame_is_guessed_as_init_guesses_a_log() -> None:
    k = np.arange(400)
    speed, heading = 0.5 + 0.3 * np.sin(k / 20.0), np.sin(k / 30.0)
    frame = pd.DataFrame(
        {
            "time_ms": 100 * k,
            "dvl_surge_speed": speed,
            "yaw_deg": np.degrees(heading),
            "gyro_z_dps": np.degrees(np.cos(k / 30.0) / 3.0),
            "thrust_x": 40.0 * np.sin(k / 20.0),
        }
    )
    for given in (frame, pl.DataFrame(frame.to_dict("list"))):
        run = hs.Run.from_frame(given, guess=True, name="dive", kind="free", role="validate")
        assert (run.name, run.role, run.channels) == ("dive", "validate", ("psi", "r", "tau_u", "u"))
        np.testing.assert_allclose(run["u"][0], 0.1 * k, rtol=1e-12)
        np.testing.assert_array_equal(run["u"][1], speed)
        np.testing.assert_allclose(run["psi"][1], heading, rtol=1e-12)
        np.testing.assert_allclose(run["r"][1], np.cos(k / 30.0) / 3.0, rtol=1e-12)
        told = [finding.message for finding in run.findings if finding.code == "K201"]
        assert len(told) == 5
        assert any('"yaw_deg" is psi by its name; deg according to the name' in text for text in told)
    with pytest.raises(hs.UsageError, match="give one of the two"):
        hs.Run.from_frame(frame, columns={"u": "dvl_surge_speed"}, guess=True)
    with pytest.raises(hs.DataError, match="no column of the frame could be recognised"):
        hs.Run.from_frame(pd.DataFrame({"a": ["x", "y"]}), guess=True)


def test_every_guess_at_a_frame_is_told(tmp_path: Path) -> None:
    """Options as well as columns: what stands in `init`'s campaign as a guess at its log is a finding of the run."""
    k = np.arange(400)
    frame = pd.DataFrame(
        {"time": 0.1 * k, "north": np.sin(k / 50.0), "east": np.cos(k / 50.0), "yaw_deg": 0.2 * k, "thrust_x": 1.0 * k}
    )
    frame.loc[::2, "north"] = None
    run = hs.Run.from_frame(frame, guess=True, name="dive")
    told = [finding.message.removeprefix("dive: ") for finding in run.findings if finding.code == "K201"]
    frame.to_csv(tmp_path / "dive.csv", index=False)
    text = hs.init([tmp_path / "dive.csv"])
    log = text.split("\n[log]\n")[1].split("\n[[run]]")[0]
    guessed = [line.removeprefix("# guessed: ") for line in log.splitlines() if line.startswith("# guessed: ")]
    assert told == guessed
    assert any("north and east must be measured independently" in text for text in told)
    assert any(text.startswith('"yaw_deg" is psi') for text in told)


def test_wall_clocks_are_exact_to_the_nanosecond() -> None:
    stamps = np.array("2024-07-01T10:40:00.000000007", dtype="datetime64[ns]") + np.arange(5) * np.timedelta64(
        10**8, "ns"
    )
    columns = {"t": "time", "u": "speed"}
    frame = pd.DataFrame({"time": stamps, "speed": np.arange(5.0)})
    zoned = frame.assign(time=frame["time"].dt.tz_localize("UTC"))
    whole = {"time": stamps.astype(np.int64), "speed": np.arange(5.0)}
    indexed = frame.set_index("time").rename_axis(None)
    runs = [
        hs.Run.from_pandas(frame, columns=columns),
        hs.Run.from_pandas(zoned, columns=columns),
        hs.Run.from_pandas(indexed, columns=columns | {"t": "index"}),
        hs.Run.from_polars(pl.DataFrame(frame.to_dict("series")), columns=columns),
        hs.Run.from_arrow(pa.table(whole | {"time": pa.array(stamps)}), columns=columns),
        hs.Run.from_numpy(whole, columns=columns, time_unit="ns"),
    ]
    for run in runs:
        np.testing.assert_array_equal(run["u"][0], np.arange(5) * 10**8 / 1e9)


def test_missing_values_are_refused_or_no_samples() -> None:
    frames = [
        hs.Run.from_pandas,
        lambda f, **o: hs.Run.from_polars(pl.DataFrame({"t": T[:3], "u": [1.0, None, 3.0]}), **o),
        lambda f, **o: hs.Run.from_arrow(pa.table({"t": T[:3], "u": [1, None, 3]}), **o),
    ]
    frame = pd.DataFrame({"t": T[:3], "u": pd.array([1, None, 3], dtype="Int64")})
    for read in frames:
        with pytest.raises(hs.DataError, match=r"u, sample 2 is nan; missing = 'no_sample'"):
            read(frame)
        run = read(frame, missing="no_sample")
        assert run["u"][0].tolist() == [T[0], T[2]]
        assert run["u"][1].tolist() == [1.0, 3.0]


def test_time_that_goes_back_or_repeats() -> None:
    with pytest.raises(hs.DataError, match=r"sample 3: the time stamp 0\.1 does not follow 0\.1.*duplicates = 'first'"):
        hs.Run.from_numpy({"t": [0.0, 0.1, 0.1, 0.2], "u": [1.0, 2.0, 3.0, 4.0]})
    first = hs.Run.from_numpy({"t": [0.0, 0.1, 0.1, 0.2], "u": [1.0, 2.0, 3.0, 4.0]}, duplicates="first")
    assert first["u"][1].tolist() == [1.0, 2.0, 4.0]
    with pytest.raises(hs.DataError, match="sort = true"):
        hs.Run.from_numpy({"t": [0.0, 0.2, 0.1], "u": [1.0, 2.0, 3.0]})
    assert hs.Run.from_numpy({"t": [0.0, 0.2, 0.1], "u": [1.0, 2.0, 3.0]}, sort=True)["u"][1].tolist() == [
        1.0,
        3.0,
        2.0,
    ]


def test_structs_of_matlab_have_their_own_times(tmp_path: Path) -> None:
    path = tmp_path / "dive.mat"
    dvl = {"t": T[::2], "vel": np.c_[U[::2], GYRO[::2]]}
    scipy.io.savemat(path, {"dvl": dvl, "imu": {"t": T, "gyro": {"z": GYRO}}, "mass": 11.5})
    columns = {
        "u": {"name": "dvl.vel[0]", "time": "dvl.t", "unit": "mm/s"},
        "v": {"name": "dvl.vel[1]", "time": "dvl.t"},
        "r": {"name": "imu.gyro.z", "time": "imu.t"},
    }
    run = hs.Run.from_mat(path, columns=columns)
    np.testing.assert_array_equal(run["u"][0], T[::2])
    np.testing.assert_array_equal(run["u"][1], U[::2] / 1e3)
    np.testing.assert_array_equal(run["r"][0], T)
    with pytest.raises(hs.UsageError, match=r"no time stamps.*dvl\.t"):
        hs.Run.from_mat(path, columns={"u": "dvl.vel[0]"})
    with pytest.raises(hs.DataError, match="r has 40 values for 20 time stamps"):
        hs.Run.from_mat(path, columns={"r": {"name": "imu.gyro.z", "time": "dvl.t"}})


def test_variables_of_xarray_have_the_time_of_their_dimension(tmp_path: Path) -> None:
    variables = {"u": ("t_dvl", U[::2]), "r": ("t_imu", GYRO), "grid": (("t_dvl", "cell"), np.ones((20, 3)))}
    dataset = xr.Dataset(variables, coords={"t_dvl": T[::2], "t_imu": T})
    run = hs.Run.from_xarray(dataset.drop_vars("grid"))
    np.testing.assert_array_equal(run["u"][0], T[::2])
    np.testing.assert_array_equal(run["r"][0], T)
    with pytest.raises(hs.UsageError, match=r"dimensions t_dvl, cell.*\.isel"):
        hs.Run.from_xarray(dataset, columns={"u": "grid"})
    dataset.drop_vars("grid").to_netcdf(tmp_path / "a.nc", engine="scipy")
    same = hs.convert(tmp_path / "a.nc")
    assert {c: (t.tolist(), x.tolist()) for c, (t, x) in same.signals.items()} == {
        c: (t.tolist(), x.tolist()) for c, (t, x) in run.signals.items()
    }


def test_files_that_are_none_are_refused(tmp_path: Path) -> None:
    for end, read in (
        ("parquet", hs.Run.from_parquet),
        ("arrow", hs.Run.from_arrow),
        ("mat", hs.Run.from_mat),
        ("npz", hs.Run.from_numpy),
    ):
        path = tmp_path / f"a.{end}"
        path.write_bytes(b"neither this nor that, and long enough for a header of any format " * 4)
        with pytest.raises(hs.DataError, match=rf"a\.{end}: this file cannot be read"):
            read(path, columns=COLUMNS)
        with pytest.raises(hs.UsageError, match="no such file"):
            read(tmp_path / f"absent.{end}", columns=COLUMNS)
    np.save(tmp_path / "b.npy", U)
    with pytest.raises(hs.DataError, match="named fields"):
        hs.Run.from_numpy(tmp_path / "b.npy")
    (tmp_path / "v73.mat").write_bytes(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM" + b"\x89HDF\r\n\x1a\n" * 20)
    with pytest.raises(hs.DataError, match=r"v73\.mat: this file cannot be read"):
        hs.Run.from_mat(tmp_path / "v73.mat")


@pytest.mark.parametrize(
    ("module", "extra", "call"),
    [
        ("rosbags", "ros", "from_rosbag('a.bag', columns={'u': '/a:b'})"),
        ("mcap", "ros", "from_mcap('a.mcap', columns={'u': '/a:b'})"),
        ("pymavlink", "ardupilot", "from_dataflash('a.bin', columns={'u': 'A:b'})"),
        ("pyulog", "px4", "from_ulog('a.ulg', columns={'u': 'a:b'})"),
        ("scipy", "mat", "from_mat('a.mat')"),
        ("pyarrow", "parquet", "from_parquet('a.parquet')"),
        ("pyarrow", "arrow", "from_arrow('a.arrow')"),
        ("h5py", "hdf5", "from_hdf5('a.h5')"),
    ],
)
def test_an_absent_library_is_named_with_its_extra(module: str, extra: str, call: str) -> None:
    code = f"import sys; sys.modules[{module!r}] = None\nimport hydrosysid as hs\nhs.Run.{call}"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert f"need {module}: pip install 'hydrosysid[{extra}]'" in done.stderr
