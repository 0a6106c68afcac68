"""The Python package beside its core called from Rust: least squares, a simulation, and a fit from arrays.

python door.py FOLDER, under the Python that has the wheel, does the works that it is asked for on standard input;
python door.py numpy, under the same Python, prints the time of least squares beside NumPy's normal equations;
python door.py PARTNER PYTHON PAGE measures all and renews their section of the page: `make bench-door`. Without the
core (PARTNER is -) what stands beside NumPy is measured alone.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median
from typing import Any

from partner import Partner

WORKS = [
    ("least squares, 1e6 x 5, in C order", "least_squares", "core_least_squares", "1.4"),
    ("least squares, 1e6 x 5, in Fortran order", "least_squares_by_columns", "core_least_squares", "1.4"),
    ("simulate, 1e5 steps of 3 states", "simulate", "core_simulate", "1.1"),
    ("campaign and fit from arrays, 1e5 x 6, integral", "fit", "core_fit", "1.1"),
]
PAIRS = 9
HEADING = "## The door to Python"
ALONE = "Measured apart from the rest of this page, by `make bench-door`."
NO_CORE = (
    "Measured apart from the rest of this page, by `benches/peers/door.py -`: without the works beside the Rust core."
)


def works(folder: Path) -> dict[str, Callable[[], float]]:
    """Each work as a function of nothing; what it returns is the same from Rust."""
    import hydrosysid as hs
    import numpy as np

    arrays = {path.stem: np.fromfile(path) for path in folder.glob("*.f64")}
    by_columns = np.asfortranarray(np.column_stack([arrays[f"h{k}"] for k in range(5)]))
    by_rows, y = np.ascontiguousarray(by_columns), arrays["y"]
    signals = {name.removeprefix("run_"): values for name, values in arrays.items() if name.startswith("run_")}
    coriolis = ["coriolis_surge", "coriolis_sway", "coriolis_yaw"]
    effects = ["inertia", "linear_drag", "quadratic_drag", *coriolis]

    def campaign() -> hs.Campaign:
        return hs.Campaign(dofs=["surge", "sway", "yaw"], effects=effects, runs=[hs.Run(signals)])

    kept, model = campaign(), hs.Model.from_file(folder / "model.toml")
    return {
        "least_squares": lambda: hs.least_squares(by_rows, y).coefficients[0],
        "least_squares_by_columns": lambda: hs.least_squares(by_columns, y).coefficients[0],
        "simulate": lambda: hs.simulate(kept, model).runs[0].simulated["u"][-1],
        "fit": lambda: hs.fit(campaign(), estimator="integral").parameters[0].value,
    }


def serve(folder: Path) -> None:
    """One line of JSON for each line that names a work: its CPU in seconds, and what came out."""
    known = works(folder)
    for line in sys.stdin:
        begin = time.process_time()
        found = known[line.strip()]()
        print(json.dumps({"cpu": time.process_time() - begin, "note": float(found)}), flush=True)


def beside_numpy() -> None:
    """Least squares of 1e6 rows and 5 columns, and the normal equations: ms of CPU, a line of JSON an order."""
    import hydrosysid as hs
    import numpy as np

    random = np.random.default_rng(1)
    columns = random.standard_normal((5, 10**6))
    y = np.arange(1.0, 6.0) @ columns + 0.1 * random.standard_normal(columns.shape[1])
    every_other = np.zeros((10**6, 10))[:, ::2]
    every_other[:] = columns.T
    orders = {"Fortran": columns.T, "C": np.ascontiguousarray(columns.T), "every other column of C": every_other}

    def normal_equations(h: Any) -> Any:
        gram = h.T @ h
        theta = np.linalg.solve(gram, h.T @ y)
        left = y - h @ theta
        return theta, np.sqrt(np.diag(np.linalg.inv(gram)) * (left @ left) / (len(y) - 5))

    def cost(work: Callable[[], Any]) -> float:
        begin = time.process_time()
        work()
        return time.process_time() - begin

    for order, h in orders.items():
        found = hs.least_squares(h, y)
        assert np.allclose([found.coefficients, found.standard_errors], normal_equations(h), rtol=1e-8)
        sides = [lambda h=h: hs.least_squares(h, y), lambda h=h: normal_equations(h)]
        pairs = [[cost(side) for side in sides] for _ in range(PAIRS)]
        ours, theirs = (1e3 * median(pair[k] for pair in pairs) for k in (0, 1))
        ratio = median(b / a for a, b in pairs)
        print(json.dumps({"order": order, "ours": ours, "theirs": theirs, "ratio": ratio}), flush=True)


def numpy_section(python: str) -> list[str]:
    """The table of [`beside_numpy`], by a process with one thread."""
    one = {name: "1" for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "RAYON_NUM_THREADS")}
    done = subprocess.run(
        [python, str(Path(__file__)), "numpy"], env=os.environ | one, check=True, capture_output=True, text=True
    )
    rows = [json.loads(line) for line in done.stdout.splitlines()]
    return [
        f"`hs.least_squares` on a NumPy array of 1e6 x 5, one thread (process CPU, medians of {PAIRS}; goal: 12 ms in",
        "C and Fortran order), beside the normal equations with their deviations in NumPy:",
        "",
        "| order in memory | hs.least_squares, ms | NumPy normal equations, ms | ratio |",
        "|---|---|---|---|",
        *[f"| {r['order']} | {r['ours']:.1f} | {r['theirs']:.1f} | {r['ratio']:.2f} |" for r in rows],
    ]


def section(core: Partner | None, python: str) -> list[str]:
    """The section: beside the core, where it is there, and beside NumPy."""
    beside = [*core_section(core, python), ""] if core else []
    return [HEADING, "", *beside, *numpy_section(python), ""]


def core_section(core: Partner, python: str) -> list[str]:
    """Both sides in turn, each a process of its own; the first pair is not counted."""
    lines = [
        "The same work on the same arrays, called from Python and from Rust (process CPU, medians; the ratio is the",
        "median of the pairs' ratios, Python's over Rust's: at 1 the door costs nothing).",
        "",
        "| work | from Rust, ms | from Python, ms | ratio | goal | pairs |",
        "|---|---|---|---|---|---|",
    ]
    with tempfile.TemporaryDirectory() as folder:
        core.ask(f"data door {folder}")
        with Partner([python, str(Path(__file__)), folder]) as door:
            for work, ours, theirs, goal in WORKS:
                pairs = [(core.ask(theirs), door.ask(ours)) for _ in range(PAIRS + 1)][1:]
                agree(work, *pairs[-1])
                inside, outside = ([side[k]["cpu"] for side in pairs] for k in (0, 1))
                ratio = median(b / a for a, b in zip(inside, outside, strict=True))
                a, b = 1e3 * median(inside), 1e3 * median(outside)
                lines.append(f"| {work} | {a:.2f} | {b:.2f} | {ratio:.2f} | {goal} | {PAIRS} |")
                print(lines[-1], flush=True)
    return lines


def agree(work: str, core: dict[str, Any], door: dict[str, Any]) -> None:
    """Refuses to compare works that come to different results; Rust's is written with seven digits."""
    inside, outside = float(core["note"]), door["note"]
    if abs(inside - outside) > 1e-6 * abs(inside):
        raise RuntimeError(f"{work}: {inside} from Rust, {outside} from Python")


def renewed(page: str, lines: list[str]) -> str:
    """The page with these lines for the section; where there was none they come before the first of the others."""
    start = page.index(HEADING) if HEADING in page else page.index("## ")
    end = page.find("\n## ", start + 1) + 1 if HEADING in page else start
    return page[:start] + "\n".join(lines) + "\n" + page[end or len(page) :]


def main() -> None:
    """Serves, or measures and renews the page."""
    if sys.argv[1:] == ["numpy"]:
        return beside_numpy()
    if len(sys.argv) == 2:
        return serve(Path(sys.argv[1]))
    executable, python, page = sys.argv[1:]
    if executable == "-":
        lines = section(None, python)
    else:
        with Partner([executable, "--bench"]) as core:
            lines = section(core, python)
    text = Path(page).read_text()
    Path(page).write_text(renewed(text, [*lines, NO_CORE if executable == "-" else ALONE, ""]))
    return None


if __name__ == "__main__":
    main()
