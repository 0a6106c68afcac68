"""`init` on logs as they come off vehicles: formats of autopilots and tables become campaigns, guesses marked."""

import os
import struct
import tomllib
from pathlib import Path

import hydrosysid as hs
import numpy as np
import pytest
from hydrosysid._command import run_with

HEAD = b"\xa3\x95"
FORMATS = {
    "FMT": (128, "BBnNZ", "Type,Length,Name,Format,Columns"),
    "PARM": (129, "QNff", "TimeUS,Name,Value,Default"),
    "MODE": (130, "QMBB", "TimeUS,Mode,ModeNum,Rsn"),
    "RCOU": (131, "QHHHHHH", "TimeUS,C1,C2,C3,C4,C5,C6"),
    "ATT": (132, "Qffffff", "TimeUS,DesRoll,Roll,DesPitch,Pitch,DesYaw,Yaw"),
    "CTUN": (133, "Qff", "TimeUS,ThI,Alt"),
}
CODES = {"B": "B", "H": "H", "Q": "Q", "f": "f", "M": "B", "n": "4s", "N": "16s", "Z": "64s"}
S = np.sqrt(0.5)
MASS, DRAG, INERTIA, TURN = 26.0, 37.0, 0.28, 1.6


def packed(name: str, *values: object) -> bytes:
    number, form, _ = FORMATS[name]
    raw = [v.encode() if isinstance(v, str) else v for v in values]
    return HEAD + bytes([number]) + struct.pack("<" + "".join(CODES[c] for c in form), *raw)


def thrust(pwm: np.ndarray) -> np.ndarray:
    """The T200 of the vehicle files at 16 V, written out."""
    v = (pwm - 1500.0) / 400.0
    w = np.sign(v) * np.maximum(0.0, np.abs(v) - 0.074)
    return np.where(w > 0, 36.3 * w * w + 23.3 * w, -(25.0 * w * w - 20.7 * w))


def write_dive(path: Path, moves: bool) -> None:
    """Heave and yaw of a six-thruster vehicle, 60 s; motor 1 runs the other way; for 10 s ALT_HOLD steers."""
    data = b""
    for name, (number, form, columns) in FORMATS.items():
        size = 3 + struct.calcsize("<" + "".join(CODES[c] for c in form))
        data += packed("FMT", number, size, name, form, columns)
    for key, value in [
        ("FRAME_CONFIG", 1),
        ("MOT_1_DIRECTION", -1),
        *[(f"MOT_{k}_DIRECTION", 1) for k in range(2, 7)],
        *[(f"SERVO{k}_FUNCTION", 32 + k) for k in range(1, 7)],
    ]:
        data += packed("PARM", 1_000_000, key, float(value), 0.0)
    data += packed("MODE", 1_000_000, 19, 19, 1)
    rng = np.random.default_rng(5)
    z, w, psi, r, fine = 1.0, 0.0, 0.5, 0.0, 0.002
    signs = np.array([-1.0, 1.0, 1.0, 1.0, 1.0, 1.0])
    # yaw arm of each horizontal thruster, (x F_y − y F_x)
    arm = S * (0.156 + 0.111) * np.array([1.0, -1.0, -1.0, 1.0])
    for k in range(int(60.0 / fine)):
        t = k * fine
        if k % 50 == 0:
            step = np.floor(t / 2.0)
            turn, dive = (300 * np.sin(1.9 * step), 300 * np.sin(2.7 * step + 1)) if moves else (0.0, 0.0)
            wanted = np.array([turn, -turn, -turn, turn, dive, dive])
            pwm = np.round(1500 + signs * wanted)
            at = 1_000_000 + round(t * 1e6)
            data += packed("RCOU", at, *[int(x) for x in pwm])
            tilt, yaw = 0.1 * rng.standard_normal(2), np.rad2deg(psi) % 360 + 0.05 * rng.standard_normal()
            data += packed("ATT", at, 0.0, tilt[0], 0.0, tilt[1], 0.0, yaw)
            data += packed("CTUN", at, 0.5, -z + 0.002 * rng.standard_normal())
            if k == 10_000:
                data += packed("MODE", at, 2, 2, 1)
            if k == 15_000:
                data += packed("MODE", at, 19, 19, 1)
            force = thrust(1500 + signs * (pwm - 1500.0))
        w += fine * (force[4] + force[5] - DRAG * w * abs(w)) / MASS
        r += fine * (float(arm @ force[:4]) - TURN * r * abs(r)) / INERTIA
        z, psi = z + fine * w, psi + fine * r
    path.write_bytes(data)


def test_a_dataflash_log_becomes_a_campaign(tmp_path: Path) -> None:
    write_dive(tmp_path / "dive.BIN", moves=True)
    place = tmp_path / "dive"
    assert run_with(["init", str(tmp_path / "dive.BIN"), "-o", str(place), "-q"]) == 0
    text = (place / "campaign.toml").read_text(encoding="utf-8")
    tables = tomllib.loads(text)
    assert "# guessed: the vehicle: the log's FRAME_CONFIG = 1" in text
    assert [t["span"] for t in tables["thruster"]] == [-400.0, 400.0, 400.0, 400.0, 400.0, 400.0]
    assert set(tables["model"]["dofs"]) >= {"heave", "yaw"}
    assert "mode ALT_HOLD" in text
    assert "dive.BIN: no message names the vehicle: its modes are read as those of ArduSub" in text
    assert tables["model"]["input"] == "hold"
    found = hs.check(place)
    assert any(f.code == "K133" for f in found.warnings), [f.message for f in found.warnings]
    assert not found.errors


