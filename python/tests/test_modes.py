"""Modes of ArduPilot: one number means different modes of different vehicles."""

from pathlib import Path

import hydrosysid as hs
import pytest
from dataflash_bytes import Dataflash
from hydrosysid._formats.autopilot import Told, _heartbeat, closed_loop, told
from hydrosysid._formats.dataflash import open_dataflash

SAYS = {"MSG": ("QZ", "TimeUS,Message"), "VER": ("QZ", "TimeUS,FWS")}


def modes(path: Path, kind: str, words: str) -> Told:
    """What is told of a log with the modes 0 from 1 s and 10 from 2 s on, and this message of the vehicle."""
    log = Dataflash(SAYS, {})
    log.add("MSG", 900_000, "Frame: UNKNOWN")
    if kind:
        log.add(kind, 1_000_000, words)
    log.add("MODE", 1_000_000, 0, 0, 1)
    log.add("MODE", 2_000_000, 10, 10, 1)
    path.write_bytes(log.data)
    return told(path, open_dataflash(path), "ardupilot")


@pytest.mark.parametrize(
    ("kind", "words", "names", "steers"),
    [
        ("MSG", "ArduRover V4.2.3 (9e8a2b8c)", ["MANUAL", "AUTO"], ["AUTO"]),
        ("VER", "ArduRover V4.5.0", ["MANUAL", "AUTO"], ["AUTO"]),
        ("MSG", "APM:Rover v3.1.0 (8e53b4b6)", ["MANUAL", "AUTO"], ["AUTO"]),
        ("MSG", "ArduSub V4.1.0 (f2af3c7e)", ["STABILIZE", "number 10"], ["STABILIZE"]),
        ("MSG", "ArduCopter V4.3.0 (00112233)", ["number 0", "number 10"], []),
    ],
)
def test_modes_are_those_of_the_vehicle(
    tmp_path: Path, kind: str, words: str, names: list[str], steers: list[str]
) -> None:
    said = modes(tmp_path / "a.BIN", kind, words)
    assert [mode for _, mode in said.modes] == names
    assert [mode for _, _, mode in closed_loop(said.modes, 3_000_000_000)] == steers


def test_a_log_that_names_no_vehicle_says_what_it_is_taken_for(tmp_path: Path) -> None:
    said = modes(tmp_path / "a.BIN", "", "")
    assert [mode for _, mode in said.modes] == ["STABILIZE", "number 10"]
    assert said.notes == ["no message names the vehicle: its modes are read as those of ArduSub"]
    assert modes(tmp_path / "b.BIN", "MSG", "ArduSub V4.1.0 (f2af3c7e)").notes == []


def test_modes_of_a_rover_steer_where_init_says_so(tmp_path: Path) -> None:
    log = Dataflash(SAYS | {"RCOU": ("QHH", "TimeUS,C1,C3"), "ATT": ("Qff", "TimeUS,Roll,Yaw")}, {})
    log.add("MSG", 1_000_000, "ArduRover V4.2.3 (9e8a2b8c)")
    log.add("PARM", 1_000_000, "SERVO1_FUNCTION", 73.0, 0.0)
    log.add("MODE", 1_000_000, 0, 0, 1)
    for k in range(200):
        at = 1_000_000 + 100_000 * k
        log.add("RCOU", at, 1500 + 100 * (k // 20 % 2), 1500)
        log.add("ATT", at, 0.0, float(k % 360))
    (tmp_path / "boat.BIN").write_bytes(log.data)
    text = hs.init([tmp_path / "boat.BIN"], tmp_path / "boat")
    assert "closed_loop" not in text
    assert "STABILIZE" not in text


@pytest.mark.parametrize(
    ("vehicle", "name"),
    [(11, "MANUAL"), ({"type": "MAV_TYPE_GROUND_ROVER"}, "MANUAL"), (12, "STABILIZE"), (2, None)],
)
def test_modes_of_heartbeats_are_those_of_the_vehicle(vehicle: object, name: str | None) -> None:
    made = Told()
    _heartbeat(made, 5, {"mavtype": vehicle, "autopilot": 3, "custom_mode": 0})
    assert made.modes == ([] if name is None else [(5, name)])
