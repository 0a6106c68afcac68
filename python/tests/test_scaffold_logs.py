"""`init` on logs of other formats: clocks and names of what they become, parameters, modes, fields that are given."""

import json
import struct
import tomllib
from pathlib import Path

import hydrosysid as hs
import numpy as np
import pytest
from hydrosysid._command import run_with
from mcap.writer import Writer as McapWriter
from rosbags.rosbag2 import Writer
from rosbags.typesys import Stores, get_typestore

START = 1_719_830_400_123_456_000
SECOND = 10**9


def write_odometry(path: Path, at: np.ndarray) -> None:
    """A bag with the yaw rate, 0.1 rad/s more at each message; ROS has it positive to port."""
    store = get_typestore(Stores.LATEST)
    kind, vector = store.types["sensor_msgs/msg/Imu"], store.types["geometry_msgs/msg/Vector3"]
    with Writer(path, version=8) as bag:
        topic = bag.add_connection("/imu", kind.__msgtype__, typestore=store)
        for k, ns in enumerate(at.tolist()):
            stamp = store.types["builtin_interfaces/msg/Time"](sec=ns // SECOND, nanosec=ns % SECOND)
            header = store.types["std_msgs/msg/Header"](stamp=stamp, frame_id="base_link")
            turned = store.types["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=0.0, w=1.0)
            zero, nine = vector(0.0, 0.0, 0.0), np.zeros(9)
            imu = kind(header, turned, nine, vector(0.0, 0.0, -0.01 * k), nine, zero, nine)
            bag.write(topic, ns, store.serialize_cdr(imu, kind.__msgtype__))


def write_velocity(path: Path, at: np.ndarray) -> None:
    """A bag with the velocity ahead, 0.01 m/s more at each message, and six pulses that step."""
    store = get_typestore(Stores.LATEST)
    kind, twist = store.types["geometry_msgs/msg/TwistStamped"], store.types["geometry_msgs/msg/Twist"]
    vector = store.types["geometry_msgs/msg/Vector3"]
    with Writer(path, version=8) as bag:
        topic = bag.add_connection("/dvl", kind.__msgtype__, typestore=store)
        many = store.types["std_msgs/msg/UInt16MultiArray"]
        layout = store.types["std_msgs/msg/MultiArrayLayout"]([], 0)
        drives = bag.add_connection("/thruster/pwm", many.__msgtype__, typestore=store)
        for k, ns in enumerate(at.tolist()):
            stamp = store.types["builtin_interfaces/msg/Time"](sec=ns // SECOND, nanosec=ns % SECOND)
            header = store.types["std_msgs/msg/Header"](stamp=stamp, frame_id="dvl")
            said = kind(header, twist(vector(0.01 * k, 0.0, 0.0), vector(0.0, 0.0, 0.0)))
            bag.write(topic, ns, store.serialize_cdr(said, kind.__msgtype__))
            pulses = np.full(6, 1500 + 100 * (k // 10 % 2), dtype=np.uint16)
            bag.write(drives, ns, store.serialize_cdr(many(layout, pulses), many.__msgtype__))


def test_bags_of_one_dive_keep_their_clocks(tmp_path: Path) -> None:
    """The second bag begins 7 s after the first: it stays there."""
    first = START + SECOND // 10 * np.arange(600)
    second = START + 7 * SECOND + SECOND // 5 * np.arange(300)
    write_odometry(tmp_path / "imu", first)
    write_velocity(tmp_path / "dvl", second)
    text = hs.init([tmp_path / "imu", tmp_path / "dvl"], tmp_path / "dive", vehicle="bluerov2")
    tables = tomllib.loads(text)
    assert [len(run.get("file", [])) for run in tables["run"]] == [2], text
    made = [np.genfromtxt(tmp_path / "dive" / f"{name}.csv", delimiter=",", names=True) for name in ("imu", "dvl")]
    # stamps to the nanosecond, but a float of 64 bits holds them to 256 ns
    assert abs(made[1]["t_ns"][0] - made[0]["t_ns"][0] - 7e9) < 512
    lines = (tmp_path / "dive" / "dvl.csv").read_text().splitlines()
    assert lines[1].startswith(f"{START + 7 * SECOND},")
    runs = [hs.Run.from_csv(tmp_path / "dive" / f"{name}.csv", missing="no_sample") for name in ("imu", "dvl")]
    np.testing.assert_array_equal(runs[0]["r"][0], np.arange(600) / 10)
    np.testing.assert_array_equal(runs[1]["u"][0], np.arange(300) / 5)
    (log,) = hs.check(tmp_path / "dive").to_dict()["logs"]
    # the velocity ends 7 s and 299 steps of 0.2 s after the first yaw rate; a wall clock in seconds keeps 0.24 us
    assert abs(log["duration"] - 66.8) < 1e-6, log


def test_what_logs_become_has_a_name_of_its_own(tmp_path: Path) -> None:
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
    t = np.arange(0.0, 20.0, 0.1)
    for k, path in enumerate(("a/dive.npz", "a/dive.npy", "b/dive.npz")):
        columns = {"time": t, "heading": np.sin((0.3 + 0.1 * k) * t)}
        if path.endswith("npz"):
            np.savez(tmp_path / path, **columns)
        else:
            np.save(tmp_path / path, np.rec.fromarrays(list(columns.values()), names=list(columns)))
    place = tmp_path / "out"
    place.mkdir()
    own = "t,u\n0,1\n"
    (place / "dive.csv").write_text(own)
    logs = [tmp_path / path for path in ("a/dive.npz", "a/dive.npy", "b/dive.npz")]
    text = hs.init(logs, place)
    files = [run["file"] for run in tomllib.loads(text)["run"]]
    assert files == ["dive.npz.csv", "dive.npy.csv", "dive.npz.2.csv"]
    for k, file in enumerate(files):
        made = np.genfromtxt(place / file, delimiter=",", names=True)
        np.testing.assert_allclose(made["heading"], np.sin((0.3 + 0.1 * k) * t), atol=1e-12)
    assert (place / "dive.csv").read_text() == own
    # again: what is there holds the same, and is not written a second time
    hs.init(logs, place, force=True)
    assert len(list(place.glob("*.csv"))) == 4


def write_telemetry(path: Path) -> None:
    """ArduSub for 40 s: motor 2 turns the other way and stands at output 5, ALT_HOLD from 10 to 20 s."""
    mavlink = pytest.importorskip("pymavlink.dialects.v20.ardupilotmega")
    link, station = mavlink.MAVLink(None, 1, 1), mavlink.MAVLink(None, 255, 190)
    parameters = {"FRAME_CONFIG": 1.0, "MOT_2_DIRECTION": -1.0} | {f"MOT_{k}_DIRECTION": 1.0 for k in (1, 3, 4, 5, 6)}
    for motor, output in enumerate((1, 5, 3, 4, 2, 6)):
        parameters |= {f"SERVO{output}_FUNCTION": 33.0 + motor, f"SERVO{output}_TRIM": 1500.0}
    # where the output of motor 3 rests, and where that of motor 4 does not
    parameters |= {"SERVO3_TRIM": 1520.0, "SERVO4_TRIM": 1480.0}
    data = b""
    for key, value in parameters.items():
        said = mavlink.MAVLink_param_value_message(key.encode(), value, 9, len(parameters), 0)
        data += struct.pack(">Q", START // 1000) + said.pack(link)
    for k in range(400):
        at = struct.pack(">Q", START // 1000 + 100_000 * k)
        if k % 10 == 0:
            mode = 2 if 100 <= k < 200 else 19
            data += at + mavlink.MAVLink_heartbeat_message(12, 3, 209, mode, 4, 3).pack(link)
            data += at + mavlink.MAVLink_heartbeat_message(6, 8, 192, 0, 4, 3).pack(station)
        angles = (0.0, 0.0, float(np.sin(0.1 * k)), 0.0, 0.0, float(np.cos(0.1 * k)))
        data += at + mavlink.MAVLink_attitude_message(100 * k, *angles).pack(link)
        pulses = [1500 + (60 if k % 40 < 20 else -60)] * 6 + [0] * 10
        if k % 3 == 0:
            pulses[2] = 1520
        if k % 2:
            pulses[2], pulses[3] = 1520, 1500
        data += at + mavlink.MAVLink_servo_output_raw_message(100_000 * k, 0, *pulses[:8]).pack(link)
    path.write_bytes(data)


def test_parameters_and_modes_of_telemetry_are_used(tmp_path: Path) -> None:
    write_telemetry(tmp_path / "dive.tlog")
    text = hs.init([tmp_path / "dive.tlog"], tmp_path / "dive")
    tables = tomllib.loads(text)
    assert "the log's FRAME_CONFIG = 1" in text
    assert [t["span"] for t in tables["thruster"]] == [400.0, -400.0, 400.0, 400.0, 400.0, 400.0]
    assert [t["neutral"] for t in tables["thruster"]] == [1500.0, 1500.0, 1520.0, 1500.0, 1500.0, 1500.0]
    assert "the outputs 1, 5, 3, 4, 2, 6 of SERVO_OUTPUT_RAW, as SERVOn_FUNCTION" in text
    assert "# guessed: 10.0 to 20.0 s: mode ALT_HOLD" in text
    assert "SERVO_OUTPUT_RAW:servo9_raw" not in text
    run = hs.Run.from_csv(tmp_path / "dive" / "dive.csv", missing="no_sample")
    t, steers = run["closed_loop"]
    np.testing.assert_array_equal(steers, ((t >= 10.0) & (t < 20.0)).astype(float))
    assert any(f.code == "K133" for f in hs.check(tmp_path / "dive").warnings)


def test_parameters_and_modes_in_an_mcap_of_blueos(tmp_path: Path) -> None:
    path = tmp_path / "recorder.mcap"
    with path.open("wb") as file:
        writer = McapWriter(file)
        writer.start()
        topics = {}
        for kind in ("ATTITUDE", "SERVO_OUTPUT_RAW", "PARAM_VALUE", "HEARTBEAT"):
            schema = writer.register_schema(kind, "jsonschema", b'{"type": "object"}')
            topics[kind] = writer.register_channel(f"mavlink/1/1/{kind}", "json", schema)

        def say(at: int, kind: str, **fields: object) -> None:
            message = {"header": {"system_id": 1, "component_id": 1}, "message": {"type": kind, **fields}}
            writer.add_message(topics[kind], at, json.dumps(message).encode(), at)

        for name, value in {"FRAME_CONFIG": 2.0, "MOT_1_DIRECTION": -1.0, "SERVO1_FUNCTION": 33.0}.items():
            say(START, "PARAM_VALUE", param_id=list(name.ljust(16, "\0")), param_value=value, param_index=0)
        sub = {"mavtype": {"type": "MAV_TYPE_SUBMARINE"}, "autopilot": {"type": "MAV_AUTOPILOT_ARDUPILOTMEGA"}}
        for k in range(200):
            at = START + SECOND // 10 * k
            say(at, "HEARTBEAT", custom_mode=19 if k < 100 else 0, base_mode={"bits": 209}, **sub)
            say(
                at,
                "ATTITUDE",
                roll=0.0,
                pitch=0.0,
                yaw=float(np.sin(0.1 * k)),
                rollspeed=0.0,
                pitchspeed=0.0,
                yawspeed=0.0,
            )
            say(at, "SERVO_OUTPUT_RAW", servo1_raw=1500 + k % 7)
        writer.finish()
    text = hs.init([path], tmp_path / "dive")
    assert "FRAME_CONFIG = 2 is the frame of this vehicle" in text
    assert text.count("span = -400.0") == 1
    assert "# guessed: 10.0 to 19.9 s: mode STABILIZE" in text


def test_a_field_that_somebody_says_wins(tmp_path: Path) -> None:
    write_telemetry(tmp_path / "dive.tlog")
    place = tmp_path / "dive"
    said = ["--log", 'columns.r = "ATTITUDE:rollspeed"', "--log", 'columns.beat = "HEARTBEAT:custom_mode"']
    assert run_with(["init", str(tmp_path / "dive.tlog"), "-o", str(place), *said, "-q"]) == 0
    run = hs.Run.from_csv(place / "dive.csv", missing="no_sample")
    assert set(run["r"][1].tolist()) == {0.0}
    assert set(run["beat"][1].tolist()) == {2.0, 19.0}
    text = (place / "campaign.toml").read_text(encoding="utf-8")
    assert "HEARTBEAT[255.190]: " in text[text.index("# Not recognised") :]
    words = ["init", str(tmp_path / "dive.tlog"), "-o", str(tmp_path / "other"), "--log", 'columns.r = "GYRO:z"']
    assert run_with(words) == 2


def test_a_csv_is_one_whatever_it_is_called(tmp_path: Path) -> None:
    rows = "".join(f"{0.1 * k:.1f},{np.sin(0.2 * k):.4f}\n" for k in range(40))
    for name in ("dive.bin", "dive.mat"):
        (tmp_path / name).write_text(f"t,u\n{rows}")
        assert run_with(["convert", str(tmp_path / name), "-o", str(tmp_path / f"{name}.csv"), "-q"]) == 0
        assert (tmp_path / f"{name}.csv").read_text().startswith("t [s],u [m/s]\n0.0,0.0\n")
        assert run_with(["init", str(tmp_path / name), "-o", str(tmp_path / f"{name}.dive"), "-q"]) == 0
    # no text, and the mark of no format: the name says what it should have been
    (tmp_path / "zeros.BIN").write_bytes(bytes(200))
    with pytest.raises(hs.DataError, match="not a DataFlash log"):
        hs.convert(tmp_path / "zeros.BIN", columns={"u": "XKF1:VN"})


def columns() -> dict[str, np.ndarray]:
    """A log of a pilot: yaw under two thrusters, commands in steps."""
    t = np.arange(0.0, 30.0, 0.1)
    step = np.sign(np.sin(0.7 * t))
    return {
        "time": t,
        "yaw_deg": np.rad2deg(np.sin(0.4 * t)),
        "yaw_rate": 0.4 * np.cos(0.4 * t),
        "left_pwm": 1500 + 100 * step,
        "right_pwm": 1500 - 100 * step,
    }


@pytest.mark.parametrize("format", ["mat", "parquet", "feather"])
def test_tables_of_other_formats_become_campaigns(tmp_path: Path, format: str) -> None:
    path = tmp_path / f"log.{format}"
    if format == "mat":
        pytest.importorskip("scipy.io").savemat(path, columns())
    else:
        arrow = pytest.importorskip("pyarrow")
        table = arrow.table(columns())
        if format == "parquet":
            pytest.importorskip("pyarrow.parquet").write_table(table, path)
        else:
            pytest.importorskip("pyarrow.feather").write_feather(table, path)
    text = hs.init([path], tmp_path / "dive")
    tables = tomllib.loads(text)
    assert tables["log"]["columns"]["psi"] == {"name": "yaw_deg", "unit": "deg"}
    assert tables["model"]["dofs"] == ["yaw"]
    assert [t["neutral"] for t in tables["thruster"]] == [1500.0, 1500.0]
    assert not hs.check(tmp_path / "dive").errors


def test_a_time_called_t_and_groups_with_clocks_of_their_own_are_kept(tmp_path: Path) -> None:
    """A table whose time is `t`, the usual name; an HDF5 file in which each sensor has its own rate."""
    plain = {("t" if name == "time" else name): values for name, values in columns().items()}
    pytest.importorskip("scipy.io").savemat(tmp_path / "log.mat", plain)
    assert tomllib.loads(hs.init([tmp_path / "log.mat"], tmp_path / "plain"))["model"]["dofs"] == ["yaw"]
    assert not hs.check(tmp_path / "plain").errors
    with pytest.importorskip("h5py").File(tmp_path / "dive.h5", "w") as file:
        file["imu/t"], file["imu/yaw_rate"] = columns()["time"], columns()["yaw_rate"]
        file["imu/yaw_deg"] = columns()["yaw_deg"]
        for name in ("time", "left_pwm", "right_pwm"):
            file[f"cmd/{name}"] = columns()[name][::2]
    text = hs.init([tmp_path / "dive.h5"], tmp_path / "dive")
    assert {file.name for file in (tmp_path / "dive").glob("*.csv")} == {"dive_imu.csv", "dive_cmd.csv"}
    tables = tomllib.loads(text)
    assert (tables["model"]["dofs"], len(tables["thruster"])) == (["yaw"], 2)


def test_a_ulog_becomes_a_campaign(tmp_path: Path) -> None:
    def message(kind: str, payload: bytes) -> bytes:
        return struct.pack("<HB", len(payload), ord(kind)) + payload

    data = b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 100) + message("B", bytes(40))
    data += message("F", b"vehicle_angular_velocity:uint64_t timestamp;float[3] xyz;")
    data += message("F", b"actuator_motors:uint64_t timestamp;float[12] control;")
    data += message("A", struct.pack("<BH", 0, 1) + b"vehicle_angular_velocity")
    data += message("A", struct.pack("<BH", 0, 2) + b"actuator_motors")
    for k in range(300):
        at, rate = 5_000_000 + 100_000 * k, 0.5 * np.sin(0.03 * k)
        data += message("D", struct.pack("<HQ3f", 1, at, 0.0, 0.0, rate))
        data += message("D", struct.pack("<HQ12f", 2, at + 4_000, *[0.2 * np.sign(rate)] * 2, *[float("nan")] * 10))
    (tmp_path / "dive.ulg").write_bytes(data)
    text = hs.init([tmp_path / "dive.ulg"], tmp_path / "dive")
    assert "r is vehicle_angular_velocity" in text
    run = hs.Run.from_csv(tmp_path / "dive" / "dive.csv", missing="no_sample")
    assert {"r", "V1", "V2"} <= set(run.channels)
    assert "V3" not in run.channels
    assert [t["name"] for t in tomllib.loads(text)["thruster"]] == ["1", "2"]
