"""How cost grows with rows, unknowns, runs and cores: our part alone, every point a process of its own."""

from dataclasses import dataclass

from children import run

ROWS = [10**k for k in range(3, 9)]
# columns of more rows than these are not kept by anybody
KEPT = 10**7
EFFECTS = [5, 10, 20, 50, 100, 200]
RUNS = [1, 10, 100, 1000]


@dataclass(frozen=True)
class Point:
    """One size: seconds of CPU on one core, of wall time on one and on all, peak memory in MiB."""

    work: str
    size: int
    cpu: float
    wall: float
    wall_on_all: float
    peak: float


def point(growth: str, work: str, size: int) -> Point:
    """Does a work twice: on one core and on all."""
    one = run([growth, "--bench", work, str(size)], RAYON_NUM_THREADS="1")
    every = run([growth, "--bench", work, str(size)])
    return Point(
        work,
        size,
        one.said["cpu"],
        one.said["wall"],
        every.said["wall"],
        max(one.peak, every.peak),
    )


def table(points: list[Point], what: str, unit: str, each: float) -> list[str]:
    """Lines of Markdown; the time a unit of the size is told in 1/`each` seconds."""
    lines = [
        f"| {what} | ms | {unit} | peak, MiB | 1 core over all, wall |",
        "|---|---|---|---|---|",
    ]
    lines += [
        f"| {p.size:,} | {1e3 * p.cpu:.2f} | {each * p.cpu / p.size:.1f} "
        f"| {p.peak:.0f} | {p.wall / p.wall_on_all:.2f} |"
        for p in points
    ]
    return [*lines, ""]


def section(growth: str, short: bool) -> list[str]:
    """The section of the page."""
    most = 10**6 if short else ROWS[-1]
    kept = [point(growth, "kept", n) for n in ROWS if n <= min(KEPT, most)]
    streamed = [point(growth, "streamed", n) for n in ROWS if n <= most]
    effects = [point(growth, "effects", n) for n in EFFECTS if not short or n <= 50]
    runs = [point(growth, "runs", n) for n in RUNS if not short or n <= 100]
    return [
        "## How cost grows",
        "",
        "Every point is a process of its own, its memory the most that process held. Times are CPU on one core;",
        "the last column is the wall time on one core over that on all cores (the numbers that come out are the",
        "same to the bit).",
        "",
        "Columns of surge and least squares with five unknowns, columns kept. What is expensive with few rows is the",
        "model, compiled anew; beyond, columns go to pages that are new to the process and are read again, and",
        "memory grows with the rows.",
        "",
        *table(kept, "rows", "ns a row", 1e9),
        "The same, rows generated in blocks of a million and folded as they are made: time in proportion to the",
        "rows, memory that of a block.",
        "",
        *table(streamed, "rows", "ns a row", 1e9),
        "Ten thousand rows with a growing number of unknowns, each a formula of its own with a sine. The sines",
        "grow in proportion, the factorisation with the square: where the time an unknown rises, the",
        "factorisation has overtaken.",
        "",
        *table(effects, "unknowns", "µs an unknown", 1e6),
        "Output error on runs of 60 s at 10 Hz, nine parameters and an initial state every 8 s. Segments are",
        "carried eight side by side and eliminated one by one: time in proportion to the runs.",
        "",
        *table(runs, "runs", "ms a run", 1e3),
    ]
