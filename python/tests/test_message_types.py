"""Types of ROS messages that a log does not define: taught by a ``.msg`` file, known beforehand, or left out."""

import json
import sqlite3
from pathlib import Path
from typing import Any

import hydrosysid as hs
import numpy as np
import pytest
from hydrosysid._command import run_with
from hydrosysid._formats.ros_definitions import DEFINITIONS
from hydrosysid._formats.ros_types import RosTypes
from mcap.writer import Writer as McapWriter
from rosbags.rosbag2 import Reader, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

START = 1_719_830_400_123_456_000
AT = START + 10**8 * np.arange(6)
DEPTH = "std_msgs/Header header\nfloat64 depth\nCell[2] cells\n"
CELL = "float32 pressure\n"


def header(store: Any, ns: int) -> Any:
    stamp = store.types["builtin_interfaces/msg/Time"](sec=int(ns // 10**9), nanosec=int(ns % 10**9))
    return store.types["std_msgs/msg/Header"](stamp=stamp, frame_id="base_link")


def without_definitions(folder: Path) -> Path:
    """The database of a bag, as a ROS 2 before Iron wrote it."""
    path = next(folder.glob("*.db3"))
    with sqlite3.connect(path) as log:
        log.execute("DELETE FROM message_definitions")
    log.close()
    return path


def write_depths(folder: Path) -> Path:
    store = get_typestore(Stores.LATEST)
    store.register(get_types_from_msg(DEPTH, "lab_msgs/msg/Depth") | get_types_from_msg(CELL, "lab_msgs/msg/Cell"))
    cell = store.types["lab_msgs/msg/Cell"]
    with Writer(folder / "dive", version=8) as bag:
        topic = bag.add_connection("/depth", "lab_msgs/msg/Depth", typestore=store)
        for k, at in enumerate(AT.tolist()):
            cells = [cell(np.float32(k)), cell(np.float32(2 * k))]
            message = store.types["lab_msgs/msg/Depth"](header(store, at), 0.5 * k, cells)
            bag.write(topic, at + 10**6, store.serialize_cdr(message, "lab_msgs/msg/Depth"))
    return without_definitions(folder / "dive")


def test_a_type_is_taught_by_its_file(tmp_path: Path) -> None:
    bag = write_depths(tmp_path)
    place = tmp_path / "lab_msgs" / "msg"
    place.mkdir(parents=True)
    (place / "Depth.msg").write_text(DEPTH)
    columns = {"z": "/depth:depth", "p2": "/depth:cells[1].pressure"}
    with pytest.raises(hs.DataError, match=r"provide it with --msg Depth\.msg"):
        hs.Run.from_rosbag(bag, columns=columns)
    with pytest.raises(hs.DataError, match=r"lab_msgs/msg/Cell, which is not known: provide it with --msg, too"):
        hs.Run.from_rosbag(bag, columns=columns, msg=place / "Depth.msg")
    (place / "Cell.msg").write_text(CELL)
    for msg in (place, [place / "Depth.msg", place / "Cell.msg"], str(tmp_path)):
        run = hs.Run.from_rosbag(bag, columns=columns, msg=msg)
        assert run["z"][1].tolist() == [0.5 * k for k in range(6)]
        assert run["p2"][1].tolist() == [2.0 * k for k in range(6)]
    # a file outside a folder `msg` stands for the type of its name in any package
    (tmp_path / "Depth.msg").write_text(DEPTH)
    (tmp_path / "Cell.msg").write_text(CELL)
    loose = hs.convert(bag, columns=columns, msg=[tmp_path / "Depth.msg", tmp_path / "Cell.msg"])
    assert loose["z"][1].tolist() == run["z"][1].tolist()
    with pytest.raises(hs.UsageError, match="there is no such message definition"):
        hs.convert(bag, columns=columns, msg="absent.msg")
    (place / "Depth.msg").write_text("float64 64depth!\n")
    with pytest.raises(hs.DataError, match="the definition of lab_msgs/msg/Depth cannot be read"):
        hs.convert(bag, columns=columns, msg=place)


def test_the_command_and_the_map_teach_types(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bag = write_depths(tmp_path)
    (tmp_path / "Depth.msg").write_text(DEPTH)
    (tmp_path / "Cell.msg").write_text(CELL)
    (tmp_path / "map.toml").write_text('columns = { z = "/depth:depth" }\n')
    words = ["convert", str(bag), "--map", str(tmp_path / "map.toml")]
    assert run_with([*words, "-o", str(tmp_path / "a.csv")]) == 1
    assert "--msg Depth.msg" in capsys.readouterr().err
    msg = ["--msg", str(tmp_path / "Depth.msg"), "--msg", str(tmp_path / "Cell.msg")]
    assert run_with([*words, *msg, "-o", str(tmp_path / "a.csv")]) == 0
    # in a map, beside the map
    (tmp_path / "map.toml").write_text('msg = ["Depth.msg", "Cell.msg"]\ncolumns = { z = "/depth:depth" }\n')
    assert run_with([*words, "-o", str(tmp_path / "b.csv")]) == 0
    assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()
    assert run_with(["init", str(bag), *msg, "-o", str(tmp_path / "campaign"), "-q"]) == 0
    assert 'name = "z"' in (tmp_path / "campaign" / "campaign.toml").read_text() or (
        "z" in (tmp_path / "campaign" / f"{bag.stem}.csv").read_text().splitlines()[0]
    )


@pytest.mark.parametrize("layout", [0, 1, 2])
def test_reports_of_a_dvl_are_known_in_every_layout(tmp_path: Path, layout: int) -> None:
    """Water Linked's report as its drivers have released it; velocities that it calls not valid are left out."""
    store = get_typestore(Stores.LATEST)
    store.register(
        get_types_from_msg(DEFINITIONS["dvl_msgs/msg/DVL"][layout], "dvl_msgs/msg/DVL")
        | get_types_from_msg(DEFINITIONS["dvl_msgs/msg/DVLBeam"][0], "dvl_msgs/msg/DVLBeam")
    )
    vector, beam = store.types["geometry_msgs/msg/Vector3"], store.types["dvl_msgs/msg/DVLBeam"]
    speeds = np.random.default_rng(layout).standard_normal((6, 3))
    with Writer(tmp_path / "dive", version=8) as bag:
        topic = bag.add_connection("/dvl/data", "dvl_msgs/msg/DVL", typestore=store)
        for k, at in enumerate(AT.tolist()):
            beams = [beam(n, 0.1, 2.0, -30.0, -80.0, True) for n in range(4)]
            body: dict[str, Any] = dict(header=header(store, at), time=66.0, velocity=vector(*speeds[k].tolist()))
            body |= dict(fom=0.002, altitude=2.0, beams=beams, velocity_valid=k != 2, status=0, form="json_v3")
            if layout > 0:
                body["covariance"] = np.zeros(9)
            if layout > 1:
                body |= dict(time_of_validity=at // 1000, time_of_transmission=at // 1000 + 9)
            message = store.types["dvl_msgs/msg/DVL"](**body)
            bag.write(topic, at, store.serialize_cdr(message, "dvl_msgs/msg/DVL"))
    path = without_definitions(tmp_path / "dive")
    text = hs.init([path], tmp_path / "campaign")
    assert "valid velocity_valid" in text
    made = hs.Run.from_csv(tmp_path / "campaign" / f"{path.stem}.csv", missing="no_sample")
    good = np.arange(6) != 2
    # x forward, y to starboard, z down: the DVL's own axes, not those of ROS
    np.testing.assert_array_equal(np.c_[made["u"][1], made["v"][1], made["w"][1]], speeds[good])


def test_outputs_of_mavros_are_known(tmp_path: Path) -> None:
    types = RosTypes()
    store = get_typestore(Stores.LATEST)
    store.register(get_types_from_msg(DEFINITIONS["mavros_msgs/msg/RCOut"][0], "mavros_msgs/msg/RCOut"))
    message = store.types["mavros_msgs/msg/RCOut"](header(store, START), np.array([1500, 1620, 1380], dtype=np.uint16))
    raw = store.serialize_cdr(message, "mavros_msgs/msg/RCOut")
    assert types.decoder("mavros_msgs/msg/RCOut")(raw).channels.tolist() == [1500, 1620, 1380]
    with Writer(tmp_path / "dive", version=8) as bag:
        topic = bag.add_connection("/mavros/rc/out", "mavros_msgs/msg/RCOut", typestore=store)
        for at in AT.tolist():
            bag.write(topic, at, raw)
    path = without_definitions(tmp_path / "dive")
    run = hs.Run.from_rosbag(path, columns={"V2": {"name": "/mavros/rc/out:channels[1]", "unit": "us"}}, clock="log")
    assert set(run["V2"][1].tolist()) == {1620.0}


def test_a_bag_of_foxy_is_read_in_the_layouts_of_foxy(tmp_path: Path) -> None:
    """`sensor_msgs/Range` has grown a field since; `/rosout` stands beside it in every recording."""
    store = get_typestore(Stores.ROS2_FOXY)
    kinds = store.types
    with Writer(tmp_path / "dive", version=8) as bag:
        altimeter = bag.add_connection("/altimeter", "sensor_msgs/msg/Range", typestore=store)
        rosout = bag.add_connection("/rosout", "rcl_interfaces/msg/Log", typestore=store)
        for k, at in enumerate(AT.tolist()):
            stamp = header(store, at).stamp
            said = kinds["rcl_interfaces/msg/Log"](stamp, 20, "altimeter", "a ping", "altimeter.cpp", "ping", 12)
            bag.write(rosout, at, store.serialize_cdr(said, "rcl_interfaces/msg/Log"))
            ping = kinds["sensor_msgs/msg/Range"](header(store, at), 1, 0.4, 0.3, 100.0, 2.0 + k)
            bag.write(altimeter, at, store.serialize_cdr(ping, "sensor_msgs/msg/Range"))
    run = hs.Run.from_rosbag(without_definitions(tmp_path / "dive"), columns={"altitude": "/altimeter:range"})
    assert run["altitude"][1].tolist() == [2.0 + k for k in range(6)]
    assert not [f for f in run.findings if f.code == "L215"]


def test_every_known_definition_is_one() -> None:
    """Each layout parses, is made of known types only, and comes back from its own bytes."""
    types = RosTypes()
    for name, layouts in DEFINITIONS.items():
        for text in layouts:
            assert name in types._with_parts(name, text, "cdr").fielddefs


def test_a_topic_whose_definition_cannot_be_read_keeps_no_other_from_being_read(tmp_path: Path) -> None:
    """As service events of Jazzy, whose definitions name what `rosbags` does not parse."""
    path = tmp_path / "dive.mcap"
    store = get_typestore(Stores.LATEST)
    point = store.types["geometry_msgs/msg/Point"]
    with path.open("wb") as file:
        writer = McapWriter(file)
        writer.start(profile="ros2", library="test")
        event = writer.register_schema(
            "lab/srv/Arm_Event", "ros2msg", b"service_msgs/ServiceEventInfo info\nlab/srv/Arm_Request[<=1] request\n"
        )
        known = writer.register_schema("geometry_msgs/msg/Point", "ros2msg", b"float64 x\nfloat64 y\nfloat64 z\n")
        first = writer.register_channel("/arm/_service_event", "cdr", event)
        second = writer.register_channel("/place", "cdr", known)
        for k, at in enumerate(AT.tolist()):
            writer.add_message(first, at, b"\x00\x01\x00\x00\x05", at)
            raw = store.serialize_cdr(point(0.1 * k, 0.0, 0.0), "geometry_msgs/msg/Point")
            writer.add_message(second, at, bytes(raw), at)
        writer.finish()
    for read in (hs.Run.from_mcap, hs.Run.from_rosbag):
        run = read(path, columns={"x": "/place:x"})
        assert run["x"][1].tolist() == [0.1 * k for k in range(6)]
        (told,) = [f for f in run.findings if f.code == "L215"]
        assert "/arm/_service_event" in told.message
        with pytest.raises(hs.DataError, match="/arm/_service_event cannot be read"):
            read(path, columns={"a": "/arm/_service_event:info.event_type"})


def test_a_message_that_is_cut_is_named(tmp_path: Path) -> None:
    store = get_typestore(Stores.LATEST)
    point = store.types["geometry_msgs/msg/Point"]
    with Writer(tmp_path / "dive", version=8) as bag:
        topic = bag.add_connection("/place", "geometry_msgs/msg/Point", typestore=store)
        for k, at in enumerate(AT.tolist()):
            raw = bytes(store.serialize_cdr(point(0.1 * k, 0.0, 0.0), "geometry_msgs/msg/Point"))
            bag.write(topic, at, raw[:9] if k == 4 else raw)
    with pytest.raises(hs.DataError, match=f"/place, message at {AT[4]} ns"):
        hs.Run.from_rosbag(tmp_path / "dive", columns={"x": "/place:x"})


def test_a_bag_is_known_by_its_first_bytes(tmp_path: Path) -> None:
    store = get_typestore(Stores.LATEST)
    point = store.types["geometry_msgs/msg/Point"]
    with Writer(tmp_path / "dive", version=8) as bag:
        topic = bag.add_connection("/place", "geometry_msgs/msg/Point", typestore=store)
        for at in AT.tolist():
            bag.write(topic, at, store.serialize_cdr(point(1.0, 2.0, 3.0), "geometry_msgs/msg/Point"))
    renamed = tmp_path / "dive.dat"
    next((tmp_path / "dive").glob("*.db3")).rename(renamed)
    with pytest.raises(Exception, match="Unrecognized"):
        Reader(renamed)
    assert hs.convert(renamed, columns={"x": "/place:x"})["x"][1].tolist() == [1.0] * 6
    assert hs.Run.from_rosbag(renamed, columns={"x": "/place:x"})["x"][1].tolist() == [1.0] * 6


def test_mavlink_in_an_mcap_of_blueos(tmp_path: Path) -> None:
    """Topics ``mavlink/SYSTEM/COMPONENT/MESSAGE`` of JSON, as mavlink-server publishes them."""
    path = tmp_path / "recorder.mcap"
    with path.open("wb") as file:
        writer = McapWriter(file)
        writer.start()

        def channel(topic: str) -> int:
            schema = writer.register_schema(topic.replace("/", "."), "jsonschema", b'{"type": "object"}')
            return int(writer.register_channel(topic, "json", schema))

        def said(system: int, kind: str, **fields: float) -> bytes:
            head = {"system_id": system, "component_id": 1, "sequence": 7}
            return json.dumps({"header": head, "message": {"type": kind, **fields}}).encode()

        own, station = channel("mavlink/1/1/ATTITUDE"), channel("mavlink/255/190/ATTITUDE")
        servos, place = channel("mavlink/1/1/SERVO_OUTPUT_RAW"), channel("mavlink/1/1/LOCAL_POSITION_NED")
        delta = channel("mavlink/1/197/VISION_POSITION_DELTA")
        for k, at in enumerate((START + 10**8 * np.arange(60)).tolist()):
            angles = {"roll": 0.01, "pitch": -0.02, "yaw": 0.1 * k - 3.0, "yawspeed": 1.0, "rollspeed": 0.0}
            writer.add_message(own, at, said(1, "ATTITUDE", pitchspeed=0.0, **angles), at)
            writer.add_message(station, at, said(255, "ATTITUDE", roll=9.0, pitch=9.0, yaw=9.0), at)
            raw = {f"servo{n}_raw": 1500 + 10 * n + (k % 2) for n in range(1, 7)}
            writer.add_message(servos, at, said(1, "SERVO_OUTPUT_RAW", **raw), at)
            writer.add_message(
                place, at, said(1, "LOCAL_POSITION_NED", x=0.1 * k, y=0.0, z=2.0, vx=1.0, vy=0.0, vz=0.0), at
            )
            writer.add_message(delta, at, said(1, "VISION_POSITION_DELTA", confidence=90.0), at)
        writer.finish()
    text = hs.init([path], tmp_path / "campaign", vehicle="bluerov2")
    assert "a log of BlueOS" in text
    made = hs.Run.from_csv(tmp_path / "campaign" / "recorder.csv", missing="no_sample")
    np.testing.assert_allclose(made["psi"][1], 0.1 * np.arange(60) - 3.0, atol=1e-12)
    assert made["V3"][1].tolist() == [1530.0 + k % 2 for k in range(60)]
    # one metre a second to the north, in axes that yaw, with the little roll and pitch
    yaw = 0.1 * np.arange(60) - 3.0
    np.testing.assert_allclose(made["u"][1], np.cos(-0.02) * np.cos(yaw), atol=1e-12)
