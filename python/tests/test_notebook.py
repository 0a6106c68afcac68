"""The notebooks of the book run from top to bottom, hold no output, and say what is true."""

import json
from pathlib import Path
from typing import Any

import matplotlib as mpl
import pandas as pd
import pytest

mpl.use("Agg")

import matplotlib.pyplot as plt

BOOK = Path(__file__).resolve().parents[2] / "docs"
NOTEBOOKS = [BOOK / "paper.ipynb", *sorted((BOOK / "gallery").glob("*.ipynb"))]


def cells(path: Path) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = json.loads(path.read_text(encoding="utf-8"))["cells"]
    return found


def run(path: Path) -> dict[str, Any]:
    """What stands in a notebook once all of it has run; under ``figures`` how many figures it has drawn."""
    plt.close("all")
    space: dict[str, Any] = {}
    for cell in cells(path):
        if cell["cell_type"] == "code":
            source = "".join(cell["source"])
            exec(compile(source, f"{path.name} {cell['id']}", "exec"), space)
    space["figures"] = len(plt.get_fignums())
    plt.close("all")
    return space


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.name)
def test_it_holds_no_output(path: Path) -> None:
    assert all(cell["outputs"] == [] and cell["execution_count"] is None for cell in cells(path) if "outputs" in cell)
    assert len({cell["id"] for cell in cells(path)}) == len(cells(path))


def test_the_book_lists_every_notebook() -> None:
    page = (BOOK / "README.md").read_text(encoding="utf-8")
    assert all(f"({path.relative_to(BOOK).as_posix()})" in page for path in NOTEBOOKS)


def test_a_first_fit() -> None:
    names = run(BOOK / "gallery" / "first-fit.ipynb")
    assert names["table"]["inside"].tolist() == [True] * 6
    assert abs(names["correlation"]) < 0.1
    assert [ax.get_ylabel() for ax in names["panels"]] == ["u, m/s", "r, rad/s"]
    assert names["figures"] == 1


def test_what_is_missing() -> None:
    names = run(BOOK / "gallery" / "what-is-missing.ipynb")
    found = names["found"]
    assert [(e.id, e.common_name) for e in found.effects] == [("coriolis_yaw", "the Munk moment")]
    # m_v − m_u of the truth
    (munk,) = found.effects[0].parameters
    assert abs(munk.value - 120.0) < 4.0 * munk.std
    rms = names["rms"]
    assert (rms["with the Munk moment"] < 0.05 * rms["baseline"]).all()


def test_how_sure_an_estimate_is() -> None:
    names = run(BOOK / "gallery" / "how-sure.ipynb")
    assert names["shared"] == names["alone"]
    deviations = names["deviations"]
    assert len(deviations) == 6
    # 40 draws show a deviation to a ninth, and stretches are few: within a factor of two
    for way in ("bootstrap", "monte carlo"):
        assert (deviations[way] / deviations["covariance"]).between(0.5, 2.0).all()


@pytest.mark.filterwarnings("ignore")  # those of Dask's own start and end
def test_a_fleet_on_a_cluster(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RAYON_NUM_THREADS", "1")  # the notebook sets it: undone at the end
    names = run(BOOK / "gallery" / "fleet.ipynb")
    fits = names["fits"]
    assert (len(fits), list(fits.failures)) == (200, [77])
    assert fits.names[77] == "day-077"
    assert "line 3, column tau_u" in str(fits[77])
    assert fits.params.shape == (200, 3)
    truth = pd.Series([names["drag"](day) for day in range(200)], index=fits.names)
    off = ((fits.params - truth.to_frame().to_numpy()) / fits.bse)["quadratic_drag@surge k_u|u|"].dropna()
    assert off.abs().quantile(0.9) < 3.0
    assert names["clean"] == pytest.approx(100.0, abs=1.0)
    assert names["slope"] == pytest.approx(0.4, rel=0.02)


def test_logs_as_they_come() -> None:
    names = run(BOOK / "gallery" / "logs-as-they-come.ipynb")
    assert names["guessed"].channels == ("psi", "r", "tau_u", "u")
    assert (names["mapped"]["psi"][1] == names["guessed"]["psi"][1]).all()
    assert names["sparse"]["u"][1].tolist() == names["masked"]["u"][1].tolist() == [0.1, 0.3, 0.4]


@pytest.fixture(scope="module")
def names() -> dict[str, Any]:
    return run(BOOK / "paper.ipynb")


@pytest.mark.parametrize(("table", "rows"), [(3, 6), (5, 12), (7, 6), (9, 8), (10, 6)])
def test_estimates_stand_within_their_deviations_of_what_is_printed(
    names: dict[str, Any], table: int, rows: int
) -> None:
    found = names[f"table_{table}"]
    assert len(found) == rows
    # the printed values are the truth of the runs; some forty estimates of one seed
    assert found["z"].abs().max() < 3.5, found


def test_the_other_tables_say_what_the_paper_says(names: dict[str, Any]) -> None:
    efficiency = names["table_2"]
    assert (efficiency["estimate"] - efficiency["printed"]).abs().max() < 0.005
    curve = names["figure_5"].dropna()
    assert ((curve["coef"] - curve["printed"]).abs() < 4.0 * curve["std err"].astype(float)).all()
    crossed: pd.DataFrame = names["table_6"]
    errors = crossed["mean |error|, m/s"]
    assert len(errors) == 4
    # a model is best on the run that it was made from
    assert errors.idxmin() == 0
    direct = names["table_11"]
    assert len(direct) == 10
    # the fit of everything at once goes wrong, and its condition says so
    assert direct["z"].abs().max() > 3.5
    assert all(at_once > 10.0 * staged for _, staged, at_once in names["conditions"])
    assert names["figures"] == 7
