"""Logs of ArduPilot and PX4, written byte by byte as their formats define them."""

import struct
from pathlib import Path

import hydrosysid as hs
import numpy as np
import pytest

RNG = np.random.default_rng(7)

# ---------------------------------------------------------------- DataFlash: messages A3 95 id payload, FMT first
HEAD = b"\xa3\x95"
CODES = {
    "Q": "Q",
    "B": "B",
    "b": "b",
    "H": "H",
    "f": "f",
    "c": "h",
    "C": "H",
    "e": "i",
    "N": "16s",
    "Z": "64s",
    "n": "4s",
}
FORMATS = {
    "FMT": (128, "BBnNZ", "Type,Length,Name,Format,Columns"),
    "UNIT": (129, "QbZ", "TimeUS,Id,Label"),
    "FMTU": (130, "QBNN", "TimeUS,FmtType,UnitIds,MultIds"),
    "RCOU": (131, "QHHHH", "TimeUS,C1,C2,C3,C4"),
    "XKF1": (132, "QBccCfffffff", "TimeUS,C,Roll,Pitch,Yaw,VN,VE,VD,dPD,PN,PE,PD"),
}


def packed(name: str, *values: object) -> bytes:
    number, form, _ = FORMATS[name]
    raw = [v.encode() if isinstance(v, str) else v for v in values]
    return HEAD + bytes([number]) + struct.pack("<" + "".join(CODES[c] for c in form), *raw)


