"""The command on a terminal: tables as wide as it is, colour, progress on standard error."""

import os
import subprocess
import sys
from pathlib import Path

import hydrosysid as hs
import pytest

if os.name == "nt":
    pytest.skip("pseudo-terminals of POSIX", allow_module_level=True)

import fcntl
import pty
import select
import struct
import termios


def on_terminal(words: list[str], columns: int, folder: Path, **environment: str) -> tuple[str, str]:
    """What the command writes to a terminal of so many columns: standard output and standard error, a terminal each."""
    sides = [pty.openpty() for _ in range(2)]
    for _, side in sides:
        fcntl.ioctl(side, termios.TIOCSWINSZ, struct.pack("HHHH", 40, columns, 0, 0))
    known = {k: v for k, v in os.environ.items() if k not in ("NO_COLOR", "CLICOLOR", "CLICOLOR_FORCE", "COLUMNS")}
    run = [sys.executable, "-m", "hydrosysid", *words]
    environment = known | {"TERM": "xterm-256color"} | environment
    process = subprocess.Popen(
        run, cwd=folder, env=environment, stdin=sides[0][1], stdout=sides[0][1], stderr=sides[1][1]
    )
    for _, side in sides:
        os.close(side)
    told = [b"", b""]
    open_ends = {end: k for k, (end, _) in enumerate(sides)}
    while open_ends:
        for end in select.select(list(open_ends), [], [])[0]:
            try:
                part = os.read(end, 65536)
            except OSError:  # Linux: the other side is closed
                part = b""
            if part:
                told[open_ends[end]] += part
            else:
                del open_ends[end]
                os.close(end)
    assert process.wait() == 0, told[1].decode()
    return told[0].decode(), told[1].decode()


@pytest.mark.parametrize("columns", [60, 100])
def test_tables_are_as_wide_as_the_terminal(columns: int, folder: Path) -> None:
    out, _ = on_terminal(["fit", "campaign.toml", "--plot"], columns, folder, NO_COLOR="1")
    lines = out.splitlines()
    tables = [line for line in lines if "─" in line]
    assert tables
    widest = max(len(line) for line in lines if not line.startswith(("estimator", "correlated")))
    assert widest <= columns, [line for line in lines if len(line) > columns]
    # a plot takes the width that is there
    assert max(len(line) for line in lines if "└" in line) == columns


def test_colour_and_progress_are_for_terminals(folder: Path) -> None:
    words = ["discover", "campaign.toml"]
    out, err = on_terminal(words, 100, folder)
    assert "judging" in err
    assert "\x1b" in err
    assert "judging" not in out
    _, plain = on_terminal([*words, "--quiet"], 100, folder)
    assert plain == ""
    piped = subprocess.run(
        [sys.executable, "-m", "hydrosysid", *words], cwd=folder, capture_output=True, text=True, check=True
    )
    assert "judging" not in piped.stderr
    assert "\x1b" not in piped.stdout + piped.stderr


def test_no_color_holds_on_a_terminal(folder: Path) -> None:
    text = (folder / "campaign.toml").read_text()
    # far too little data for its parameters: warnings, coloured but for NO_COLOR
    (folder / "few.toml").write_text(text.replace('"quadratic_drag"', '"quadratic_drag", "cubic_drag", "bias"'))
    assert "warning" in on_terminal(["fit", "few.toml"], 100, folder)[1]
    assert "\x1b[1;33m" in on_terminal(["fit", "few.toml"], 100, folder)[1]
    assert "\x1b[1;33m" not in on_terminal(["fit", "few.toml"], 100, folder, NO_COLOR="1")[1]
    assert hs.__version__ in on_terminal(["--version"], 100, folder)[0]
