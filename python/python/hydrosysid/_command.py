"""The ``hydrosysid`` command of the wheel: the same as that of the crate."""

from __future__ import annotations

import signal
import sys

from . import _native


def main() -> int:
    """Runs the command with the arguments of the process; returns its exit code."""
    # compiled work does not look at Python's signals: Ctrl-C ends the process as it does any other command
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _native.command(["hydrosysid", *sys.argv[1:]])
