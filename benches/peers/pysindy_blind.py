"""pysindy on the campaigns in which effects are hidden: `pysindy_blind.py FOLDER --write FILE`.

It is given what it cannot find: the nominal model with its *true* values. What is left of the momentum,

    yᵢ(t) = mᵢ νᵢ − ∫ (τᵢ + Coriolis − drag) dt,        dyᵢ/dt = Σ ξ_k f_k,

is regressed on a library of terms by pysindy's weak form (`WeakPDELibrary`) and `STLSQ`, its threshold chosen by leaving
one training run out at a time. A term that stays is a name. The library holds the terms of the catalogue that are linear
in their parameters; what has a shape, a state or stands in a sensor it cannot hold, and is told apart in the table.
"""

import argparse
import csv
import json
import time
import tomllib
import warnings
from pathlib import Path

import numpy as np
import pysindy as ps

DOFS = ("surge", "sway", "yaw")
VELOCITY = {"surge": "u", "sway": "v", "yaw": "r"}
WINDOWS = 150
THRESHOLDS = np.geomspace(1e-3, 1.0, 16)
Log = dict[str, np.ndarray]
Feature = tuple[str, np.ndarray]


def log_of(path: Path) -> Log:
    """The columns of a run by name, without their units."""
    with path.open(newline="") as file:
        names = [name.split(" [")[0] for name in next(csv.reader(file))]
        table = np.loadtxt(file, delimiter=",")
    return dict(zip(names, table.T, strict=True))


def nominal(log: Log, values: dict[str, float], present: set[str]) -> dict[str, np.ndarray]:
    """Momentum less the impulse of all that the baseline knows, by degree of freedom."""
    u, v, r = (log[VELOCITY[dof]] for dof in DOFS)
    m = {dof: values[f"inertia@{dof}"] for dof in DOFS}
    coriolis = {"surge": m["sway"] * v * r, "sway": -m["surge"] * u * r, "yaw": -(m["sway"] - m["surge"]) * u * v}
    left = {}
    for dof in DOFS:
        x = log[VELOCITY[dof]]
        force = log[f"tau_{VELOCITY[dof]}"].copy()
        force -= values.get(f"linear_drag@{dof}", 0.0) * x * (f"linear_drag@{dof}" in present)
        force -= values.get(f"quadratic_drag@{dof}", 0.0) * x * np.abs(x) * (f"quadratic_drag@{dof}" in present)
        force += coriolis[dof] * (f"coriolis_{dof}" in present)
        steps = 0.5 * (force[1:] + force[:-1]) * np.diff(log["t"])
        left[dof] = m[dof] * x - np.concatenate([[0.0], np.cumsum(steps)])
    return left


def features(log: Log, dof: str, present: set[str]) -> list[Feature]:
    """The terms of one degree of freedom, each with the name of the effect that it stands for."""
    x = log[VELOCITY[dof]]
    tau = log[f"tau_{VELOCITY[dof]}"]
    a, b = (other for other in DOFS if other != dof)
    psi, one = log["psi"], np.ones_like(x)
    east, north = log["y"] - log["y"][0], log["x"] - log["x"][0]
    terms: list[Feature] = [
        (f"bias@{dof}", one),
        (f"linear_drag@{dof}", x),
        (f"quadratic_drag@{dof}", x * np.abs(x)),
        (f"cubic_drag@{dof}", x**3),
        (f"drag_asymmetry@{dof}", x * np.abs(x) * (x < 0)),
        (f"coulomb_friction@{dof}", np.tanh(x / 0.01)),
        (f"coriolis_{dof}", log[VELOCITY[a]] * log[VELOCITY[b]]),
        (f"thrust_reverse_loss@{dof}", tau * (tau < 0)),
        (f"thrust_advance_loss@{dof}", tau * np.abs(x)),
        (f"thrust_interaction_loss@{dof}", tau),
        (f"tether_drag@{dof}", log["z"] * x * np.abs(x)),
    ]
    for other in (a, b):
        y = log[VELOCITY[other]]
        terms += [
            (f"linear_cross_damping@{dof}:{other}", y),
            (f"cross_drag@{dof}:{other}", y * np.abs(y)),
            (f"mixed_drag@{dof}:{other}", np.abs(y) * x),
            (f"thrust_crosstalk@{dof}:{other}", log[f"tau_{VELOCITY[other]}"]),
        ]
    if dof == "surge":
        terms += [("tether_spring", north * np.cos(psi) + east * np.sin(psi)), ("restoring_surge", np.sin(log["theta"]))]
    if dof == "sway":
        terms += [("tether_spring", -north * np.sin(psi) + east * np.cos(psi))]
    known = {f"linear_drag@{dof}", f"quadratic_drag@{dof}", f"coriolis_{dof}"} & present
    return [term for term in terms if term[0] not in known]


