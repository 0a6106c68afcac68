"""Discovery on nine runs of 90 s at 10 Hz: ours with the whole catalogue, pysindy's weak form with its linear terms.

pysindy fits surge, sway and yaw as sums of products and of terms x|x| by STLSQ on the weak form, at one threshold.
It knows no shape parameters, states, sensors or held-out runs; what is timed is the least that it can be asked.
"""

from collections.abc import Iterator

import numpy as np
import pysindy as ps
from paired import Row, paired
from partner import Partner


def weak(runs: list[tuple[np.ndarray, np.ndarray, np.ndarray]]) -> str:
    """Fits every run on its own and counts the terms that stay."""
    functions = [lambda x: x, lambda x, y: x * y, lambda x: x * np.abs(x), lambda x, y: x * np.abs(y), lambda x: x**3]
    names = [
        lambda x: x,
        lambda x, y: f"{x}*{y}",
        lambda x: f"{x}|{x}|",
        lambda x, y: f"{x}|{y}|",
        lambda x: f"{x}^3",
    ]
    named = ps.CustomLibrary(library_functions=functions, function_names=names)
    found = 0
    for t, x, tau in runs:
        library = ps.WeakPDELibrary(function_library=named, spatiotemporal_grid=t, K=100)
        model = ps.SINDy(feature_library=library, optimizer=ps.STLSQ(threshold=0.01))
        model.fit(x, t=t, u=tau)
        found += int(np.count_nonzero(model.coefficients()))
    return f"{found} terms in {len(runs)} runs"


def rows(partner: Partner) -> Iterator[Row]:
    """The rows of the table."""
    data = partner.data("discover")
    runs = []
    for k in range(9):
        x = np.stack([data[f"run{k}_{name}"] for name in "uvr"], axis=1)
        tau = np.stack([data[f"run{k}_tau_{name}"] for name in "uvr"], axis=1)
        runs.append((np.linspace(0.0, 0.1 * (len(x) - 1), len(x)), x, tau))
    work = "discovery, nine runs of 90 s, nothing hidden"
    yield paired(partner, work, "discover", "pysindy weak form, linear terms", lambda: weak(runs), goal="3.2", pairs=7)
