"""A small vehicle in surge and yaw, simulated by NumPy alone."""

import sys
from pathlib import Path

import hydrosysid as hs
import numpy as np
import pytest

# modules that several files of tests share lie beside them
sys.path.append(str(Path(__file__).parent))

MASS, LINEAR, QUADRATIC = 250.0, 20.0, 120.0


def surge(seed: int, role: str, period: float, noise: float = 0.002) -> hs.Run:
    """250 u̇ + 20 u + 120 u|u| = τ at 10 Hz for 60 s, by fine Euler steps apart from the library."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 60.0, 0.1)
    tau = 60.0 + 80.0 * np.sin(2.0 * np.pi * t / period)
    fine = np.arange(0.0, 60.0, 0.001)
    force = np.interp(fine, t, tau)
    u = np.empty_like(fine)
    speed = 0.3
    for k, f in enumerate(force):
        u[k] = speed
        speed += 0.001 * (f - LINEAR * speed - QUADRATIC * speed * abs(speed)) / MASS
    logged = u[::100] + noise * rng.standard_normal(len(t))
    return hs.Run(t=t, u=logged, tau_u=tau, name=f"surge_{seed}", kind="oscillatory", role=role)


@pytest.fixture(scope="session")
def runs() -> list[hs.Run]:
    return [surge(1, "train", 12.0), surge(2, "train", 20.0), surge(3, "validate", 15.0)]


@pytest.fixture(scope="session")
def campaign(runs: list[hs.Run]) -> hs.Campaign:
    return hs.Campaign(
        vehicle={"name": "small", "mass": 150.0},
        dofs=["surge"],
        effects=["inertia", "linear_drag", "quadratic_drag"],
        runs=runs,
    )


@pytest.fixture
def folder(tmp_path: Path, runs: list[hs.Run]) -> Path:
    """The same campaign as files."""
    tables = []
    for run in runs:
        t, u = run["u"]
        rows = "\n".join(
            f"{a!r},{b!r},{c!r}" for a, b, c in zip(*(x.tolist() for x in (t, u, run["tau_u"][1])), strict=True)
        )
        (tmp_path / f"{run.name}.csv").write_text(f"t,u,tau_u\n{rows}\n")
        tables.append(f'[[run]]\nfile = "{run.name}.csv"\nkind = "{run.kind}"\nrole = "{run.role}"\n')
    head = 'format = 1\n[vehicle]\nname = "small"\nmass = 150.0\n[model]\ndofs = ["surge"]\n'
    effects = 'effects = ["inertia", "linear_drag", "quadratic_drag"]\n'
    (tmp_path / "campaign.toml").write_text(head + effects + "\n".join(tables))
    return tmp_path