def weak(t: np.ndarray, terms: np.ndarray, left: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Weak features and targets of one run, by pysindy's library."""
    np.random.seed(1)  # the same windows for every run
    identity = ps.CustomLibrary(library_functions=[lambda x: x], function_names=[lambda x: x])
    library = ps.WeakPDELibrary(function_library=identity, spatiotemporal_grid=t, K=WINDOWS)
    array = ps.utils.AxesArray(terms, {"ax_time": 0, "ax_coord": 1})
    target = ps.utils.AxesArray(left, {"ax_time": 0, "ax_coord": 1})
    columns = np.asarray(library.fit_transform([array])[0])
    return columns, np.asarray(library.convert_u_dot_integral(target))


def sparse(a: np.ndarray, b: np.ndarray, threshold: float) -> np.ndarray:
    """STLSQ at a threshold on coefficients in units of what each column explains alone; 0 where nothing stays."""
    optimizer = ps.STLSQ(threshold=threshold, alpha=1e-8)
    optimizer.fit(a, b[:, None])
    return np.asarray(optimizer.coef_)[0]


def stays(blocks: list[tuple[np.ndarray, np.ndarray]]) -> np.ndarray:
    """Which columns stay at the threshold that predicts left-out runs best."""
    size = np.sqrt(np.mean(np.concatenate([a for a, _ in blocks]) ** 2, axis=0))
    scale = np.sqrt(np.mean(np.concatenate([b for _, b in blocks]) ** 2))
    scaled = [(a / np.where(size > 0, size, 1.0), b / max(scale, 1e-300)) for a, b in blocks]
    errors = np.zeros(len(THRESHOLDS))
    for k in range(len(scaled)):
        a = np.concatenate([one for i, (one, _) in enumerate(scaled) if i != k])
        b = np.concatenate([one for i, (_, one) in enumerate(scaled) if i != k])
        for i, threshold in enumerate(THRESHOLDS):
            errors[i] += np.sum((scaled[k][1] - scaled[k][0] @ sparse(a, b, threshold)) ** 2)
    # of equals the sparsest
    best = len(errors) - 1 - int(np.argmin(errors[::-1]))
    a, b = (np.concatenate([block[part] for block in scaled]) for part in (0, 1))
    return sparse(a, b, THRESHOLDS[best]) != 0


def answer(folder: Path) -> tuple[list[str], bool]:
    """The names of a campaign, and whether the library holds all that is hidden."""
    campaign = tomllib.loads((folder / "campaign.toml").read_text())
    truth = json.loads((folder / "truth.json").read_text())
    values = {one["effect"]: one["value"] for one in truth["parameters"]}
    listed = campaign["model"]["effects"]
    present = {f"{e}@{d}" for e in listed for d in DOFS} | set(listed)
    runs = [log_of(folder / run["file"]) for run in campaign["run"] if run["role"] == "train"]
    own = {dof: [name for name, _ in features(runs[0], dof, present)] for dof in DOFS}
    blocks: dict[str, list[tuple[np.ndarray, np.ndarray]]] = {dof: [] for dof in DOFS}
    for log in runs:
        columns = [column for dof in DOFS for _, column in features(log, dof, present)]
        left = nominal(log, values, present)
        a, b = weak(log["t"], np.stack(columns, axis=1), np.stack([left[dof] for dof in DOFS], axis=1))
        first = 0
        for k, dof in enumerate(DOFS):
            blocks[dof].append((a[:, first : first + len(own[dof])], b[:, k]))
            first += len(own[dof])
    names = {name for dof in DOFS for name, stay in zip(own[dof], stays(blocks[dof]), strict=True) if stay}
    held = {name for dof in DOFS for name in own[dof]}
    return sorted(names), set(truth["hidden"]) <= held


def main() -> None:
    """Answers every campaign of a folder."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--write", type=Path, required=True)
    asked = parser.parse_args()
    warnings.filterwarnings("ignore")
    with asked.write.open("w") as file:
        for line in (asked.folder / "index.jsonl").read_text().splitlines():
            entry = json.loads(line)
            begin = time.process_time()
            named, held = answer(asked.folder / entry["folder"])
            seconds = time.process_time() - begin
            record = {"cell": entry["cell"], "seed": entry["seed"], "named": named, "held": held, "seconds": seconds}
            file.write(json.dumps(record) + "\n")
            file.flush()


if __name__ == "__main__":
    main()
