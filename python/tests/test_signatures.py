"""Logs known by their first bytes, telemetry logs, and bags with a topic that nobody can decode."""

import shutil
import sqlite3
import struct
import zipfile
from pathlib import Path

import hydrosysid as hs
import numpy as np
import pytest
from hydrosysid._command import run_with

START = 1_719_830_400_123_456


def write_telemetry(path: Path) -> np.ndarray:
    """ATTITUDE of the autopilot at 10 Hz beside heartbeats of a ground station; returns roll as written."""
    mavlink = pytest.importorskip("pymavlink.dialects.v20.ardupilotmega")
    roll = np.float32(0.1) * np.arange(30, dtype=np.float32)
    autopilot, station = mavlink.MAVLink(None, 1, 1), mavlink.MAVLink(None, 255, 190)
    data = b""
    for k, value in enumerate(roll):
        attitude = mavlink.MAVLink_attitude_message(100 * k, float(value), 0.0, 1.0, 0.0, 0.0, 0.2)
        beat = mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3)
        data += struct.pack(">Q", START + 100_000 * k) + attitude.pack(autopilot)
        data += struct.pack(">Q", START + 100_000 * k + 500) + beat.pack(station)
    path.write_bytes(data)
    return roll


@pytest.mark.parametrize("name", ["dive.tlog", "dive.csv"])
def test_a_telemetry_log_is_read_whatever_its_name(tmp_path: Path, name: str) -> None:
    roll = write_telemetry(tmp_path / name)
    run = hs.convert(tmp_path / name, columns={"phi": "ATTITUDE:roll", "r": "ATTITUDE:yawspeed"})
    np.testing.assert_array_equal(run["phi"][1], roll.astype(float))
    np.testing.assert_array_equal(run["phi"][0], np.arange(30) / 10.0)
    assert any("2024-07-01T10:40:00.123456" in f.message for f in run.findings)
    same = hs.Run.from_tlog(tmp_path / name, columns={"phi": "ATTITUDE:roll"})
    np.testing.assert_array_equal(same["phi"], run["phi"])
    station = hs.convert(tmp_path / name, columns={"beat": "HEARTBEAT[255.190]:type"})
    assert set(station["beat"][1].tolist()) == {6.0}


def test_no_telemetry_log_is_refused(tmp_path: Path) -> None:
    pytest.importorskip("pymavlink.mavutil")
    path = tmp_path / "a.tlog"
    path.write_bytes(b"")
    with pytest.raises(hs.DataError, match="no MAVLink message"):
        hs.convert(path, columns={"u": "ATTITUDE:roll"})


