"""Every result shows itself, tabulates, draws, and is plain data that pickles."""

import inspect
import pickle
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import hydrosysid as hs
import matplotlib as mpl
import numpy as np
import pytest

mpl.use("Agg")

import matplotlib.pyplot as plt
import pandas as pd
import polars as pl

PARAMS = {"format": 1, "convention": "sname", "source": "a book", "parameters": {"X_u|u|": -130.0, "X_udot": -90.0}}
MAKERS: dict[str, Callable[[hs.Campaign, hs.Fit, Path], Any]] = {
    "Fit": lambda campaign, fit, folder: fit,
    "Simulation": lambda campaign, fit, folder: hs.simulate(campaign, fit),
    "Forces": lambda campaign, fit, folder: hs.force_components(campaign, fit)[0],
    "Comparison": lambda campaign, fit, folder: hs.compare(campaign, fit),
    "CrossValidation": lambda campaign, fit, folder: hs.cross_validate(campaign),
    "PublishedComparison": lambda campaign, fit, folder: hs.compare_published(campaign, PARAMS, fit),
    "ModelDifference": lambda campaign, fit, folder: hs.compare_models(fit, hs.fit(campaign, estimator="integral")),
    "Monitored": lambda campaign, fit, folder: hs.monitor(campaign, fit),
    "Discovery": lambda campaign, fit, folder: hs.discover(campaign),
    "Resampling": lambda campaign, fit, folder: hs.resample(campaign, draws=20),
    "Plan": lambda campaign, fit, folder: hs.plan(fit, want="5%", limits={"surge": 140.0}, most=2),
    "Check": lambda campaign, fit, folder: hs.check(folder / "campaign.toml"),
    "Export": lambda campaign, fit, folder: hs.export(fit, "gazebo", inertia=(5.0, 10.0, 12.0)),
    "LeastSquares": lambda campaign, fit, folder: hs.least_squares(np.vander(np.arange(6.0), 2), np.arange(6.0) ** 2),
    "ThrusterFit": lambda campaign, fit, folder: hs.fit_thruster(V, 10.0 * V * np.abs(V) + V),
}
V = np.r_[-5.0:-0.9:0.5, 1.0:5.1:0.5]
# a file is no picture
NO_PLOT = {"Export"}


@pytest.fixture(scope="module")
def fit(campaign: hs.Campaign) -> hs.Fit:
    return hs.fit(campaign)


def test_an_effect_without_parameters_has_a_row(campaign: hs.Campaign) -> None:
    found = hs.discover(campaign)
    row = hs.FoundEffect("coriolis_yaw", "the Munk moment", ("yaw",), (), 1e-9, (), "it is seen")
    size = hs.SmallestVisible("coriolis_roll", 0.02, "1", tied=True)
    tied = replace(found, effects=(row,), smallest_visible=(size,))
    assert [r["effect"] for r in tied.rows()] == ["coriolis_yaw"]
    assert "as a whole" in tied.summary()
    assert "as a whole" in tied._repr_html_()
    assert tied.to_frame("pandas")["value"].isna().all()
    assert tied.to_dict()["smallest_visible"] == [{"id": "coriolis_roll", "value": 0.02, "unit": "1", "tied": True}]
    assert all("tied" not in size for size in found.to_dict()["smallest_visible"])


def test_a_fit_has_the_attributes_of_statsmodels(fit: hs.Fit) -> None:
    first = fit.parameters[0]
    assert fit.params[f"{first.term} {first.name}"] == first.value
    assert list(fit.bse) == [p.std for p in fit.parameters]
    assert list(fit.params.index) == list(fit.bse.index) == list(fit.conf_int().index) == fit.names
    covariance = fit.cov_params()
    assert list(covariance.columns) == fit.names
    np.testing.assert_array_equal(covariance.to_numpy(), fit.covariance)
    free = [not p.fixed for p in fit.parameters]
    np.testing.assert_allclose(np.sqrt(np.diag(covariance))[free], fit.bse[free])
    # 1.96 and 1.00 standard errors on either side
    for alpha, reach in ((0.05, 1.959964), (0.317311, 1.0)):
        interval = fit.conf_int(alpha)
        np.testing.assert_allclose(interval["upper"] - interval["lower"], 2.0 * reach * fit.bse, rtol=1e-5)
    with pytest.raises(ValueError, match="between 0 and 1"):
        fit.conf_int(5.0)


def test_no_result_is_forgotten() -> None:
    results = {n for n in hs.__all__ if inspect.isclass(c := getattr(hs, n)) and hasattr(c, "to_frame")} - {"Run"}
    assert results == set(MAKERS)


@pytest.mark.parametrize("name", MAKERS)
def test_a_result_shows_itself(name: str, campaign: hs.Campaign, fit: hs.Fit, folder: Path) -> None:
    found = MAKERS[name](campaign, fit, folder)
    assert type(found).__name__ == name
    rows = found.rows()
    assert len(found.summary().splitlines()) >= min(len(rows), 1)
    assert str(found) == found.summary()
    html = found._repr_html_()
    assert "<" in html
    assert "nan" not in html.lower().replace("name", "")
    assert found.to_latex().startswith(r"\begin{tabular}")
    for library, kind in (("pandas", pd.DataFrame), ("polars", pl.DataFrame)):
        table = found.to_frame(library)
        assert isinstance(table, kind)
        assert len(table) == len(rows)
    again = pickle.loads(pickle.dumps(found))
    assert again == found
    assert again.to_dict() == found.to_dict()


@pytest.mark.parametrize("name", sorted(set(MAKERS) - NO_PLOT))
def test_a_plot_draws_into_the_axes_given_and_returns_them(
    name: str, campaign: hs.Campaign, fit: hs.Fit, folder: Path
) -> None:
    found = MAKERS[name](campaign, fit, folder)
    own = found.plot()
    assert own.has_data()
    _, given = plt.subplots()
    assert found.plot(ax=given) is given
    assert given.has_data()
    plt.close("all")
