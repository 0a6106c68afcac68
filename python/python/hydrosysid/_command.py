"""The ``hydrosysid`` command of the wheel: that of the crate, and the formats that only Python reads and writes."""

from __future__ import annotations

import argparse
import json
import os
import signal
import sys
import tempfile
import tomllib
from pathlib import Path
from typing import Any

from . import _native
from ._convert import as_json, convert
from ._errors import DataError, HydrosysidError, UsageError
from ._files import may_write, write
from ._formats import is_known
from ._run import Run
from ._scaffold import campaign_file, scaffold
from ._series import mcap_of

FIGURES = ("mass", "volume", "weight", "buoyancy", "length")
"""Dry figures of a vehicle that `init` takes."""


def main() -> int:
    """Runs the command with the arguments of the process; returns its exit code."""
    # compiled work does not look at Python's signals: Ctrl-C ends the process as it does any other command
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return run_with(sys.argv[1:])


def run_with(arguments: list[str]) -> int:
    """Runs the command with these arguments; returns its exit code: 0 done, 1 the data was refused, 2 wrong use."""
    try:
        # those whose logs are in formats that the crate does not read
        typed = _typed(arguments, "init")
        if typed is not None and any(map(is_known, typed.logs)):
            _use_threads(typed.jobs)
            return _init(typed)
        typed = _typed(arguments, "convert")
        if typed is not None and is_known(typed.log):
            _use_threads(typed.jobs)
            return _convert(typed)
        place = _mcap_series(arguments)
        if place is not None:
            return _with_mcap(arguments, *place)
    except HydrosysidError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1 if isinstance(error, DataError) else 2
    return _native.command(["hydrosysid", *arguments])


def _typed(arguments: list[str], verb: str) -> argparse.Namespace | None:
    """What was typed for `verb`; `None` where it is another verb, or help or a mistake, of which the crate tells."""
    if verb not in arguments or "--help" in arguments or "-h" in arguments:
        return None
    parser = argparse.ArgumentParser(prog="hydrosysid", add_help=False, exit_on_error=False, allow_abbrev=False)
    parser.add_argument("verb")
    parser.add_argument("-o", "--output", type=Path)
    if verb == "init":
        parser.add_argument("logs", type=Path, nargs="+")
        parser.add_argument("--vehicle")
        parser.add_argument("--name", default="")
        for figure in FIGURES:
            parser.add_argument(f"--{figure}", type=float)
    else:
        parser.add_argument("log", type=Path)
        parser.add_argument("place", type=Path, nargs="?")
        parser.add_argument("--map", type=Path)
    parser.add_argument("--log", dest="options", action="append", default=[])
    parser.add_argument("--msg", action="append", default=[])
    parser.add_argument("--json", type=Path)
    parser.add_argument("-j", "--jobs", type=_threads)
    for flag in ("--strict", "--force", "--no-color"):
        parser.add_argument(flag, action="store_true")
    parser.add_argument("-q", "--quiet", action="store_true")
    try:
        typed, unknown = parser.parse_known_args(arguments)
    except argparse.ArgumentError:
        return None
    return typed if not unknown and typed.verb == verb else None


def _threads(text: str) -> int:
    """A number of threads, at most that of the cores."""
    count = int(text)
    if count < 1:
        raise ValueError(text)
    return min(count, os.cpu_count() or count)


def _use_threads(count: int | None) -> None:
    """Limits the threads of this process; all cores when `None`."""
    if count is not None:
        # the pool of the compiled part is made at its first use, and asks this variable
        os.environ["RAYON_NUM_THREADS"] = str(count)


def _reading(typed: argparse.Namespace) -> dict[str, Any]:
    """The options of ``[log]`` that were typed.

    Raises:
        UsageError: they are not TOML.
    """
    try:
        options = tomllib.loads("\n".join(typed.options))
    except tomllib.TOMLDecodeError as error:
        raise UsageError(f"--log: {error}") from None
    return options | ({"msg": typed.msg} if typed.msg else {})