def write_dataflash(path: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Two EKF cores, 10 Hz, and outputs at 50 Hz; returns angles (deg/100), velocities and outputs as written."""
    data = b""
    for name, (number, form, columns) in FORMATS.items():
        size = 3 + struct.calcsize("<" + "".join(CODES[c] for c in form))
        data += packed("FMT", number, size, name, form, columns)
    data += packed("UNIT", 0, ord("#"), "instance")
    data += packed("FMTU", 0, 132, "s#dddnnnnmmm", "F-----------")
    angles = np.c_[RNG.integers(-1500, 1500, (40, 2)), RNG.integers(0, 36000, 40)]
    velocity = RNG.standard_normal((40, 3)).astype(np.float32)
    outputs = RNG.integers(1100, 1900, (200, 4))
    events = [(1_000_000 + 100_000 * k, 0, k) for k in range(40)] + [(1_003_000 + 20_000 * k, 1, k) for k in range(200)]
    for at, kind, k in sorted(events):
        if kind:
            data += packed("RCOU", at, *outputs[k].tolist())
        else:
            rest = [0.0, 1.0, 2.0, 3.0]
            data += packed("XKF1", at, 0, *angles[k].tolist(), *velocity[k].tolist(), *rest)
            data += packed("XKF1", at + 500, 1, 0, 0, 0, 9.0, 9.0, 9.0, *rest)
    path.write_bytes(data)
    return angles, velocity, outputs


def body(angles: np.ndarray, ned: np.ndarray) -> np.ndarray:
    """Rᵀ(φ, θ, ψ) v, written out by elementary turns."""
    turned = []
    for (phi, theta, psi), v in zip(angles, ned, strict=True):
        z = np.array([[np.cos(psi), -np.sin(psi), 0], [np.sin(psi), np.cos(psi), 0], [0, 0, 1]])
        y = np.array([[np.cos(theta), 0, np.sin(theta)], [0, 1, 0], [-np.sin(theta), 0, np.cos(theta)]])
        x = np.array([[1, 0, 0], [0, np.cos(phi), -np.sin(phi)], [0, np.sin(phi), np.cos(phi)]])
        turned.append((z @ y @ x).T @ v)
    return np.array(turned)


def test_dataflash(tmp_path: Path) -> None:
    path = tmp_path / "dive.BIN"
    angles, velocity, outputs = write_dataflash(path)
    degrees = {
        a: {"name": f"XKF1[0]:{n}", "unit": "deg"} for a, n in (("phi", "Roll"), ("theta", "Pitch"), ("psi", "Yaw"))
    }
    earth = {c: {"name": f"XKF1[0]:{n}", "frame": "ned"} for c, n in (("u", "VN"), ("v", "VE"), ("w", "VD"))}
    run = hs.Run.from_dataflash(path, columns=degrees | earth | {"V2": {"name": "RCOU:C2", "unit": "us"}})
    np.testing.assert_array_equal(run["V2"][1], outputs[:, 1])
    np.testing.assert_array_equal(run["V2"][0], (1_003_000 + 20_000 * np.arange(200)) / 1e6)
    radians = np.deg2rad(angles / 100.0)
    # the factor of the format, 0.01, and π/180 round once each
    np.testing.assert_allclose(run["psi"][1], radians[:, 2], rtol=1e-15)
    np.testing.assert_array_equal(run["u"][0], (1_000_000 + 100_000 * np.arange(40)) / 1e6)
    # products of three sines and cosines
    expected = body(radians, velocity.astype(float))
    np.testing.assert_allclose(np.c_[run["u"][1], run["v"][1], run["w"][1]], expected, atol=1e-14)
    assert any(f.code == "L214" and "sampled with it" in f.message for f in run.findings)
    one = hs.Run.from_dataflash(path, columns={"north": "XKF1[1]:VN"})
    assert set(one["north"][1].tolist()) == {9.0}


def test_dataflash_as_text(tmp_path: Path) -> None:
    path = tmp_path / "dive.log"
    lines = ["FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns", "FMT, 131, 19, RCOU, QHH, TimeUS,C1,C2"]
    path.write_text("\n".join([*lines, *(f"RCOU, {10**6 + 20_000 * k}, {1500 + k}, 1100" for k in range(9))]) + "\n")
    run = hs.Run.from_dataflash(path, columns={"V1": {"name": "RCOU:C1", "unit": "us"}})
    assert run["V1"][1].tolist() == [1500.0 + k for k in range(9)]
    assert run["V1"][0].tolist() == [(10**6 + 20_000 * k) / 1e6 for k in range(9)]


def test_velocities_along_earth_axes_need_the_attitude(tmp_path: Path) -> None:
    path = tmp_path / "dive.BIN"
    write_dataflash(path)
    columns = {c: {"name": f"XKF1[0]:{n}", "frame": "ned"} for c, n in (("u", "VN"), ("v", "VE"), ("w", "VD"))}
    with pytest.raises(hs.UsageError, match="missing: phi, theta, psi"):
        hs.Run.from_dataflash(path, columns=columns)
    with pytest.raises(hs.UsageError, match=r"columns\.v: .* give the same frame for u, v and w"):
        hs.Run.from_dataflash(path, columns={"u": columns["u"]})


def test_no_dataflash_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.bin"
    path.write_bytes(bytes(range(256)) * 8)
    with pytest.raises(hs.DataError, match=r"a\.bin"):
        hs.Run.from_dataflash(path, columns={"u": "XKF1:VN"})


# ---------------------------------------------------------------- ULog: size, type, payload; definitions, then data
def message(kind: str, payload: bytes) -> bytes:
    return struct.pack("<HB", len(payload), ord(kind)) + payload


def write_ulog(path: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    data = b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 100)
    data += message("B", bytes(40))
    data += message("F", b"vehicle_attitude:uint64_t timestamp;float[4] q;")
    data += message("F", b"vehicle_local_position:uint64_t timestamp;float vx;float vy;float vz;bool v_xy_valid;")
    data += message("A", struct.pack("<BH", 0, 1) + b"vehicle_attitude")
    data += message("A", struct.pack("<BH", 0, 2) + b"vehicle_local_position")
    angles = np.c_[np.linspace(-0.2, 0.2, 60), np.linspace(0.3, -0.3, 60), np.linspace(3.0, 5.0, 60)]
    half = angles / 2.0
    (cr, sr), (cp, sp), (cy, sy) = ((np.cos(h), np.sin(h)) for h in half.T)
    q = np.c_[
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    ].astype(np.float32)
    velocity = RNG.standard_normal((50, 3)).astype(np.float32)
    for k in range(60):
        data += message("D", struct.pack("<HQ4f", 1, 5_000_000 + 20_000 * k, *q[k].tolist()))
    for k in range(50):
        valid = k != 4
        data += message("D", struct.pack("<HQ3f?", 2, 5_007_000 + 20_000 * k, *velocity[k].tolist(), valid))
    path.write_bytes(data)
    return angles, q, velocity


def test_ulog(tmp_path: Path) -> None:
    path = tmp_path / "log.ulg"
    angles, _, velocity = write_ulog(path)
    columns: dict[str, object] = {
        a: f"vehicle_attitude:q.{n}" for a, n in (("phi", "roll"), ("theta", "pitch"), ("psi", "yaw"))
    }
    place = "vehicle_local_position"
    columns |= {
        c: {"name": f"{place}:v{a}", "frame": "ned", "valid": "v_xy_valid"} for c, a in zip("uvw", "xyz", strict=True)
    }
    run = hs.Run.from_ulog(path, columns=columns)  # type: ignore[arg-type]
    # quaternions of single precision
    np.testing.assert_allclose(run["theta"][1], angles[:, 1], atol=3e-7)
    np.testing.assert_allclose(np.unwrap(run["psi"][1]), angles[:, 2], atol=3e-7)
    good = np.arange(50) != 4
    at = ((5_007_000 + 20_000 * np.arange(50)) / 1e6)[good]
    np.testing.assert_array_equal(run["u"][0], at)
    between = np.array([np.interp(at, 5.0 + 0.02 * np.arange(60), a) for a in angles.T]).T
    expected = body(between, velocity[good].astype(float))
    np.testing.assert_allclose(np.c_[run["u"][1], run["v"][1], run["w"][1]], expected, atol=3e-6)
    assert any(f.code == "L214" and "interpolated" in f.message for f in run.findings)
    plain = hs.Run.from_ulog(path, columns={"vn": f"{place}[0]:vx"})
    np.testing.assert_array_equal(plain["vn"][1], velocity[:, 0].astype(float))
    path.write_bytes(b"ULog but no more")
    with pytest.raises(hs.DataError, match=r"log\.ulg"):
        hs.Run.from_ulog(path, columns={"vn": f"{place}:vx"})
