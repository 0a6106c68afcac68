"""From a log on disk to the coefficients: our command in a stream, and polars with NumPy, each as a process of its own.

python reading.py LOG does the peer's part and prints the seconds of CPU after its imports.
"""

import json
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from statistics import median

from children import Ended, run


@dataclass(frozen=True)
class Reading:
    """Medians of both sides: seconds of CPU, the ratio of each pair, peak memory in MiB."""

    rows: int
    ours: float
    theirs: float
    ratio: float
    our_peak: float
    their_peak: float
    pairs: int


def by_polars(log: str) -> None:
    """Reads the log whole, then NumPy's least squares on trapezoid columns."""
    import polars

    from least_squares import lstsq

    begin = time.process_time()
    table = polars.read_csv(log)
    said = lstsq({name: table[name].to_numpy() for name in ("t", "u", "v", "r", "tau_u")})
    print(json.dumps({"cpu": time.process_time() - begin, "note": said}))


def measured(growth: str, command: str, rows: int, pairs: int) -> Reading:
    """Writes a log of `rows` rows into a folder that goes again and reads it in turn; the first pair is not counted."""
    ours: list[Ended] = []
    theirs: list[Ended] = []
    with tempfile.TemporaryDirectory() as folder:
        run([growth, "--bench", "log", str(rows), folder])
        for _ in range(pairs + 1):
            ours.append(run([command, "fit", f"{folder}/campaign.toml", "--stream", "--quiet"]))
            theirs.append(run([sys.executable, str(Path(__file__)), f"{folder}/log.csv"]))
    ours, theirs = ours[1:], theirs[1:]
    return Reading(
        rows,
        median(a.cpu for a in ours),
        median(b.said["cpu"] for b in theirs),
        median(b.said["cpu"] / a.cpu for a, b in zip(ours, theirs, strict=True)),
        max(a.peak for a in ours),
        median(b.peak for b in theirs),
        pairs,
    )


if __name__ == "__main__":
    by_polars(sys.argv[1])
