"""Every result shows itself, tabulates, draws, and is plain data that pickles."""

import base64
import inspect
import pickle
import re
import sys
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
    "Fits": lambda campaign, fit, folder: hs.map_fit([campaign, folder / "campaign.toml", folder / "absent.toml"]),
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
    results = {n for n in hs.__all__ if inspect.isclass(c := getattr(hs, n)) and hasattr(c, "to_frame")} - {
        "Run",
        "Model",
    }
    assert results == set(MAKERS)


@pytest.mark.parametrize("name", MAKERS)
def test_a_result_shows_itself(name: str, campaign: hs.Campaign, fit: hs.Fit, folder: Path) -> None:
    found = MAKERS[name](campaign, fit, folder)
    assert type(found).__name__ == name
    rows = found.rows()
    assert len(found.summary().splitlines()) >= min(len(rows), 1)
    assert str(found) == found.summary()
    html = re.sub(r"<img[^>]*>", "", found._repr_html_())
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
    # a figure of panels has several
    assert all(ax.has_data() for ax in (own.tolist() if isinstance(own, np.ndarray) else [own]))
    _, given = plt.subplots()
    assert found.plot(ax=given) is given
    assert given.has_data()
    plt.close("all")


def test_residuals_are_those_of_the_estimator(campaign: hs.Campaign, runs: list[hs.Run], fit: hs.Fit) -> None:
    trained = [run for run in runs if run.role == "train"]
    # filter error: one innovation a sample once the state is known, as large as the sensor's noise of 2 mm/s
    assert fit.estimator == "filter_error"
    assert fit.nobs == len(fit.resid) == sum(len(r.values) for r in fit.residuals)
    assert fit.nobs == pytest.approx(sum(len(run["u"][0]) for run in trained), abs=4)
    assert fit.resid.index.names == ["run", "channel", "t"]
    one = fit.resid["surge_1", "u"]
    assert np.isin(one.index, trained[0]["u"][0]).all()
    assert one.std() == pytest.approx(0.002, rel=0.1)
    for left in fit.residuals:
        assert np.sqrt(np.mean((left.values / left.std) ** 2)) == pytest.approx(1.0, abs=0.1)
    assert f"{fit.nobs} observations, converged" in fit.summary()
    # output error: measured less a simulation of the same model
    other = hs.fit(campaign, estimator="output_error")
    assert other.nobs == sum(len(run["u"][0]) for run in trained)
    assert all(not len(left.std) for left in other.residuals)
    stage = other.stages[0]
    assert np.sqrt(np.mean(other.resid.to_numpy() ** 2)) == pytest.approx(stage.residual_std, rel=1e-9)
    # integral least squares: the rows of its balance, made by hand from the regressors
    rows = hs.fit(campaign, estimator="integral")
    assert rows.nobs == rows.stages[0].rows
    window = next(k for k in range(1, 200) if len(hs.regressors(trained, "surge", EFFECTS, samples=k).rhs) == rows.nobs)
    system = hs.regressors(trained, "surge", EFFECTS, samples=window)
    lacking = system.rhs - system.columns @ rows.params.to_numpy()
    np.testing.assert_allclose(np.concatenate([r.values for r in rows.residuals]), lacking, rtol=1e-9, atol=1e-9)
    np.testing.assert_array_equal(np.concatenate([r.time for r in rows.residuals]), system.span[:, 1])
    mapped = hs.map_fit([campaign])[0]
    assert isinstance(mapped, hs.Fit)
    with pytest.raises(hs.UsageError, match="keeps no residuals"):
        mapped.resid  # noqa: B018
    assert mapped.nobs == sum(s.rows for s in fit.stages)


EFFECTS = ["inertia", "linear_drag", "quadratic_drag"]


