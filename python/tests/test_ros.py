"""Bags of ROS 1 and ROS 2, and MCAP, written by the formats' own writers and read back bit for bit."""

import json
from pathlib import Path
from typing import Any

import hydrosysid as hs
import numpy as np
import pytest
from mcap.writer import Writer as McapWriter
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

START = 1_719_830_400_123_456_789
"""A wall clock in ns, which a 64-bit float cannot hold."""
DVL = """std_msgs/Header header
geometry_msgs/Vector3 velocity
bool velocity_valid
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
================================================================================
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
"""
TWIST, ODOMETRY = "geometry_msgs/msg/TwistStamped", "nav_msgs/msg/Odometry"
MAP = {
    "u": "/dvl:twist.linear.x",
    "v": "/dvl:twist.linear.y",
    "r": {"name": "/dvl:twist.angular.z", "scale": 0.5},
    "x": "/odom:pose.pose.position.x",
    "y": "/odom:pose.pose.position.y",
    "psi": "/odom:pose.pose.orientation.yaw",
}
RNG = np.random.default_rng(5)
DVL_NS = START + np.arange(20) * 125_000_000
ODOMETRY_NS = START + 7_000_003 + np.arange(31) * 80_000_000
VELOCITY, RATE = RNG.standard_normal((20, 3)), RNG.standard_normal(20)
POSITION, YAW = RNG.standard_normal((31, 3)), np.linspace(-1.0, 2.5, 31)


