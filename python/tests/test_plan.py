"""Plans of the next runs."""

from __future__ import annotations

from pathlib import Path

import hydrosysid as hs
import numpy as np
import pytest

EFFECTS = ["inertia", "linear_drag", "quadratic_drag"]


@pytest.fixture(scope="module")
def fit() -> hs.Fit:
    """Surge under a sine, from rest, by the package's own integrator."""
    t = np.arange(0.0, 60.0, 0.1)
    force = 120.0 * np.sin(2 * np.pi * t / 11.0)
    rate = lambda s, x: (np.interp(s, t, force) - 82.3 * x - 309.0 * x * np.abs(x)) / 842.0  # noqa: E731
    u = np.asarray(hs.rk4(rate, t, [0.0]))[:, 0]
    noise = np.random.default_rng(3).normal(0.0, 0.005, t.size)
    run = hs.Run(t=t, u=u + noise, tau_u=force, name="surge")
    return hs.fit(hs.Campaign(runs=[run], dofs=["surge"], effects=EFFECTS))


def test_a_fit_plans_its_next_runs(fit: hs.Fit) -> None:
    plan = hs.plan(fit, want="2%", limits={"surge": 140.0}, length=40.0)
    assert plan.runs
    assert all(p.std is not None and p.std <= (p.wanted or 0.0) for p in plan.parameters)
    command = plan.command(plan.runs[0].name)
    time, force = command["tau_u"]
    assert np.abs(force).max() <= 140.0
    assert time[-1] == 40.0
    again = hs.plan(fit, runs=plan.runs, want="2%", limits={"surge": 140.0})
    assert again.parameters[0].std == plan.parameters[0].std
    assert "inertia@surge" in plan.summary()


def test_wishes_that_cannot_be_are_refused(fit: hs.Fit, tmp_path: Path) -> None:
    with pytest.raises(hs.UsageError, match="did you mean"):
        hs.plan(fit, want="k_u|u=1")
    with pytest.raises(hs.DataError, match="limit of thrust"):
        hs.plan(fit, limits={"surge": 0.0})
    model = tmp_path / "model.toml"
    model.write_text(fit.model.to_toml(), encoding="utf-8")
    known = hs.plan(model, want="90%", limits={"surge": 100.0})
    assert known.runs == ()
    assert known.sentence.startswith("Enough already")
    alone = hs.plan(model, want="90%", without_known=True, limits={"surge": 100.0})
    assert alone.runs