def test_a_model_is_a_thing_of_its_own(campaign: hs.Campaign, fit: hs.Fit, tmp_path: Path) -> None:
    model = fit.model
    assert (model.name, model.dofs) == ("small", ["surge"])
    assert model.effects == [p.term for p in fit.parameters]
    assert [row["value"] for row in model.rows()] == fit.params.tolist()
    assert model["k_u|u|"] == model["quadratic_drag@surge"] == fit["k_u|u|"].value
    assert model.envelope["tau_u"] == (-20.0, 140.0)
    file = model.save(tmp_path / "small.toml")
    assert file.read_text(encoding="utf-8") == model.to_toml()
    with pytest.raises(hs.UsageError, match="exists"):
        model.save(file)
    again = hs.Model.from_file(file)
    assert again == model == pickle.loads(pickle.dumps(model)) == hs.Model(model.to_toml())
    assert hs.simulate(campaign, again) == hs.simulate(campaign, fit) == hs.simulate(campaign, file)
    assert hs.compare_models(model, fit).joint.p_value == pytest.approx(1.0)  # type: ignore[union-attr]
    assert hs.export(model, "csv").content == hs.export(fit, "csv").content
    assert "small" in model._repr_html_()
    assert str(model).count("\n") == 3 + 4 + 0
    for text in ("no = [", "format = 1\n"):
        with pytest.raises(hs.UsageError, match="a model file is expected"):
            hs.Model(text)
    with pytest.raises(KeyError, match="names 0 parameters; there are inertia@surge"):
        model["k_v"]
    with pytest.raises(AttributeError, match="does not change"):
        model.name = "other"  # type: ignore[misc]


def test_a_comparison_draws_what_was_measured_and_simulated(campaign: hs.Campaign, fit: hs.Fit) -> None:
    compared = hs.compare(campaign, fit)
    panels = compared.plot()
    assert [ax.get_ylabel() for ax in panels] == ["u, m/s"]
    assert panels[0].figure.get_suptitle() == "surge_3, took no part in the fit"
    ratio = compared.runs[2].rms / compared.runs[2].noise_floor
    assert panels[0].get_title(loc="right") == f"error {ratio:.2g} × noise"
    assert compared.simulation is not None
    run = compared.simulation["surge_3"]
    measured, simulated = panels[0].lines
    np.testing.assert_array_equal(measured.get_ydata(), run.measured["u"])
    np.testing.assert_array_equal(simulated.get_ydata(), run.simulated["u"])
    # 95 % of the samples lie in the band, whose edges are 1.96 deviations away
    (band,) = panels[0].collections
    edges = band.get_paths()[0].vertices
    known = np.isfinite(run.std["u"])
    assert edges[:, 1].max() == pytest.approx((run.simulated["u"] + 1.96 * run.std["u"])[known].max())
    inside = np.abs(run.measured["u"] - run.simulated["u"])[known] < 1.96 * run.std["u"][known]
    assert 0.9 < inside.mean() < 0.99
    assert compared.plot("surge_1").item().figure.get_suptitle() == "surge_1, of the fit"
    assert compared.plot(channel="u").get_title().startswith("surge_3, took no part in the fit; error ")
    with pytest.raises(KeyError, match="no run 'surge_9'"):
        compared.plot("surge_9")
    with pytest.raises(KeyError, match="no channel 'r'; there are u"):
        compared.plot(channel="r")
    with pytest.raises(hs.UsageError, match="no simulated run"):
        replace(compared, simulation=None).plot()
    assert compared.plot_errors().get_xlabel() == "rms error over sensor noise"
    plt.close("all")


def test_a_simulation_has_a_panel_for_each_measured_channel() -> None:
    t = np.arange(40) * 0.5
    names = ["psi", "r", "u", "v", "depth", "p"]
    measured = {name: np.full(40, np.nan if name == "p" else k) for k, name in enumerate(names)}
    time = np.r_[t[:20], t[20:] + 100.0]
    run = hs.SimulatedRun("a", "train", time, {name: np.sin(t) for name in names}, measured)
    panels = hs.Simulation(1, (run,), ()).plot()
    assert [ax.get_ylabel() for ax in panels] == ["u, m/s", "v, m/s", "r, rad/s", "psi, rad", "depth"]
    # nothing is drawn across the gap
    line = panels[0].lines[1].get_ydata()
    assert len(line) == 41
    assert np.isnan(line[20])
    assert [ax.get_xlabel() for ax in panels] == ["", "", "t, s", "", "t, s"]
    plt.close("all")


