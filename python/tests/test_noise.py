"""Noise and random force: what a fit says of them, and what predictions then say of themselves."""

from dataclasses import replace

import hydrosysid as hs
import numpy as np
import pytest


@pytest.fixture(scope="module")
def fit(campaign: hs.Campaign) -> hs.Fit:
    return hs.fit(campaign)


def test_a_run_without_random_force_has_none(fit: hs.Fit) -> None:
    assert fit.estimator == "filter_error"
    assert fit.converged
    assert fit.sentence in fit.summary()
    assert fit.noise is not None
    assert fit.noise.force == ()
    (sensor,) = fit.noise.sensors
    assert sensor.channel == "u"
    # 2 mm/s from 1200 samples: known to 1/√2400 = 2 %, five of which are allowed
    assert sensor.std == pytest.approx(0.002, rel=0.1)


def test_predictions_err_as_expected(campaign: hs.Campaign, fit: hs.Fit) -> None:
    compared = hs.compare(campaign, fit)
    assert compared.noise is not None
    ahead = {p.ahead for p in compared.noise.prediction if p.run == "surge_3"}
    assert ahead == {0.0, 2.0, 8.0, None}
    for p in compared.noise.prediction:
        # 600 samples, but of a prediction 8 s ahead a dozen: 1/√24 = 0.2, four of which are allowed
        assert 0.2 * p.expected < p.rms < 1.8 * p.expected


def test_a_simulation_has_its_band(campaign: hs.Campaign, fit: hs.Fit) -> None:
    run = hs.simulate(campaign, fit)["surge_3"]
    known = np.isfinite(run.std["u"])
    assert known.mean() > 0.9
    inside = np.abs(run.measured["u"] - run.simulated["u"])[known] < 1.96 * run.std["u"][known]
    # 95 %, and what the start adds, which is estimated apart from the band
    assert inside.mean() > 0.85
    bare = replace(fit, model=hs.fit(campaign, estimator="integral").model)
    assert hs.simulate(campaign, bare)["surge_3"].std == {}


def test_only_filter_error_knows_of_noise(campaign: hs.Campaign) -> None:
    other = hs.fit(campaign, estimator="output_error")
    assert other.noise is None
    assert other.converged
    assert "random force" in other.sentence
