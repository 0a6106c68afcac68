"""Processes of their own: what they say, the CPU they used, and the most memory they held."""

import json
import os
import subprocess
import sys
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Ended:
    """A process that has ended: its last line as JSON where it is one, CPU in seconds, peak memory in MiB."""

    said: dict[str, Any]
    cpu: float
    peak: float


def run(command: list[str], **environment: str) -> Ended:
    """Runs a command to its end, under a small process of its own: a child begins with the memory of its parent on its
    account, and this parent holds the packages of others."""
    holder = [sys.executable, "-S", "-E", __file__, *command]
    done = subprocess.run(holder, stdout=subprocess.PIPE, text=True, env={**os.environ, **environment}, check=True)
    *lines, used = done.stdout.splitlines()
    said = json.loads(lines[-1]) if lines and lines[-1].startswith("{") else {}
    cpu, peak = (float(number) for number in used.split())
    return Ended(said, cpu, peak)


def held(command: list[str]) -> int:
    """Runs a command and adds a line to what it says: CPU in seconds and peak memory in MiB."""
    child = os.spawnvp(os.P_NOWAIT, command[0], command)
    _, status, used = os.wait4(child, 0)
    print(used.ru_utime + used.ru_stime, used.ru_maxrss / 1024)
    return os.waitstatus_to_exitcode(status)


if __name__ == "__main__":
    sys.exit(held(sys.argv[1:]))
