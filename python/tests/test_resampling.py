"""Refits by every estimator scatter as the fit says."""

from typing import Literal

import hydrosysid as hs
import numpy as np
import pytest

ESTIMATORS = ["filter_error", "output_error", "integral", "staged"]
METHODS = ["bootstrap", "monte_carlo", "runs"]


def pushed(seed: int) -> hs.Run:
    """250 u̇ + 20 u + 120 u|u| = τ + d at 10 Hz for 60 s, d a random force of 6 N that remembers for 2 s."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 60.0, 0.1)
    tau = 60.0 + 80.0 * np.sin(2.0 * np.pi * t / (10.0 + 2.0 * seed))
    u, speed, force = np.empty_like(t), 0.3, 6.0 * rng.standard_normal()
    for k in range(len(t)):
        u[k] = speed
        for part in range(10):
            push = np.interp(t[k] + 0.01 * part, t, tau) + force
            speed += 0.01 * (push - 20.0 * speed - 120.0 * speed * abs(speed)) / 250.0
        force = np.exp(-0.05) * force + 6.0 * np.sqrt(-np.expm1(-0.1)) * rng.standard_normal()
    return hs.Run(t=t, u=u + 0.002 * rng.standard_normal(len(t)), tau_u=tau, name=f"run_{seed}", kind="oscillatory")


@pytest.fixture(scope="module")
def windy() -> hs.Campaign:
    """Four runs in turbulence."""
    effects = ["inertia", "linear_drag", "quadratic_drag"]
    return hs.Campaign(vehicle={"mass": 150.0}, dofs=["surge"], effects=effects, runs=[pushed(k) for k in range(4)])


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_every_estimator_can_be_resampled(
    windy: hs.Campaign,
    estimator: Literal["filter_error", "output_error", "integral", "staged"],
    method: Literal["bootstrap", "monte_carlo", "runs"],
) -> None:
    draws = 4 if method == "runs" else 12  # whole fits
    found = hs.resample(windy, method=method, estimator=estimator, draws=draws, seed=2)
    fit = hs.fit(windy, estimator=estimator)
    assert (found.method, found.draws + found.failed) == (method, draws)
    assert found.failed <= 1
    assert found.parameters
    assert [p.term for p in found.parameters] == [p.term for p in fit.parameters if not p.fixed and p.std is not None]
    for p in found.parameters:
        # one fit from the same start: to the tolerance of its search
        assert p.value == pytest.approx(fit[p.term].value, rel=1e-6)
        assert p.std > 0.0


@pytest.mark.parametrize("method", ["bootstrap", "monte_carlo"])
def test_refits_are_by_the_estimator_of_the_fit(
    windy: hs.Campaign, method: Literal["bootstrap", "monte_carlo"]
) -> None:
    """That of the campaign, else the one that suits its runs."""
    effects = ["inertia", "linear_drag", "quadratic_drag"]
    runs = [pushed(k) for k in range(4)]
    integral = hs.Campaign(
        vehicle={"mass": 150.0}, dofs=["surge"], effects=effects, runs=runs, fit={"estimator": "integral"}
    )
    for campaign in (windy, integral):
        named = hs.fit(campaign).estimator
        said = hs.resample(campaign, method=method, draws=4, seed=3, estimator=named)
        assert hs.resample(campaign, method=method, draws=4, seed=3) == said
        other = hs.resample(campaign, method=method, draws=4, seed=3, estimator="output_error")
        assert other.parameters[0].std != said.parameters[0].std


@pytest.mark.parametrize("method", ["bootstrap", "monte_carlo"])
def test_refits_by_filter_error_know_of_the_random_force(
    windy: hs.Campaign, method: Literal["bootstrap", "monte_carlo"]
) -> None:
    draws = 200 if method == "bootstrap" else 60
    fit = hs.fit(windy)
    assert fit.estimator == "filter_error"
    assert fit.noise is not None
    assert fit.noise.force[0].rms == pytest.approx(6.0, rel=0.3)
    found = hs.resample(windy, method=method, estimator="filter_error", draws=draws, seed=4)
    for p in found.parameters:
        std = fit[p.term].std
        assert std is not None
        # 60 draws know a deviation to a tenth; thirty blocks of 8 s, drawn with replacement, to a fifth
        assert 0.6 < p.std / std < 1.6
        assert abs(p.mean - p.value) < p.std
    if method == "monte_carlo":
        # data that no force has pushed scatter by the noise of the sensor alone
        still = hs.resample(windy, method=method, estimator="output_error", draws=30, seed=4)
        assert still.parameters[0].std < 0.7 * found.parameters[0].std


def test_a_block_bootstrap_by_filter_error_needs_two_blocks(runs: list[hs.Run]) -> None:
    short = hs.Run({"t": np.arange(60) * 0.1} | {name: runs[0][name][1][:60] for name in ("u", "tau_u")})
    tiny = hs.Campaign(dofs=["surge"], effects=["inertia", "quadratic_drag"], runs=[short])
    with pytest.raises(hs.DataError, match="1 "):
        hs.resample(tiny, estimator="filter_error", draws=5)
