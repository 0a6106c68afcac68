"""The verbs on a small campaign, in memory and from files."""

import json
import os
import pickle
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import hydrosysid as hs
import matplotlib as mpl
import numpy as np
import pytest

mpl.use("Agg")
TRUTH = {"inertia@surge": 250.0, "linear_drag@surge": 20.0, "quadratic_drag@surge": 120.0}


@pytest.fixture(scope="module")
def fit(campaign: hs.Campaign) -> hs.Fit:
    return hs.fit(campaign)


def test_fit_finds_the_truth(fit: hs.Fit) -> None:
    for name, value in TRUTH.items():
        parameter = fit[name]
        assert parameter.std is not None
        # four standard deviations: one in ten thousand by chance, and the seed is fixed
        assert abs(parameter.value - value) < 4.0 * parameter.std + 0.02 * value
    assert fit.covariance.shape == (3, 3)
    assert fit["k_u|u|"].sname == "X_u|u|"
    with pytest.raises(KeyError, match="quadratic_drag@surge"):
        fit["drag"]


def test_estimators_are_chosen_by_name(campaign: hs.Campaign) -> None:
    assert hs.fit(campaign, estimator="integral").estimator == "integral"
    with pytest.raises(hs.UsageError):
        hs.fit(campaign, estimator="guess")  # type: ignore[arg-type]


def test_files_and_memory_are_one_campaign(fit: hs.Fit, folder: Path) -> None:
    of_files = hs.fit(folder / "campaign.toml")
    assert [p.value for p in of_files.parameters] == [p.value for p in fit.parameters]


