"""What the tests of exports share: the vehicle, its commands, its files as modules, and the differences of the book."""

import importlib.util
import re
from pathlib import Path
from types import ModuleType
from typing import Any

import hydrosysid as hs
import numpy as np

FLOATING = Path(__file__).parent / "floating.toml"
INERTIA = (20.0, 25.0, 28.0)
STEP, SECONDS = 0.02, 60.0
VELOCITIES = ("u", "v", "w", "p", "q", "r")
SIZE = np.array([90.0, 80.0, 70.0, 9.0, 10.0, 12.0])


def command(t: float) -> np.ndarray:
    """Forces and moments, held for a step: each with a period of its own."""
    i = np.arange(6)
    return SIZE * np.sin((0.5 + 0.13 * i) * t + i) + 0.2 * SIZE


def module(text: str, folder: Path, name: str) -> Any:
    path = folder / f"{name}.py"
    path.write_text(text)
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None
    assert spec.loader is not None
    made: ModuleType = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(made)
    return made


def exported(target: str, folder: Path, model: Path | hs.Model = FLOATING) -> Any:
    made = hs.export(model, target, inertia=INERTIA)
    assert made.lost == ()
    return module(made.text, folder, target.replace("-", "_"))


def quoted(target: str) -> tuple[float, float]:
    """Least and greatest difference by docs/exports.md: its figure to half of it, or what it is below."""
    page = Path(__file__).resolve().parents[2] / "docs" / "exports.md"
    rows = [line.split(" | ") for line in page.read_text(encoding="utf-8").splitlines() if line.startswith("| ")]
    cell = next(row[2] for row in rows if target in row[0])
    found = re.match(r"(below )?([\d.]+) %", cell)
    assert found is not None, cell
    share = float(found[2]) / 100.0
    return (0.0, share) if found[1] else (0.5 * share, 1.5 * share)


def assert_quoted(target: str, path: np.ndarray, truth: np.ndarray) -> None:
    each = differences(path, truth)
    print(target, each)
    least, most = quoted(target)
    assert least <= each.max() < most, f"{each}, docs/exports.md allows {least} to {most}"


def euler_rates(phi: float, theta: float) -> np.ndarray:
    s, c, t = np.sin(phi), np.cos(phi), np.tan(theta)
    return np.array([[1.0, s * t, c * t], [0.0, c, -s], [0.0, s / np.cos(theta), c / np.cos(theta)]])


def differences(path: np.ndarray, truth: np.ndarray) -> np.ndarray:
    """Root mean square difference of each velocity over that of the velocity."""
    return np.sqrt(np.mean((path - truth) ** 2, axis=0) / np.mean(truth**2, axis=0))
