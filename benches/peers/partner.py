"""Our side: a process that does one work at a time and tells what it took."""

import json
import subprocess
import tempfile
from pathlib import Path
from typing import Any, Self

import numpy as np


class Partner:
    """A process that is asked line by line: the bench binary `partner`, or `door.py`."""

    def __init__(self, command: list[str]) -> None:
        """Starts it."""
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def __enter__(self) -> Self:
        """Itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Ends it."""
        assert self.process.stdin is not None
        self.process.stdin.close()
        self.process.wait()

    def ask(self, line: str) -> dict[str, Any]:
        """One line there, one line back."""
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()
        answer: dict[str, Any] = json.loads(self.process.stdout.readline())
        if "error" in answer:
            raise RuntimeError(answer["error"])
        return answer

    def data(self, work: str) -> dict[str, np.ndarray]:
        """The arrays of a work, by name."""
        with tempfile.TemporaryDirectory() as folder:
            self.ask(f"data {work} {folder}")
            return {path.stem: np.fromfile(path) for path in Path(folder).glob("*.f64")}
