"""From a vehicle's log to a model without an editor: a DataFlash log of the independent plant, whose truth is known."""

import csv
import json
import os
import subprocess
from pathlib import Path

import hydrosysid as hs
import numpy as np
import pytest
from dataflash_bytes import Dataflash, motors
from hydrosysid._command import run_with

ROOT = Path(__file__).resolve().parents[2]
OUTPUTS = [3, 1, 2, 4, 8, 7, 6, 5]
DIRECTIONS = [-1, -1, 1, 1, -1, 1, 1, -1]
MESSAGES = {
    "RCOU": ("QHHHHHHHH", "TimeUS,C1,C2,C3,C4,C5,C6,C7,C8"),
    "ATT": ("Qffffff", "TimeUS,DesRoll,Roll,DesPitch,Pitch,DesYaw,Yaw"),
    "IMU": ("QBffffff", "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ"),
    "XKF1": ("QBffffff", "TimeUS,I,VN,VE,VD,PN,PE,PD"),
    "VISO": ("Qf", "TimeUS,dt"),
    "BAT": ("QBf", "TimeUS,I,Volt"),
}


def plant() -> Path:
    """The program of the plant, where it was built."""
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    found = [path for kind in ("release", "debug") if (path := target / kind / "plant").is_file()]
    if not found:
        pytest.skip("the plant is not built: cargo build -p hydrosysid-plant")
    return found[0]


def sailed(folder: Path, *options: str) -> dict[str, np.ndarray]:
    """Columns of the one run of a campaign of the plant, NaN where a sensor has no sample."""
    subprocess.run([str(plant()), str(folder), *options], check=True, capture_output=True)
    with (folder / "run00.csv").open(newline="") as file:
        head, *rows = csv.reader(file)
    table = np.array([[float(cell) if cell else np.nan for cell in row] for row in rows])
    return {name.partition(" ")[0]: table[:, k] for k, name in enumerate(head)}


def geometry() -> np.ndarray:
    """Wrench of 1 N of each thruster of the vehicle file, (6, 8)."""
    columns = []
    for thruster in hs.vehicles()["bluerov2-heavy"]["thruster"]:
        axis = np.array(thruster["axis"]) / np.linalg.norm(thruster["axis"])
        columns.append(np.r_[axis, np.cross(thruster["position"], axis)])
    return np.array(columns).T


def pulses(force: np.ndarray) -> np.ndarray:
    """The pulse for a force, by the inverse of the T200 at 16 V, a w² + b w = F, to the nearest µs."""
    ahead = force > 0
    a, b = np.where(ahead, 36.3, 25.0), np.where(ahead, 23.3, 20.7)
    w = (np.sqrt(b * b + 4 * a * np.abs(force)) - b) / (2 * a)
    # no thrust within the dead band
    return np.rint(1500 + 400 * np.sign(force) * np.where(w > 1e-9, w + 0.074, 0.0))


def turn(phi: float, theta: float, psi: float) -> np.ndarray:
    """Body to north-east-down."""
    (sf, st, sp), (cf, ct, cp) = np.sin([phi, theta, psi]), np.cos([phi, theta, psi])
    z = np.array([[cp, -sp, 0], [sp, cp, 0], [0, 0, 1]])
    y = np.array([[ct, 0, st], [0, 1, 0], [-st, 0, ct]])
    x = np.array([[1, 0, 0], [0, cf, -sf], [0, sf, cf]])
    return np.asarray(z @ y @ x)


def write_dive(path: Path, run: dict[str, np.ndarray]) -> None:
    """A dive as ArduSub logs it: outputs where they are given, the EKF's velocities aided by a DVL."""
    log = Dataflash(MESSAGES, motors(OUTPUTS, DIRECTIONS, 2))
    log.add("MODE", 1_000_000, 19, 19, 1)
    wrench = np.array([run[f"tau_{c}"] for c in "uvwpqr"]).T
    commands = pulses((np.linalg.pinv(geometry()) @ wrench.T).T)
    place = np.zeros(2)
    for k, t in enumerate(run["t"]):
        at = 10_000_000 + round(t * 1e6)
        if np.isfinite(wrench[k]).all():
            raw = [0] * 8
            for motor, output in enumerate(OUTPUTS):
                raw[output - 1] = int(1500 + DIRECTIONS[motor] * (commands[k, motor] - 1500))
            log.add("RCOU", at, *raw)
            log.add("BAT", at, 0, 16.0)
        angles = np.array([run[c][k] for c in ("phi", "theta", "psi")])
        if np.isfinite(angles).all():
            roll, pitch, yaw = np.rad2deg(angles)
            log.add("ATT", at, 0.0, roll, 0.0, pitch, 0.0, yaw % 360)
        rates = [run[c][k] for c in "pqr"]
        if np.isfinite(rates).all():
            log.add("IMU", at, 0, *rates, 0.0, 0.0, -9.81)
        speeds = np.array([run[c][k] for c in "uvw"])
        if np.isfinite(speeds).all():
            ned = turn(*angles) @ speeds
            place += 0.2 * ned[:2]
            log.add("VISO", at, 0.2)
            log.add("XKF1", at, 0, *ned, *place, run["z"][k])
    path.write_bytes(log.data)


def test_three_commands_from_a_dive_to_the_truth(tmp_path: Path) -> None:
    # sensors at 10 Hz and commands at 8 Hz, held; the DVL at 5 Hz: all of it on clocks of their own
    options = "--vehicle heavy --dofs six --runs 1 --duration 80 --manoeuvres multisine --no-position --seed 6"
    run = sailed(tmp_path / "sea", *options.split(), "--command-rate", "8", "--dvl-rate", "5")
    write_dive(tmp_path / "dive.BIN", run)
    place, json_file = tmp_path / "dive", tmp_path / "fit.json"
    words = ["init", str(tmp_path / "dive.BIN"), "--vehicle", "bluerov2-heavy", "-o", str(place), "-q"]
    assert run_with(words) == 0
    text = (place / "campaign.toml").read_text(encoding="utf-8")
    assert 'dofs = ["surge", "sway", "heave", "roll", "pitch", "yaw"]' in text, text
    assert text.count("span = -400.0") == DIRECTIONS.count(-1), text
    assert run_with(["check", str(place), "-q"]) == 0
    assert run_with(["fit", str(place), "--json", str(json_file), "-q"]) == 0
    fit = json.loads(json_file.read_text(encoding="utf-8"))
    assert fit["converged"], fit["sentence"]
    truth = {p["effect"]: p["value"] for p in json.loads((tmp_path / "sea" / "truth.json").read_text())["parameters"]}
    off = {}
    for parameter in fit["parameters"]:
        name = f"{parameter['effect']}@{parameter['dof']}"
        true = next((value for key, value in truth.items() if f"{key}:".startswith(f"{name}:")), None)
        true = truth.get(parameter["effect"]) if true is None else true
        assert true is not None, name
        off[name] = (parameter["value"] - true) / parameter["std"]
    # inertia, two drags in six degrees of freedom, two couplings, net weight, righting moment
    assert len(off) == 22, off
    assert all(abs(z) < 3.0 for z in off.values()), off
