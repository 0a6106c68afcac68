"""Models as files for other tools, against each other, against the literature and along new logs."""

import ast
import csv
import io
import json
import pickle
import xml.etree.ElementTree as xml
from pathlib import Path

import hydrosysid as hs
import numpy as np
import pytest


@pytest.fixture(scope="module")
def fit(campaign: hs.Campaign) -> hs.Fit:
    return hs.fit(campaign)


def values(fit: hs.Fit) -> dict[str, float]:
    return {p.effect: p.value for p in fit.parameters}


SPHERE = {"inertia": (10.0, 12.0, 14.0)}


def test_fossens_module_moves_as_the_model(fit: hs.Fit) -> None:
    made = hs.export(fit, "fossen-python", **SPHERE)
    module: dict[str, object] = {}
    exec(compile(made.text, "vehicle", "exec"), module)  # the file is meant to be imported
    nu_dot = module["nu_dot"]
    assert callable(nu_dot)
    assert np.all(np.linalg.eigvalsh(module["M"]) > 0.0)
    own = values(fit)
    t = np.arange(0.0, 40.0, 0.1)

    def force(time: float) -> float:
        return 60.0 + 80.0 * float(np.sin(0.5 * time))

    def theirs(time: float, nu: np.ndarray) -> np.ndarray:
        return nu_dot(np.zeros(6), nu, [force(time), 0.0, 0.0, 0.0, 0.0, 0.0])

    def ours(time: float, u: np.ndarray) -> np.ndarray:
        drag = own["linear_drag"] * u + own["quadratic_drag"] * u * np.abs(u)
        return (force(time) - drag) / own["inertia"]

    path = hs.rk4(theirs, t, np.zeros(6), substeps=2)
    # one integrator, one equation: rounding of eleven digits in the file
    np.testing.assert_allclose(path[:, 0], hs.rk4(ours, t, np.zeros(1), substeps=2)[:, 0], atol=1e-8)
    assert np.abs(path[:, 1:]).max() == 0.0
    nu = np.array([0.5, -0.3, 0.2, 0.1, 0.4, -0.2])
    assert abs(nu @ module["C"](nu) @ nu) < 1e-12, "Coriolis forces do no work"


def test_gazebo_is_read_back_as_xml(fit: hs.Fit, tmp_path: Path) -> None:
    path = tmp_path / "vehicle.sdf"
    made = hs.export(fit, "gazebo", path, link="hull", **SPHERE)
    plugin = xml.parse(path).getroot().find("model/plugin")
    assert plugin is not None
    own = values(fit)
    read = {element.tag: element.text for element in plugin}
    assert read["link_name"] == "hull"
    # eleven digits are written
    assert float(read["xU"]) == pytest.approx(-own["linear_drag"], rel=1e-10)
    assert float(read["xUabsU"]) == pytest.approx(-own["quadratic_drag"], rel=1e-10)
    assert float(read["xDotU"]) == pytest.approx(150.0 - own["inertia"], rel=1e-8)
    assert made.lost == ()
    assert {w.code for w in made.warnings} >= {"X004", "X012"}
    assert pickle.loads(pickle.dumps(made)) == made


def test_linear_models_are_the_same_in_every_file(fit: hs.Fit, tmp_path: Path) -> None:
    at = {"u": 0.5}
    told = json.loads(hs.export(fit, "linear-json", at=at).text)
    own = values(fit)
    slope = -(own["linear_drag"] + 2.0 * own["quadratic_drag"] * 0.5) / own["inertia"]
    assert told["A"][0][0] == pytest.approx(slope, rel=1e-12)
    tree = ast.parse(hs.export(fit, "linear-python", at=at).text)
    written = {
        node.targets[0].id: ast.literal_eval(node.value)  # type: ignore[attr-defined]
        for node in tree.body
        if isinstance(node, ast.Assign)
    }
    np.testing.assert_allclose(written["A"], told["A"], rtol=1e-10)
    np.testing.assert_allclose(written["TAU0"], told["tau0"], rtol=1e-10)
    scipy_io = pytest.importorskip("scipy.io")
    path = tmp_path / "linear.mat"
    hs.export(fit, "linear-mat", path, at=at)
    matrices = scipy_io.loadmat(path)
    for name in "ABCD":
        np.testing.assert_array_equal(matrices[name], told[name])
    assert [text.strip() for text in matrices["states"]] == told["states"]