def test_a_notebook_shows_verdict_table_and_picture(campaign: hs.Campaign, fit: hs.Fit) -> None:
    html = fit._repr_html_()
    assert 'class="light green"' in html
    assert fit.sentence in html
    assert "virtual mass" in html
    data = re.search(r'<img width="\d+" alt="" src="data:image/png;base64,([^"]+)">', html)
    assert data is not None
    assert base64.b64decode(data[1]).startswith(b"\x89PNG")
    assert 'class="light red"' in replace(fit, converged=False)._repr_html_()
    warned = replace(fit, warnings=(hs.Finding("M1", "a-kind", "warning", "1 < 2"),))._repr_html_()
    assert 'class="light amber"' in warned
    assert '<li class="warning">' in warned
    assert "1 &lt; 2" in warned
    found = hs.discover(campaign)
    assert found.sentence in found._repr_html_()
    wide = hs.simulate(campaign, fit)._repr_html_()
    assert wide.count("<tr>") == 1 + len(campaign.runs)
    assert not plt.get_fignums(), "a small picture leaves no figure behind"


# a building block is judged by whoever built with it
NO_VERDICT = {"Export", "LeastSquares", "ThrusterFit"}


@pytest.mark.parametrize("name", sorted(set(MAKERS) - NO_VERDICT))
def test_a_notebook_shows_a_verdict_first(name: str, campaign: hs.Campaign, fit: hs.Fit, folder: Path) -> None:
    html = MAKERS[name](campaign, fit, folder)._repr_html_()
    verdict = re.search(r"</h4><p>(?:<span[^>]*></span>)?<b>([^<]+)</b></p>", html)
    assert verdict is not None
    assert len(verdict[1]) > 15
    assert "<img" in html


def test_verdicts_are_calculated(campaign: hs.Campaign, fit: hs.Fit) -> None:
    compared = hs.compare(campaign, fit)
    worst = compared.runs[2]
    assert worst.role == "validate"
    ratio = f"{worst.rms / worst.noise_floor:.2g}"
    assert f"Held-out runs: the free simulation errs by {ratio} × the sensor noise" in compared._repr_html_()
    assert f"at most {ratio} ×: surge_3 in surge" in compared._repr_html_()
    trained = replace(compared, runs=compared.runs[:2])
    assert "Runs of the fit (none is held out)" in trained._repr_html_()

    simulated = hs.simulate(campaign, fit)
    fits = {
        run.run: 100.0 - 100.0 * np.std(e) / np.std(m)
        for run in simulated.runs
        for m in [run.measured["u"]]
        for e in [run.simulated["u"] - m]
    }
    least = min(fits, key=lambda name: fits[name])
    # the mean of the error, which std leaves out and rms does not, is a hundredth of the motion at most
    told = re.search(
        r"3 runs, 1 of which took no part in the fit; fit ([\d.]+) % or better, lowest in u of (\w+)",
        simulated._repr_html_(),
    )
    assert told is not None
    assert (float(told[1]), told[2]) == (pytest.approx(fits[least], abs=1.0), least)
    lost = replace(simulated.runs[0], simulated={"u": np.full(600, np.inf)})
    assert "fit -inf %" in replace(simulated, runs=(lost,))._repr_html_()

    forces = hs.force_components(campaign, fit)[0]
    sizes = {name: np.sqrt(np.mean(f**2)) for name, f in forces.terms.items()}
    assert f"is the largest, {max(sizes.values()):.3g} N rms" in forces._repr_html_()

    draws = hs.resample(campaign, draws=20)
    widest = max(draws.parameters, key=lambda p: (p.interval[1] - p.interval[0]) / abs(p.value))
    assert f"{widest.term} {widest.name} scatters most" in draws._repr_html_()
    assert 'class="light amber"' not in draws._repr_html_()
    failing = replace(draws, failed=5)._repr_html_()
    assert 'class="light amber"' in failing
    assert "5 of 25 refits failed" in failing


