"""Ours and others side by side, and the page that tells it: `make bench`.

python run.py PARTNER GROWTH COMMAND PYTHON [--parts FILE] [--write FILE] [--short]
"""

import argparse
import importlib.metadata as metadata
import platform
import sys
from collections.abc import Iterator
from pathlib import Path

import bootstrap
import discovery
import door
import growth
import limits
import motion
import output_error
import reading
import start
from paired import Row
from partner import Partner

import least_squares

PEERS = ["numpy", "scipy", "statsmodels", "numba", "casadi", "pysindy", "polars"]
WORKS = [least_squares, bootstrap, motion, output_error, discovery]


def processor() -> str:
    """Name of the processor, as the system tells it."""
    told = Path("/proc/cpuinfo")
    lines = told.read_text().splitlines() if told.exists() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return f"{names[0]}, {len(names)} threads" if names else platform.processor() or platform.machine()


def measured(partner: Partner) -> Iterator[Row]:
    """Every row, printed as it comes."""
    for work in WORKS:
        for row in work.rows(partner):
            print(
                f"{row.work:46} {row.peer:32} {1e3 * row.ours:10.3f} ms  {row.ratio:8.2f} x",
                flush=True,
            )
            if row.note:
                print(f"    {row.note}", file=sys.stderr)
            yield row


def page(
    rows: list[Row],
    read: reading.Reading,
    starts: list[tuple[str, float, str]],
    sections: list[str],
    parts: str | None,
) -> str:
    """docs/benchmarks.md."""
    versions = ", ".join(f"{name} {metadata.version(name)}" for name in PEERS)
    lines = [
        "# Benchmarks",
        "",
        "Written by `make bench`. Both sides work on the same numbers in turn; each time is the median of process CPU",
        "over the pairs, each ratio the median of the pairs' ratios (theirs over ours: above 1 we are faster).",
        "Machines are noisy: read the ratios.",
        "",
        f"Machine: {processor()}. Python {platform.python_version()}, {versions}.",
        "",
        "| work | beside | ours, ms | theirs, ms | ratio | goal | pairs |",
        "|---|---|---|---|---|---|---|",
    ]
    lines += [
        f"| {r.work} | {r.peer} | {1e3 * r.ours:.3f} | {1e3 * r.theirs:.3f} | {r.ratio:.2f} | {r.goal} | {r.pairs} |"
        for r in rows
    ]
    lines += [
        "",
        "From a log on disk, seven columns with six decimals, to five coefficients with their deviations, each side a",
        "process of its own (the peer's without its imports):",
        "",
        "| rows | beside | ours, s | theirs, s | ratio | goal | peak memory, ours | theirs | pairs |",
        "|---|---|---|---|---|---|---|---|---|",
        f"| {read.rows:,} | polars read, NumPy lstsq | {read.ours:.2f} | {read.theirs:.2f} | {read.ratio:.2f} | 1 | "
        + f"{read.our_peak:.0f} MiB | {read.their_peak:.0f} MiB | {read.pairs} |",
    ]
    lines += ["", "| start | ms, wall | goal |", "|---|---|---|"]
    lines += [f"| {what} | {1e3 * seconds:.1f} | {goal} |" for what, seconds, goal in starts]
    lines += ["", *sections]
    if parts:
        lines += [
            "## Parts",
            "",
            "Our parts, as rows grow (median wall time; the last column should be flat):",
            "",
            "```text",
        ]
        lines += [line for line in parts.splitlines() if line.strip()]
        lines += [
            "```",
            "",
            "Where the column bends: few rows pay for what does not depend on them, systems of up to 4,096 entries are",
            "refined and those of up to 32,768 solved whole. From 1e5 steps on a trajectory goes to pages that are new to",
            "the process at every call, a page fault every 90 steps; fits by integrals keep their columns, which leave the",
            "caches there.",
        ]
    return "\n".join(lines) + "\n"


def main() -> None:
    """Measures and writes."""
    asked = argparse.ArgumentParser()
    asked.add_argument("partner")
    asked.add_argument("growth")
    asked.add_argument("command")
    asked.add_argument("python")
    asked.add_argument("--parts", type=Path)
    asked.add_argument("--write", type=Path)
    asked.add_argument("--short", action="store_true", help="small sizes, to see that everything runs")
    given = asked.parse_args()
    with Partner([given.partner, "--bench"]) as partner:
        rows = list(measured(partner))
        doors = door.section(partner, given.python)
    read = reading.measured(given.growth, given.command, *((10**5, 1) if given.short else (10**7, 7)))
    starts = start.lines(given.command, given.python)
    sections = doors + growth.section(given.growth, given.short) + limits.section(given.growth)
    text = page(rows, read, starts, sections, given.parts.read_text() if given.parts else None)
    if given.write:
        given.write.write_text(text)
    else:
        print(text)


if __name__ == "__main__":
    main()
