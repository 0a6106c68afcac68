"""How far each part is from what the machine gives: bytes and flops by hand, instructions by callgrind."""

import os
import re
import shutil
import subprocess
from dataclasses import dataclass

from children import run

ROWS, STEPS, LANES = 1_000_000, 6_000, 16

# t, u, v, r and tau of a row are read once, 8 bytes each
BYTES_A_ROW = 40
# Columns: two products, and 3 for each of four trapezoids, 1 for the increment. QR of six columns: 2 for each product
# of two of them (21), 2 for each subtraction (15); scale and size of each value 3.
FLOPS_A_ROW = 2 + 4 * 3 + 1 + 2 * 21 + 2 * 15 + 3 * 6
# 11 for each of three accelerations in each of four stages, 2 for each of three states to go on to the next stage, and
# 6 for each of three to sum up, as written by hand.
FLOPS_A_STEP = 4 * 33 + 3 * 6 + 3 * 6


@dataclass(frozen=True)
class Part:
    """A part: seconds a unit, the least a unit could take, why, and instructions a unit where they were counted."""

    name: str
    unit: str
    seconds: float
    least: float
    bound: str
    instructions: float | None


def instructions(growth: str, work: str, size: int, units: int) -> float | None:
    """Instructions a unit: two passes less one, under callgrind; nothing where it is not installed."""
    if shutil.which("valgrind") is None:
        return None

    def counted(passes: int) -> int:
        command = [
            "valgrind",
            "--tool=callgrind",
            "--callgrind-out-file=/dev/null",
            growth,
            "--bench",
            work,
            str(size),
        ]
        environment = {**os.environ, "PASSES": str(passes), "RAYON_NUM_THREADS": "1"}
        told = subprocess.run(command, check=True, capture_output=True, text=True, env=environment).stderr
        found = re.search(r"Collected : (\d+)", told)
        assert found is not None
        return int(found.group(1))

    return (counted(2) - counted(1)) / units


def parts(growth: str) -> tuple[list[Part], float, float]:
    """The parts, bytes a second of a copy, flops a second of sums of products."""

    def seconds(work: str, size: int) -> float:
        return float(run([growth, "--bench", work, str(size)], RAYON_NUM_THREADS="1").said["cpu"])

    # 128 MiB on either side: more than any cache
    numbers = 1 << 24
    bandwidth = 16 * numbers / seconds("copy", numbers)
    rounds = 1 << 22
    arithmetic = 2 * 64 * rounds / seconds("arithmetic", rounds)
    by_memory, by_arithmetic = BYTES_A_ROW / bandwidth, FLOPS_A_ROW / arithmetic
    bound = "memory" if by_memory > by_arithmetic else "arithmetic"
    # few rows are counted: a count does not depend on the noise of the machine
    counted_rows = 50_000
    listed = [
        Part(
            "columns and QR, five unknowns",
            "row",
            seconds("streamed", ROWS) / ROWS,
            max(by_memory, by_arithmetic),
            bound,
            instructions(growth, "folded", counted_rows, counted_rows),
        ),
        Part(
            "RK4, one trajectory",
            "step",
            seconds("rk4", STEPS) / STEPS,
            FLOPS_A_STEP / arithmetic,
            "arithmetic",
            instructions(growth, "rk4", STEPS, STEPS),
        ),
        Part(
            "RK4, sixteen side by side",
            "step of one",
            seconds("ensemble", STEPS) / (STEPS * LANES),
            FLOPS_A_STEP / arithmetic,
            "arithmetic",
            instructions(growth, "ensemble", STEPS, STEPS * LANES),
        ),
    ]
    return listed, bandwidth, arithmetic


def section(growth: str) -> list[str]:
    """The section of the page."""
    listed, bandwidth, arithmetic = parts(growth)
    lines = [
        "## Limits",
        "",
        f"One core copies {bandwidth / 1e9:.1f} GB/s (read and written) and does {arithmetic / 1e9:.0f} Gflop/s of",
        f"sums of products. A row of the columns reads {BYTES_A_ROW} bytes and takes {FLOPS_A_ROW} flops with its QR;",
        f"a planar step of RK4 takes {FLOPS_A_STEP} as written by hand. The last column is how many times longer a",
        "part takes than that alone would. A single trajectory cannot come near: each stage waits for the one before, some",
        "twenty cycles at least. Instructions are those of a machine without AVX-512, as callgrind counts them.",
        "",
        "| part | ns | least, ns | bound by | instructions | times the least |",
        "|---|---|---|---|---|---|",
    ]
    for p in listed:
        counted = "not counted" if p.instructions is None else f"{p.instructions:.0f} a {p.unit}"
        times = f"{p.seconds / p.least:.1f}"
        lines.append(f"| {p.name} | {1e9 * p.seconds:.2f} | {1e9 * p.least:.2f} | {p.bound} | {counted} | {times} |")
    return [*lines, ""]
