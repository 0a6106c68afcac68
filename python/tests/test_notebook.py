"""The notebook of the paper runs from top to bottom, holds no output, and its tables agree with what is printed."""

import json
from pathlib import Path
from typing import Any

import matplotlib as mpl
import pandas as pd
import pytest

mpl.use("Agg")

import matplotlib.pyplot as plt

NOTEBOOK = Path(__file__).resolve().parents[2] / "docs" / "paper.ipynb"


@pytest.fixture(scope="module")
def names() -> dict[str, Any]:
    """What stands in the notebook once all of it has run."""
    plt.close("all")
    space: dict[str, Any] = {}
    cells = json.loads(NOTEBOOK.read_text(encoding="utf-8"))["cells"]
    for cell in cells:
        if cell["cell_type"] == "code":
            source = "".join(cell["source"])
            exec(compile(source, f"{NOTEBOOK.name} {cell['id']}", "exec"), space)
    space["figures"] = len(plt.get_fignums())
    plt.close("all")
    return space


def test_it_holds_no_output() -> None:
    cells = json.loads(NOTEBOOK.read_text(encoding="utf-8"))["cells"]
    assert all(cell["outputs"] == [] and cell["execution_count"] is None for cell in cells if "outputs" in cell)


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
