"""Processes of their own: what they say, the CPU they used, and the most memory they held."""

import json
import os
import subprocess
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Ended:
    """A process that has ended: its last line as JSON where it is one, CPU in seconds, peak memory in MiB."""

    said: dict[str, Any]
    cpu: float
    peak: float


def run(command: list[str], **environment: str) -> Ended:
    """Runs a command to its end."""
    child = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env={**os.environ, **environment})
    assert child.stdout is not None
    lines = child.stdout.read().splitlines()
    child.stdout.close()
    _, status, used = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode != 0:
        raise RuntimeError(f"{command[0]} ended with {child.returncode}")
    said = json.loads(lines[-1]) if lines and lines[-1].startswith("{") else {}
    return Ended(said, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024)