def test_tables_are_read_back(fit: hs.Fit) -> None:
    text = hs.export(fit, "csv").text
    rows = list(csv.DictReader(io.StringIO("".join(k for k in text.splitlines(True) if not k.startswith("#")))))
    assert [float(row["value"]) for row in rows] == pytest.approx([p.value for p in fit.parameters], rel=1e-10)
    assert hs.export(fit, "latex").text.count(r"\\") == len(rows) + 1


def test_what_cannot_be_exported_is_told(fit: hs.Fit, folder: Path) -> None:
    with pytest.raises(hs.UsageError, match="there are gazebo"):
        hs.export(fit, "simulink")
    with pytest.raises(hs.UsageError, match=r"Stonefish is not a target: .* cannot represent .* `c-header`"):
        hs.export(fit, "stonefish")
    with pytest.raises(hs.UsageError, match="--inertia"):
        hs.export(fit, "uuv")
    with pytest.raises(hs.UsageError, match="no `w`"):
        hs.export(fit, "linear-json", at={"w": 1.0})
    with pytest.raises(hs.UsageError, match=r"\[\[thruster\]\]"):
        hs.export(folder / "campaign.toml", "ardusub")


def test_a_model_does_not_differ_from_itself(fit: hs.Fit) -> None:
    same = hs.compare_models(fit, fit, names=("one", "other"))
    assert same.joint is not None
    assert (same.joint.chi_squared, same.joint.degrees_of_freedom) == (0.0, 3)
    assert same.a == "one"
    assert all(p.z == 0.0 and p.interval is not None for p in same.parameters)
    assert len(same.rows()) == 3
    labels = [label.get_text() for label in same.plot().get_yticklabels()]
    assert "inertia@surge m_u" in labels


def test_published_parameters_stand_beside_the_own_ones(campaign: hs.Campaign, fit: hs.Fit) -> None:
    params = {"format": 1, "convention": "sname", "parameters": {"X_u|u|": {"value": -200.0, "std": 4.0}}}
    found = hs.compare_published(campaign, params, fit)
    drag = next(p for p in found.parameters if p.sname == "X_u|u|")
    assert (drag.published, drag.published_std) == (200.0, 4.0)
    assert drag.z is not None
    assert drag.z > 5.0
    assert max(r.rms for r in found.runs) > 3.0 * max(r.rms for r in found.own_runs)
    with pytest.raises(hs.UsageError, match="did you mean"):
        hs.compare_published(campaign, {**params, "parameters": {"X_uu": -1.0}}, fit)


def test_a_log_is_watched(campaign: hs.Campaign, fit: hs.Fit, runs: list[hs.Run]) -> None:
    fine = hs.monitor(campaign, fit)
    assert fine.fits
    assert fine.reasons == ()
    t, u = runs[0]["u"]
    weak = hs.Run(t=t, u=u, tau_u=1.6 * runs[0]["tau_u"][1], name="weak", kind="oscillatory", role="validate")
    new = hs.Campaign(
        vehicle={"name": "small", "mass": 150.0},
        dofs=["surge"],
        effects=["inertia", "linear_drag", "quadratic_drag"],
        runs=[weak],
    )
    found = hs.monitor(new, fit, window=10.0)
    assert not found.fits
    assert found.changes[0].dof == "surge"
    assert found.reasons
    assert "no longer fits" in found.summary()
    assert found.plot().get_title() == "weak"
    assert found.rows()[0]["from"] == pytest.approx(0.0)
    assert pickle.loads(pickle.dumps(found)) == found
    with pytest.raises(hs.UsageError, match="window"):
        hs.monitor(new, fit, window=0.0)