def test_published_parameters_are_judged_together(campaign: hs.Campaign, fit: hs.Fit) -> None:
    own = fit["quadratic_drag@surge"].value
    for value, light, words in ((-own, "green", "agree with your own estimates"), (-2.0 * own, "red", "differ from")):
        params = {"format": 1, "convention": "sname", "parameters": {"X_u|u|": value}}
        html = hs.compare_published(campaign, params, fit)._repr_html_()
        assert f'class="light {light}"' in html
        assert words in html
        assert "× those of your own model on held-out runs" in html
    compared = hs.compare_published(campaign, params, fit)
    alone = replace(compared, parameters=tuple(replace(p, z=None, p_value=None) for p in compared.parameters))
    assert "No published parameter has an estimate to be compared with; its errors" in alone._repr_html_()
    assert "<img" in alone._repr_html_()
    points = alone.plot_errors().lines[1]
    np.testing.assert_allclose(points.get_xdata(), [e.rms / e.noise_floor for e in compared.runs])
    plt.close("all")


def test_deviations_of_a_fit_that_did_not_converge_are_marked(fit: hs.Fit, campaign: hs.Campaign) -> None:
    loose = replace(fit, converged=False)
    for p in fit.parameters:
        marked = f"{p.std:.4g} ?"
        lines = [line for line in loose.summary().splitlines() if line.startswith(f"{p.term} {p.name}")]
        assert len(lines) == 1
        assert marked in lines[0]
        (row,) = [row for row in re.findall(r"<tr>.*?</tr>", loose._repr_html_()) if f"<td>{p.term}</td>" in row]
        assert row.count(" ?<") == 2, "of the deviation and of the interval"
        assert marked in next(
            line for line in loose.to_latex().splitlines() if line.startswith(p.term.replace("_", r"\_"))
        )
    assert " ?" not in fit.summary() + fit.to_latex()
    assert " ?<" not in fit._repr_html_()
    assert "what is marked ? is not a standard error" in loose.summary()
    assert [row["std"] for row in loose.rows()] == [p.std for p in fit.parameters], "data stays data"
    both = hs.Fits(1, ("a", "b"), (fit, loose)).summary()
    assert both.count(" ?") == len(fit.parameters)
    assert " ?" not in hs.Fits(1, ("a", "b"), (fit, fit)).summary()
    assert all(text.get_text().endswith(" ?") for text in loose.plot().get_yticklabels())
    plt.close("all")


def test_no_probability_is_zero(fit: hs.Fit) -> None:
    sure = replace(fit, parameters=tuple(replace(p, std=1e-6 * p.value) for p in fit.parameters))
    assert sure.summary().count("<1e-15") == len(fit.parameters)
    joint = hs.Joint(1e6, 3, 0.0)
    apart = replace(hs.compare_models(fit, fit), joint=joint)
    assert "the models differ: p &lt; 1e-15 of all" in apart._repr_html_()
    one = replace(apart.parameters[0], p_value=0.0)
    shown = replace(apart, parameters=(one,))
    assert "<1e-15" in shown.summary()
    assert "&lt;1e-15" in shown._repr_html_()
    assert "<1e-15" in shown.to_latex()
    assert shown.rows()[0]["p_value"] == 0.0


def test_a_notebook_without_matplotlib_shows_the_rest(fit: hs.Fit, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    html = fit._repr_html_()
    assert "<table>" in html
    assert "<img" not in html


def test_plots_call_effects_by_their_common_names(campaign: hs.Campaign, fit: hs.Fit) -> None:
    labels = [label.get_text().splitlines()[0] for label in fit.plot().get_yticklabels()]
    assert labels == ["virtual mass in surge, m_u", "linear drag in surge, k_u", "quadratic drag in surge, k_u|u|"]
    legend = hs.force_components(campaign, fit)[0].plot().get_legend()
    assert legend is not None
    assert {text.get_text() for text in legend.get_texts()} >= {"linear drag in surge", "total"}
    lacking = hs.Campaign(
        vehicle={"name": "small"}, dofs=["surge"], effects=["inertia", "linear_drag"], runs=campaign._source[2]
    )
    steps = [label.get_text() for label in hs.discover(lacking).plot().get_xticklabels()]
    assert steps == ["baseline", "+ quadratic drag in surge"]
    plt.close("all")