def test_the_command_says_the_same(fit: hs.Fit, folder: Path) -> None:
    command = [sys.executable, "-m", "hydrosysid", "fit", "campaign.toml", "--json", "-"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == hs.fit(folder / "campaign.toml").to_dict()
    script = Path(sys.executable).with_name("hydrosysid.exe" if os.name == "nt" else "hydrosysid")
    assert subprocess.run([script, "--help"], capture_output=True, check=False).returncode == 0
    assert subprocess.run([script, "fit"], capture_output=True, check=False).returncode == 2


def test_compare_and_simulate(campaign: hs.Campaign, fit: hs.Fit, tmp_path: Path) -> None:
    comparison = hs.compare(campaign, fit)
    assert [entry.role for entry in comparison.runs] == ["train", "train", "validate"]
    # the model is the truth: what is left is the noise of 2 mm/s
    assert all(entry.rms < 0.004 and entry.fit_percent > 95.0 for entry in comparison.runs)
    simulation = hs.simulate(campaign, fit)
    run = simulation["surge_3"]
    assert np.sqrt(np.nanmean((run.simulated["u"] - run.measured["u"]) ** 2)) < 0.004
    path = tmp_path / "model.toml"
    path.write_text(fit.model.to_toml(), encoding="utf-8")
    assert hs.compare(campaign, path) == comparison


def test_discover_has_nothing_to_add(campaign: hs.Campaign) -> None:
    found = hs.discover(campaign)
    assert found.verdict == "nothing_missing"
    assert found.effects == ()
    assert found.summary().startswith("Nothing is missing")
    assert found.sentence in found._repr_html_()


def test_what_is_found_is_adopted(tmp_path: Path) -> None:
    time = np.arange(600) * 0.1
    for run in range(3):
        fine = np.arange(59901) * 0.001
        force = np.interp(fine, time, 12.0 * np.sin((0.5 + 0.2 * run) * time) + 5.0 * np.sin(1.7 * time))
        u = np.zeros(len(fine))
        for k in range(len(fine) - 1):
            u[k + 1] = u[k] + 0.001 * (force[k] - 40.0 * u[k] * abs(u[k]) - 2.0) / 20.0
        noise = 0.003 * np.random.default_rng(run).standard_normal(600)
        table = np.column_stack([time, u[::100] + noise, force[::100]])
        np.savetxt(tmp_path / f"{run}.csv", table, delimiter=",", header="t,u,tau_u", comments="", fmt="%.9g")
    roles = "".join(f"[[run]]\nfile = '{k}.csv'\n" for k in range(3)) + "role = 'validate'\n"
    text = "format = 1 # mine\n[model]\ndofs = ['surge']\neffects = ['inertia', 'quadratic_drag']\n" + roles
    (tmp_path / "campaign.toml").write_text(text, encoding="utf-8")
    found = hs.discover(tmp_path)
    assert [effect.id for effect in found.effects] == ["bias@surge"]
    assert found.effects[0].common_name in found.sentence
    found.adopt(tmp_path, tmp_path / "mine.toml")
    assert (tmp_path / "campaign.toml").read_text(encoding="utf-8") == text
    expected = text.replace("'quadratic_drag']", "'quadratic_drag', \"bias@surge\"]")
    assert (tmp_path / "mine.toml").read_text(encoding="utf-8") == expected
    found.adopt(tmp_path)
    assert hs.discover(tmp_path).verdict == "nothing_missing"
    with pytest.raises(hs.UsageError, match="another folder"):
        found.adopt(tmp_path, tmp_path.parent / "mine.toml")
    (tmp_path / "none.toml").write_text("a = 1", encoding="utf-8")
    with pytest.raises(hs.UsageError):
        found.adopt(tmp_path / "none.toml")


def test_what_is_found_is_adopted_in_memory(runs: list[hs.Run], folder: Path) -> None:
    lacking = hs.Campaign(
        vehicle={"name": "small", "mass": 150.0}, dofs=["surge"], effects=["inertia", "linear_drag"], runs=runs
    )
    found = hs.discover(lacking)
    assert found.adopt_names == ("quadratic_drag@surge",)
    whole = found.adopt(lacking)
    assert [*lacking.effects, "quadratic_drag@surge"] == whole.effects
    assert whole.runs == lacking.runs
    assert whole.effects == found.adopt(whole).effects
    assert hs.fit(whole)["quadratic_drag@surge"].value == pytest.approx(120.0, rel=0.01)
    with pytest.raises(hs.UsageError, match="give the path"):
        found.adopt(hs.Campaign.from_file(folder / "campaign.toml"))
    with pytest.raises(hs.UsageError, match="warp_drive"):
        lacking.with_effects(["warp_drive"])
    assert found.input is None
    assert hs.fit(lacking.with_effects([], input="hold")) != hs.fit(lacking)
    with pytest.raises(hs.UsageError, match="spline"):
        lacking.with_effects([], input="spline")


def test_runs_of_one_name_are_numbered_and_what_took_part_is_given_the_role(runs: list[hs.Run]) -> None:
    unnamed = [hs.Run({channel: run[channel] for channel in run.channels}) for run in runs]
    given = [unnamed[0], *(run.with_role("validate") for run in unnamed[1:])]
    lacking = hs.Campaign(
        vehicle={"name": "small", "mass": 150.0}, dofs=["surge"], effects=["inertia", "linear_drag"], runs=given
    )
    assert [run[0] for run in lacking.runs] == ["run", "run #2", "run #3"]
    whole = lacking.with_effects(["quadratic_drag@surge"], training=["run #2"])
    assert [run[2] for run in whole.runs] == ["train", "train", "validate"]
    assert [run[2] for run in lacking.runs] == ["train", "validate", "validate"]
    with pytest.raises(hs.UsageError, match="no run is named 'run77'"):
        lacking.with_effects([], training=["run77"])
    with pytest.raises(hs.UsageError, match="is none of train, validate"):
        runs[0].with_role("judge")


def test_results_are_plain_data(campaign: hs.Campaign, fit: hs.Fit) -> None:
    results = [fit, hs.compare(campaign, fit), hs.simulate(campaign, fit)]
    for result in results:
        assert pickle.loads(pickle.dumps(result)) == result
        assert json.loads(json.dumps(result.to_dict(), allow_nan=False)) == result.to_dict()
        assert len(result.to_frame("pandas")) == len(result.rows())
        assert "<table>" in result._repr_html_()
        assert result.to_latex().startswith(r"\begin{tabular}")
        assert result.summary() == str(result)
        assert type(result).__name__ in repr(result)
        axes = np.ravel(result.plot())[0]
        assert result.plot(ax=axes) is axes
        axes.figure.clear()
    assert "std err" in fit.summary()


def test_no_plot_library_is_loaded_before_it_is_asked_for() -> None:
    code = "import sys, hydrosysid; sys.exit('matplotlib' in sys.modules or 'pandas' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_a_pool_of_processes_gives_what_a_loop_gives(campaign: hs.Campaign, runs: list[hs.Run]) -> None:
    one = hs.Campaign(
        vehicle={"name": "small"},
        dofs=["surge"],
        effects=["inertia", "linear_drag", "quadratic_drag"],
        runs=runs[:1],
    )
    campaigns = [campaign, one]
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        assert list(pool.map(hs.fit, campaigns)) == [hs.fit(c) for c in campaigns]


def test_check_is_a_result(folder: Path) -> None:
    whole = hs.check(folder / "campaign.toml")
    assert whole.errors == ()
    assert [log.role for log in whole.logs] == ["train", "train", "validate"]
    (folder / "bad.csv").write_text("t,u\n0,1\n0,2\n")
    bad = hs.check([folder / "surge_1.csv", folder / "bad.csv"])
    assert bad.verdict == "red"
    assert bad.errors[0].line == 3
    assert "bad.csv" in bad.summary()


def test_wrong_tables_are_refused(runs: list[hs.Run], folder: Path) -> None:
    def made(**changes: object) -> hs.Campaign:
        usual = {"vehicle": {"name": "a"}, "dofs": ["surge"], "effects": ["inertia"], "runs": runs}
        return hs.Campaign(**(usual | changes))  # type: ignore[arg-type]

    with pytest.raises(hs.UsageError, match="inertias"):
        made(effects=["inertias"])
    with pytest.raises(hs.UsageError, match="drift"):
        made(dofs=["drift"])
    with pytest.raises(hs.UsageError, match="speed"):
        made(speed={"a": 1})
    with pytest.raises(hs.UsageError, match=r"vehicle\.mass = None: .*leave the key out"):
        made(vehicle={"name": "a", "mass": None})
    with pytest.raises(hs.UsageError, match=r"stage\[0\]\.runs\[1\] = None"):
        made(stage=[{"runs": ["a", None]}])
    with pytest.raises(hs.UsageError):
        made(runs=[])
    with pytest.raises(hs.DataError):
        made(dofs=["surge", "sway"], effects=["inertia", "linear_drag"])
    with pytest.raises(hs.UsageError):
        hs.Campaign.from_file(folder / "absent.toml")
    with pytest.raises(hs.UsageError, match="int"):
        hs.fit(7)  # type: ignore[arg-type]


def test_tank_campaign(tmp_path: Path) -> None:
    campaign = hs.tank_campaign(tmp_path / "tank", seed=3)
    assert {kind for _, kind, _ in campaign.runs} >= {"towing", "oscillatory", "zigzag"}
    assert "LAURS" in repr(campaign)
    with pytest.raises(hs.UsageError, match=r"campaign\.toml exists"):
        hs.tank_campaign(tmp_path / "tank", seed=4)
    hs.tank_campaign(tmp_path / "tank", seed=4, force=True)


def test_a_fit_need_not_keep_its_logs(tmp_path: Path) -> None:
    clock = np.arange(0.0, 60.0, 0.1)
    push = 30 * np.sin(0.5 * clock) + 10 * np.sin(0.13 * clock)
    speed = hs.rk4(
        lambda t, y: np.array([(np.interp(t, clock, push) - 20 * y[0] * abs(y[0])) / 50]), clock, np.zeros(1)
    )
    hs.Run({"t": clock, "u": speed[:, 0], "tau_u": push}, name="swim").to_csv(tmp_path / "swim.csv")
    campaign = tmp_path / "campaign.toml"
    campaign.write_text(
        'format = 1\n[model]\ndofs = ["surge"]\neffects = ["inertia", "quadratic_drag"]\n[[run]]\nfile = "swim.csv"\n'
    )
    kept, streamed = (hs.fit(campaign, estimator="integral", stream=stream) for stream in (None, True))
    assert [p.value for p in streamed.parameters] == pytest.approx([p.value for p in kept.parameters], rel=1e-9)
    assert "M214" in {w.code for w in streamed.warnings}
    assert "M214" not in {w.code for w in kept.warnings}
    with pytest.raises(hs.UsageError, match="given by its path"):
        hs.fit(hs.Campaign.from_file(campaign), stream=True)