@pytest.mark.parametrize(
    ("begin", "told"),
    [
        (b"\xa3\x95\x80\x80", "ArduPilot DataFlash log"),
        (b"ULog\x01\x12\x35\x01", "PX4 ULog"),
        (b"\x89MCAP0\r\n", "MCAP log"),
        (b"#ROSBAG V2.0\n", "ROS 1 bag"),
        (struct.pack(">Q", START) + b"\xfd\x09\x00\x00", "MAVLink telemetry log"),
    ],
)
def test_a_binary_log_is_named_and_not_to_be_cut(
    tmp_path: Path, begin: bytes, told: str, capfd: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "dive.csv"
    path.write_bytes(begin + bytes(200))
    # a file where there is anything to write, an error where there is nothing
    written = tmp_path / "campaign.toml"
    assert (run_with(["init", str(path), "-o", str(written)]) == 0) == written.exists()
    capfd.readouterr()
    assert run_with(["check", str(path)]) != 0
    out = "".join(capfd.readouterr())
    said = " ".join(out.split())
    assert told in said, out
    assert "hydrosysid init" in said, out
    assert "cut these bytes" not in said, out


def test_the_command_converts_by_first_bytes(tmp_path: Path) -> None:
    write_telemetry(tmp_path / "dive.tlog")
    shutil.move(tmp_path / "dive.tlog", tmp_path / "dive.dat")
    (tmp_path / "map.toml").write_text('columns = { phi = "ATTITUDE:roll" }\n')
    out = tmp_path / "dive.csv"
    assert run_with(["convert", str(tmp_path / "dive.dat"), "--map", str(tmp_path / "map.toml"), "-o", str(out)]) == 0
    assert out.read_text().startswith("t")


def test_a_bag_with_a_topic_of_an_unknown_type_is_read(tmp_path: Path) -> None:
    rosbags = pytest.importorskip("rosbags.rosbag2")
    typesys = pytest.importorskip("rosbags.typesys")
    store = typesys.get_typestore(typesys.Stores.LATEST)
    store.register(typesys.get_types_from_msg("float64 depth\n", "lab_msgs/msg/Depth"))
    path = tmp_path / "dive"
    with rosbags.Writer(path, version=8) as bag:
        twist = store.types["geometry_msgs/msg/Twist"]
        vector = store.types["geometry_msgs/msg/Vector3"]
        velocity = bag.add_connection("/velocity", twist.__msgtype__, typestore=store)
        depth = bag.add_connection("/depth", "lab_msgs/msg/Depth", typestore=store)
        for k in range(5):
            at = START * 1000 + 10**8 * k
            message = twist(vector(0.1 * k, 0.0, 0.0), vector(0.0, 0.0, 0.0))
            bag.write(velocity, at, store.serialize_cdr(message, twist.__msgtype__))
            own = store.types["lab_msgs/msg/Depth"](1.0)
            bag.write(depth, at, store.serialize_cdr(own, "lab_msgs/msg/Depth"))
    # as a recording of an earlier ROS 2, which holds no definitions
    with sqlite3.connect(next(path.glob("*.db3"))) as log:
        log.execute("DELETE FROM message_definitions")
    log.close()
    run = hs.Run.from_rosbag(next(path.glob("*.db3")), columns={"u": "/velocity:linear.x"})
    np.testing.assert_allclose(run["u"][1], 0.1 * np.arange(5))
    told = [f.message for f in run.findings if f.code == "L215"]
    assert told, run.findings
    assert "/depth" in told[0]
    with pytest.raises(hs.DataError, match=r"/depth cannot be read|no topic of this bag"):
        hs.Run.from_rosbag(next(path.glob("*.db3")), columns={"z": "/depth:depth"})


def test_a_numpy_archive_is_read_whatever_its_name(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    t = np.arange(200) / 10.0
    whole = {"t": t, "u": np.sin(t), "tau_u": 40.0 * np.cos(t)}
    path = tmp_path / "renamed.log"
    with path.open("wb") as file:
        np.savez(file, **whole)
    columns = {name: name for name in whole}
    np.testing.assert_array_equal(hs.convert(path, columns=columns)["u"][1], whole["u"])
    out = tmp_path / "out.csv"
    options = ["--log", 'columns = { t = "t", u = "u", tau_u = "tau_u" }']
    assert run_with(["convert", str(path), *options, "-o", str(out)]) == 0, capfd.readouterr()
    assert out.read_text().startswith("t")
    assert run_with(["init", str(path), "-o", str(tmp_path / "made")]) == 0, capfd.readouterr()
    assert (tmp_path / "made" / "campaign.toml").exists()
    # another zip is none
    with zipfile.ZipFile(path, "w") as other:
        other.writestr("notes.txt", "none")
    with pytest.raises(hs.DataError, match="zip"):
        hs.convert(path, columns=columns)


@pytest.mark.parametrize("block", [0, 512, 4096])
def test_an_hdf5_file_with_a_block_of_the_users_own_is_read_whatever_its_name(
    tmp_path: Path, block: int, capfd: pytest.CaptureFixture[str]
) -> None:
    h5py = pytest.importorskip("h5py")
    path = tmp_path / "dive.log"
    t = np.arange(20) / 10.0
    with h5py.File(path, "w", userblock_size=block) as file:
        file["t"], file["u"] = t, np.sin(t)
    if block:
        with path.open("r+b") as file:
            file.write(b"pool test 7\n" * 20)
    np.testing.assert_array_equal(hs.convert(path, columns={"t": "t", "u": "u"})["u"][1], np.sin(t))
    assert run_with(["check", str(path)]) != 0
    assert "HDF5 file" in " ".join("".join(capfd.readouterr()).split())


FORMATS_OF_MESSAGES = (
    "FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns\nFMT, 131, 19, RCOU, QHH, TimeUS,C1,C2\n"
)


@pytest.mark.parametrize(
    ("before", "blank"), [("", " "), ("", ""), ("\n", " "), ("\ufeff", " "), ("\ufeff", ""), ("\ufeff\n", " ")]
)
def test_dataflash_as_text_is_known_however_it_begins(
    tmp_path: Path, before: str, blank: str, capfd: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("pymavlink.DFReader")
    path = tmp_path / "dive.csv"
    rows = "".join(f"RCOU, {10**6 + 20_000 * k}, {1500 + k}, 1100\n" for k in range(9))
    path.write_text(before + (FORMATS_OF_MESSAGES + rows).replace(", ", f",{blank}"), encoding="utf-8")
    run = hs.convert(path, columns={"V1": {"name": "RCOU:C1", "unit": "us"}})
    assert run["V1"][1].tolist() == [1500.0 + k for k in range(9)]
    assert run_with(["check", str(path)]) != 0
    said = " ".join("".join(capfd.readouterr()).split())
    assert "DataFlash log in its text form" in said, said