def test_a_vehicle_at_rest_has_nothing_to_tell(tmp_path: Path) -> None:
    write_dive(tmp_path / "still.BIN", moves=False)
    text = hs.init([tmp_path / "still.BIN"], tmp_path / "still", vehicle="bluerov2")
    assert "nothing can be learned" in text
    assert any(f.code == "K134" for f in hs.check(tmp_path / "still").warnings)


def test_a_table_of_another_format_is_guessed_like_a_csv(tmp_path: Path) -> None:
    t = np.arange(0.0, 30.0, 0.1)
    np.savez(
        tmp_path / "log.npz",
        time=t,
        heading=np.rad2deg(np.sin(0.3 * t)),
        pwm1=1500 + 100 * np.sign(np.sin(t)),
        pwm2=1500 - 100 * np.sign(np.sin(t)),
    )
    text = hs.init([tmp_path / "log.npz"], tmp_path / "dive")
    tables = tomllib.loads(text)
    assert tables["log"]["columns"]["psi"] == {"name": "heading", "unit": "deg"}
    assert [t["name"] for t in tables["thruster"]] == ["1", "2"]
    assert (tmp_path / "dive" / "log.csv").is_file()


@pytest.mark.parametrize("dated", [False, True])
def test_time_stamps_that_are_coarser_than_the_rows_are_told(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], dated: bool
) -> None:
    k = np.arange(600)
    second = k // 10
    time = np.datetime64("2026-05-01T12:00:00") + second.astype("m8[s]") if dated else second * 1.0
    columns = {"time": time, "heading": np.sin(k / 50), "pwm1": 1500 + 100 * np.sign(np.sin(k / 40))}
    np.savez(tmp_path / "log.npz", **columns)
    assert run_with(["init", str(tmp_path / "log.npz"), "-o", str(tmp_path / "dive")]) == 0
    told = "log.npz: 'time' has 60 time stamps for 600 rows, about 10 rows each"
    assert f"warning: {told}" in capfd.readouterr().err
    assert f"# guessed: {told}" in (tmp_path / "dive" / "campaign.toml").read_text()
    # a clock that tells the rows apart is the one that counts, and what somebody has said is no news
    np.savez(tmp_path / "both.npz", t=0.1 * k, **columns)
    assert "rows each" not in hs.init([tmp_path / "both.npz"], tmp_path / "both")
    assert "rows each" not in hs.init([tmp_path / "log.npz"], tmp_path / "said", duplicates="first")


def test_a_time_in_a_unit_that_is_not_known_is_told_in_the_campaign(tmp_path: Path) -> None:
    np.savez(tmp_path / "log.npz", **{"t [sec]": np.arange(9.0), "heading": np.arange(9.0)})
    text = hs.init([tmp_path / "log.npz"], tmp_path / "dive")
    assert "log.npz could not be read" in text
    assert "the unit 'sec' is not one of s, ms" in text


def test_other_formats_need_a_folder(tmp_path: Path) -> None:
    (tmp_path / "a.BIN").write_bytes(b"\x00" * 20)
    with pytest.raises(hs.UsageError, match="output"):
        hs.init([tmp_path / "a.BIN"])
    # what cannot be read is told in the file that is written all the same
    assert "could not be read" in hs.init([tmp_path / "a.BIN"], tmp_path / "a")


def real_log(name: str) -> Path:
    """A log of a BlueROV2 as it came off the vehicle."""
    shared = Path(os.environ.get("HYDROSYSID_SHARED", Path(__file__).resolve().parents[3] / "shared"))
    log = shared / "realdata" / "ardusub" / name
    if not log.is_file():
        pytest.skip("the reference data is not at hand")
    return log


def test_real_ardusub_log(tmp_path: Path) -> None:
    log, place = real_log("small.BIN"), tmp_path / "dive"
    text = hs.init([log], place)
    assert "FRAME_CONFIG = 1" in text
    assert text.count("span = -400.0") == 4
    found = hs.check(place)
    assert any(f.code == "K134" for f in found.warnings)


def test_real_telemetry(tmp_path: Path) -> None:
    """The telemetry of another vehicle, a Heavy: frame, directions and modes stand in its messages."""
    text = hs.init([real_log("small.tlog")], tmp_path / "dive")
    tables = tomllib.loads(text)
    assert "FRAME_CONFIG = 2" in text
    assert [t["span"] < 0 for t in tables["thruster"]] == [True, True, False, False, True, False, False, True]
    assert "closed_loop" not in text  # MANUAL from the first heartbeat to the last
    assert not hs.check(tmp_path / "dive").errors


def test_logs_of_two_vehicles_are_told_apart(tmp_path: Path) -> None:
    text = hs.init([real_log("small.BIN"), real_log("small.tlog")], tmp_path / "dive")
    assert [run["file"] for run in tomllib.loads(text)["run"]] == ["small.csv", "small.tlog.csv"]
    assert "small.tlog: FRAME_CONFIG = 2, and 1 in the first log: these are two vehicles" in text


def test_vehicles_are_functions_too() -> None:
    assert {"bluerov2", "bluerov2-heavy", "laurs", "otter", "remus100"} <= set(hs.vehicles())
