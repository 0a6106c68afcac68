"""The Python package beside its core called from Rust: least squares, a simulation, and a fit from arrays.

python door.py FOLDER, under the Python that has the wheel, does the works that it is asked for on standard input;
python door.py PARTNER PYTHON PAGE measures them and renews their section of the page: `make bench-door`.
"""

import json
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


def section(core: Partner, python: str) -> list[str]:
    """Both sides in turn, each a process of its own; the first pair is not counted."""
    lines = [
        HEADING,
        "",
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
    return [*lines, ""]


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
    if len(sys.argv) == 2:
        return serve(Path(sys.argv[1]))
    executable, python, page = sys.argv[1:]
    with Partner([executable, "--bench"]) as core:
        lines = section(core, python)
    text = Path(page).read_text()
    Path(page).write_text(renewed(text, [*lines[:-1], "", ALONE, ""]))
    return None


if __name__ == "__main__":
    main()