def messages(store: Any, ros1: bool) -> list[tuple[str, str, int, Any]]:
    """Topic, type, time of the recording (11 ms late) and message."""
    kinds = store.types
    sequence = {"seq": 0} if ros1 else {}

    def header(ns: int) -> Any:
        stamp = kinds["builtin_interfaces/msg/Time"](sec=int(ns // 10**9), nanosec=int(ns % 10**9))
        return kinds["std_msgs/msg/Header"](stamp=stamp, frame_id="base_link", **sequence)

    def vector(values: Any) -> Any:
        return kinds["geometry_msgs/msg/Vector3"](*(float(x) for x in values))

    twist = kinds["geometry_msgs/msg/Twist"]
    made = []
    for ns, velocity, rate in zip(DVL_NS.tolist(), VELOCITY, RATE, strict=True):
        said = kinds[TWIST](header=header(ns), twist=twist(vector(velocity), vector([0.0, 0.0, rate])))
        made.append(("/dvl", TWIST, ns + 11_000_000, said))
    covariance = np.zeros(36)
    for ns, place, yaw in zip(ODOMETRY_NS.tolist(), POSITION, YAW.tolist(), strict=True):
        turned = kinds["geometry_msgs/msg/Quaternion"](0.0, 0.0, float(np.sin(yaw / 2)), float(np.cos(yaw / 2)))
        pose = kinds["geometry_msgs/msg/Pose"](kinds["geometry_msgs/msg/Point"](*map(float, place)), turned)
        said = kinds[ODOMETRY](
            header=header(ns),
            child_frame_id="base_link",
            pose=kinds["geometry_msgs/msg/PoseWithCovariance"](pose, covariance),
            twist=kinds["geometry_msgs/msg/TwistWithCovariance"](twist(vector([0] * 3), vector([0] * 3)), covariance),
        )
        made.append(("/odom", ODOMETRY, ns + 11_000_000, said))
    return sorted(made, key=lambda m: m[2])


def write_bag(folder: Path, kind: str) -> Path:
    ros1 = kind == "ros1"
    store = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_HUMBLE)
    path = folder / ("bag.bag" if ros1 else "bag")
    plugin = StoragePlugin.MCAP if kind == "mcap" else StoragePlugin.SQLITE3
    with Writer1(path) if ros1 else Writer2(path, version=9, storage_plugin=plugin) as bag:
        connections: dict[str, Any] = {}
        for topic, msgtype, at, message in messages(store, ros1):
            if topic not in connections:
                connections[topic] = bag.add_connection(topic, msgtype, typestore=store)
            raw = store.serialize_ros1(message, msgtype) if ros1 else store.serialize_cdr(message, msgtype)
            bag.write(connections[topic], at, raw)
    return path


def check(run: hs.Run, late: float = 0.0) -> None:
    """Each sensor at its own instants; forward-port-up and east-north-up turned; bits as they were written."""
    np.testing.assert_array_equal(run["u"][0], (DVL_NS - DVL_NS[0]) / 1e9 + late)
    np.testing.assert_array_equal(run["x"][0], (ODOMETRY_NS - DVL_NS[0]) / 1e9 + late)
    np.testing.assert_array_equal(run["u"][1], VELOCITY[:, 0])
    np.testing.assert_array_equal(run["v"][1], -VELOCITY[:, 1])
    np.testing.assert_array_equal(run["r"][1], -0.5 * RATE)
    # north is the second axis of east-north-up
    np.testing.assert_array_equal(run["x"][1], POSITION[:, 1])
    np.testing.assert_array_equal(run["y"][1], POSITION[:, 0])
    # sine, cosine and arctangent, each to a rounding or two
    np.testing.assert_allclose(run["psi"][1], np.pi / 2 - YAW, atol=1e-15)


@pytest.mark.parametrize("kind", ["ros1", "sqlite", "mcap"])
def test_bags(tmp_path: Path, kind: str) -> None:
    path = write_bag(tmp_path, kind)
    frames = {"body_frame": "flu", "earth_frame": "enu"}
    check(hs.Run.from_rosbag(path, columns=MAP, **frames))
    late = hs.Run.from_rosbag(path, columns=MAP, clock="log", **frames)
    check(late)
    assert any("2024-07-01T10:40:00.134456" in f.message for f in late.findings)
    if kind == "sqlite":
        check(hs.Run.from_rosbag(next(path.glob("*.db3")), columns=MAP, **frames))
    if kind == "mcap":
        check(hs.Run.from_mcap(next(path.glob("*.mcap")), columns=MAP, **frames))


def test_the_clock_and_the_origin_are_said(tmp_path: Path) -> None:
    run = hs.Run.from_rosbag(write_bag(tmp_path, "sqlite"), columns={"u": MAP["u"]})
    told = {finding.code: finding.message for finding in run.findings}
    assert "headers" in told["L211"]
    assert "2024-07-01T10:40:00.123456789" in told["L212"]
    assert hs.explain("L212")[0]["severity"] == "note"


def test_an_mcap_of_a_dvl_leaves_out_what_is_not_valid(tmp_path: Path) -> None:
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(DVL, "dvl_msgs/msg/DVL"))
    kinds = store.types
    path = tmp_path / "dvl.mcap"
    with path.open("wb") as file:
        writer = McapWriter(file)
        writer.start(profile="ros2", library="test")
        schema = writer.register_schema("dvl_msgs/msg/DVL", "ros2msg", DVL.encode())
        channel = writer.register_channel("/dvl/data", "cdr", schema)
        for k, ns in enumerate(DVL_NS.tolist()):
            stamp = kinds["builtin_interfaces/msg/Time"](sec=ns // 10**9, nanosec=ns % 10**9)
            bad = k % 5 == 3
            velocity = kinds["geometry_msgs/msg/Vector3"](*([-32.768] * 3 if bad else VELOCITY[k].tolist()))
            header = kinds["std_msgs/msg/Header"](stamp=stamp, frame_id="dvl")
            raw = store.serialize_cdr(kinds["dvl_msgs/msg/DVL"](header, velocity, not bad), "dvl_msgs/msg/DVL")
            writer.add_message(channel, ns, bytes(raw), ns)
        writer.finish()
    columns = {
        c: {"name": f"/dvl/data:velocity.{a}", "valid": "velocity_valid"} for c, a in zip("uvw", "xyz", strict=True)
    }
    run = hs.Run.from_mcap(path, columns=columns)
    good = np.arange(20) % 5 != 3
    np.testing.assert_array_equal(run["w"][1], VELOCITY[good, 2])
    np.testing.assert_array_equal(run["w"][0], ((DVL_NS - START) / 1e9)[good])
    assert any(f.code == "L213" and "4 of 20" in f.message for f in run.findings)
    check_same = hs.Run.from_rosbag(path, columns=columns)
    assert {c: run[c][1].tolist() for c in "uvw"} == {c: check_same[c][1].tolist() for c in "uvw"}


def test_an_mcap_of_json(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    with path.open("wb") as file:
        writer = McapWriter(file)
        writer.start()
        schema = writer.register_schema("thrust", "jsonschema", b'{"type": "object"}')
        channel = writer.register_channel("/thrust", "json", schema)
        for k in range(5):
            writer.add_message(channel, k * 10**8, json.dumps({"pwm": [1500 + k, 1100], "on": True}).encode(), 0)
        writer.finish()
    run = hs.Run.from_mcap(path, columns={"V1": {"name": "/thrust:pwm[0]", "unit": "us"}})
    assert run["V1"][1].tolist() == [1500.0, 1501.0, 1502.0, 1503.0, 1504.0]
    assert run["V1"][0].tolist() == [0.0, 0.1, 0.2, 0.3, 0.4]


def test_a_topic_of_an_unknown_type_is_left_out_and_named(tmp_path: Path) -> None:
    path = tmp_path / "mixed.mcap"
    with path.open("wb") as file:
        writer = McapWriter(file)
        writer.start()
        schema = writer.register_schema("any", "jsonschema", b"{}")
        known = writer.register_channel("/thrust", "json", schema)
        other = writer.register_channel("/secret", "protobuf", schema)
        for k in range(5):
            writer.add_message(other, START + k * 10**8, b"\x00\x01", START + k * 10**8)
            data = json.dumps({"pwm": [1500 + k, 1500]}).encode()
            writer.add_message(known, START + k * 10**8, data, START + k * 10**8)
        writer.finish()
    run = hs.Run.from_mcap(path, columns={"V1": {"name": "/thrust:pwm[0]", "unit": "us"}})
    assert run["V1"][1].tolist() == [1500.0 + k for k in range(5)]
    assert any(f.code == "L215" and "/secret" in f.message for f in run.findings), [f.message for f in run.findings]


def test_what_is_not_there_is_named(tmp_path: Path) -> None:
    bag = write_bag(tmp_path, "sqlite")
    with pytest.raises(hs.UsageError, match=r"/dvl:twist\.linear\.x"):
        hs.Run.from_rosbag(bag)
    with pytest.raises(hs.UsageError, match=r"columns\.u = '/dvk:twist\.linear\.x' is not there"):
        hs.Run.from_rosbag(bag, columns={"u": "/dvk:twist.linear.x"})
    with pytest.raises(hs.UsageError, match=r"/dvl has no field 'twist\.x'"):
        hs.Run.from_rosbag(bag, columns={"u": "/dvl:twist.x"})
    with pytest.raises(hs.UsageError, match='unit = "km/h" is not one of m/s, mm/s, cm/s, kn'):
        hs.Run.from_rosbag(bag, columns={"u": {"name": "/dvl:twist.linear.x", "unit": "km/h"}})
    with pytest.raises(hs.UsageError, match="scale = 0 must be finite and not 0"):
        hs.Run.from_rosbag(bag, columns={"u": {"name": "/dvl:twist.linear.x", "scale": 0.0}})
    with pytest.raises(hs.UsageError, match="unknown key `bodyframe`, did you mean `body_frame`"):
        hs.Run.from_rosbag(bag, columns=MAP, bodyframe="flu")
    broken = tmp_path / "broken.mcap"
    broken.write_bytes(b"\x89MCAP0\r\n and no more")
    with pytest.raises(hs.DataError, match=r"broken\.mcap"):
        hs.Run.from_mcap(broken, columns=MAP)
    with pytest.raises(hs.DataError, match=r"broken\.mcap"):
        hs.Run.from_rosbag(broken, columns=MAP)
    with pytest.raises(hs.UsageError, match="no such"):
        hs.Run.from_rosbag(tmp_path / "absent.bag", columns=MAP)
