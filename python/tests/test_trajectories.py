"""What is long crosses from the compiled part as arrays, with the numbers of the command."""

import csv
import json
import subprocess
import sys
from pathlib import Path

import hydrosysid as hs
import numpy as np
import pytest


@pytest.fixture(scope="module")
def fit(campaign: hs.Campaign) -> hs.Fit:
    return hs.fit(campaign)


def columns(arrays: tuple[object, ...]) -> list[np.ndarray]:
    """The arrays of an entry, those of its dictionaries among them."""
    flat = [list(part.values()) if isinstance(part, dict) else [part] for part in arrays]
    return [array for part in flat for array in part]


@pytest.mark.parametrize("verb", ["simulate", "components"])
def test_trajectories_cross_as_arrays(verb: str, campaign: hs.Campaign, fit: hs.Fit) -> None:
    told, entries = getattr(campaign._native, verb)(fit.model.to_toml(), None)
    runs = json.loads(told)["runs"]
    assert len(runs) == len(entries) == 3
    for run, arrays in zip(runs, entries, strict=True):
        found = columns(arrays)
        assert len(found) >= 4
        assert all(type(a) is np.ndarray and a.dtype == np.float64 and a.shape == (600,) for a in found)
        assert run["time"] == []
        assert all(not values for values in run.values() if isinstance(values, list | dict))


def hydrosysid(folder: Path, *words: str) -> str:
    done = subprocess.run(
        [sys.executable, "-m", "hydrosysid", *words], cwd=folder, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_a_simulation_is_that_of_the_command_to_the_bit(fit: hs.Fit, folder: Path) -> None:
    fit.model.save(folder / "model.toml")
    campaign = folder / "campaign.toml"
    told = hydrosysid(folder, "simulate", "campaign.toml", "--model", "model.toml", "--json", "-", "--quiet")
    simulation = hs.simulate(campaign, folder / "model.toml")
    assert simulation.to_dict() == json.loads(told)
    # the band begins with the first sample after two seconds: null before, NaN here
    assert np.isnan(simulation["surge_3.csv"].std["u"]).sum() == 21
    compared = hs.compare(campaign, folder / "model.toml")
    assert compared.simulation == simulation


def test_forces_are_those_of_the_command(fit: hs.Fit, folder: Path) -> None:
    fit.model.save(folder / "model.toml")
    words = ["simulate", "campaign.toml", "--model", "model.toml", "--forces", "forces", "--quiet"]
    hydrosysid(folder, *words)
    for forces in hs.force_components(folder / "campaign.toml", folder / "model.toml"):
        assert (forces.dof, forces.unit) == ("surge", "N")
        (written,) = (folder / "forces").glob(f"{Path(forces.run).stem}*")
        with written.open(newline="") as file:
            table = list(csv.DictReader(file))
        names = {"total": forces.total, "u": forces.velocity} | forces.terms
        for name, values in names.items():
            column = next(key for key in table[0] if key.split(" ")[0] == name)
            assert [float(row[column]) for row in table] == values.tolist()
        np.testing.assert_allclose(sum(forces.terms.values()), forces.total, rtol=1e-12, atol=1e-9)
