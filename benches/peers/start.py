"""From nothing to ready: the command's help, and the import of the Python package, as whole processes."""

import subprocess
import sys
import time
from statistics import median


def wall(command: list[str], times: int = 15) -> float:
    """Median of the wall time of a process, s."""
    taken = []
    for _ in range(times):
        begin = time.perf_counter()
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        taken.append(time.perf_counter() - begin)
    return median(taken)


def lines(command: str, python: str) -> list[tuple[str, float, str]]:
    """What, seconds, and the goal."""
    bare = wall([python, "-c", "pass"])
    numpy = wall([python, "-c", "import numpy"])
    ours = wall([python, "-c", "import hydrosysid"])
    # what is imported when it is first asked for
    all_of_it = wall([python, "-c", "from hydrosysid import *"])
    return [
        ("`hydrosysid --version`, whole process", wall([command, "--version"]), "5 ms"),
        ("`python -c pass`, whole process", bare, ""),
        ("`import numpy` beyond an empty process", numpy - bare, ""),
        ("`import hydrosysid` beyond an empty process", ours - bare, "50 ms"),
        ("`from hydrosysid import *` beyond that process, NumPy included", all_of_it - bare, ""),
    ]


if __name__ == "__main__":
    for what, seconds, goal in lines(sys.argv[1], sys.argv[2]):
        print(f"{what:64} {1e3 * seconds:8.1f} ms   {goal}")