def _json_file(typed: argparse.Namespace) -> Path | None:
    """Where the result goes as JSON; `None` without one, and for standard output."""
    place: Path | None = typed.json
    return None if place is None or str(place) == "-" else place


def _refuse(warnings: int) -> None:
    """What ``--strict`` says of warnings, as the crate says it."""
    if warnings:
        counted = "1 warning" if warnings == 1 else f"{warnings} warnings"
        raise DataError(f"{counted}, and --strict treats warnings as errors")


def _init(typed: argparse.Namespace) -> int:
    if typed.output is None:
        raise UsageError("give the folder or campaign file to write with -o")
    options, json_file = _reading(typed), _json_file(typed)
    if json_file is not None:
        may_write(json_file, typed.force)

    def told(warnings: list[str]) -> None:
        for warning in () if typed.quiet else warnings:
            print(f"warning: {warning}", file=sys.stderr)
        _refuse(len(warnings) if typed.strict else 0)

    about = (typed.name, tuple(getattr(typed, figure) for figure in FIGURES), typed.vehicle)
    msg = options.pop("msg", ())
    text = scaffold(typed.logs, typed.output, about, options, msg=msg, force=typed.force, told=told)
    file, guesses = campaign_file(typed.output), text.count("# guessed:")
    result = json.dumps({"format": 1, "file": str(file), "campaign": text, "guesses": guesses}, indent=2)
    if json_file is not None:
        write(json_file, result.encode(), typed.force)
    elif typed.json is not None:
        print(result)
    if not typed.quiet and (typed.json is None or json_file is not None):
        place = typed.output if typed.output == file else file.parent
        print(f"{file} written, with {guesses} guess{'' if guesses == 1 else 'es'} to check (`# guessed:`)")
        print(f"next: hydrosysid check {place}")
    return 0


def _convert(typed: argparse.Namespace) -> int:
    output = typed.output or typed.place
    if output is None:
        raise UsageError("give the file to write with -o")
    options, json_file = _reading(typed), _json_file(typed)
    for place in (output, json_file):
        if place is not None:
            may_write(place, typed.force)
    run = convert(typed.log, map=typed.map, **options)
    warnings = [finding for finding in run.findings if finding.severity == "warning"]
    if not typed.quiet:
        for finding in run.findings:
            print(f"{finding.severity}: {finding}", file=sys.stderr)
    _refuse(len(warnings) if typed.strict else 0)
    run.to_csv(output, force=typed.force)
    if typed.json is not None and json_file is None:
        print(as_json(run))
    elif json_file is not None:
        write(json_file, as_json(run).encode(), typed.force)
    if not typed.quiet and (typed.json is None or json_file is not None):
        rows = len({t for stamps, _ in run.signals.values() for t in stamps.tolist()})
        print(f"{output}: {rows} rows, {len(run.channels)} channels: {', '.join(run.channels)}")
        print(f"next: hydrosysid init {output} -o {output.with_suffix('')}")
    return 0


def _mcap_series(arguments: list[str]) -> tuple[int, Path] | None:
    """Where ``--series`` names an MCAP file: place of the argument that does, and the file."""
    for k, word in enumerate(arguments):
        name = word.partition("=")[2] if word.startswith("--series=") else None
        if word == "--series" and k + 1 < len(arguments):
            k, name = k + 1, arguments[k + 1]
        if name is not None and name.lower().endswith(".mcap"):
            return k, Path(name)
    return None


def _with_mcap(arguments: list[str], at: int, output: Path) -> int:
    """Runs the command with its series as CSV, and writes them as MCAP."""
    force = "--force" in arguments
    may_write(output, force)
    with tempfile.TemporaryDirectory() as folder:
        beside = Path(folder) / "series.csv"
        word = f"--series={beside}" if arguments[at].startswith("--series=") else str(beside)
        code = _native.command(["hydrosysid", *arguments[:at], word, *arguments[at + 1 :]])
        if code == 0:
            write(output, mcap_of(Run.from_csv(beside, missing="no_sample", name="series")), force)
        return code
