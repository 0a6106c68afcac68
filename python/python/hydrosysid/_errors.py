"""Exceptions: what was refused, and where."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from typing import Any

from . import _native
from ._plain import build


@dataclass(frozen=True)
class Finding:
    """A finding about data: a note, a warning or an error.

    Attributes:
        code: stable code, ``L012``.
        kind: kind in words, ``time-not-increasing``.
        severity: ``note``, ``warning`` or ``error``.
        message: one or two sentences that stand alone.
        file: file, as it was given.
        line: physical line, from 1.
        column: canonical name of the column, or the key of an option.
        run: name of the run.
    """

    code: str
    kind: str
    severity: str
    message: str
    file: str | None = None
    line: int | None = None
    column: str | None = None
    run: str | None = None

    def __str__(self) -> str:
        return f"{self.message} [{self.code} {self.kind}]"


class HydrosysidError(ValueError):
    """Base of the errors of this package; a `ValueError`.

    Attributes:
        message: what is wrong and what was expected.
        findings: the same as single findings with file, line and column, where known.
    """

    def __init__(self, message: str, findings: tuple[Finding, ...] = ()) -> None:
        super().__init__(message, findings)
        self.message = message
        self.findings = findings

    def __str__(self) -> str:
        return self.message


class DataError(HydrosysidError):
    """The data was refused, or does not determine the requested result."""


class UsageError(HydrosysidError):
    """The call was wrong: a name, an option, a shape, a file."""


def make(name: str, message: str, findings: str) -> HydrosysidError:
    """The exception that the compiled part raises; `findings` are JSON."""
    kind = {"DataError": DataError, "UsageError": UsageError}[name]
    entries: list[dict[str, Any]] = json.loads(findings)
    return kind(message, tuple(build(Finding, entry) for entry in entries))


@cache
def codes() -> dict[str, dict[str, str]]:
    """What the codes of findings mean: ``code``, ``kind``, ``severity`` and ``meaning``, by code."""
    return {entry["code"]: entry for entry in json.loads(_native.codes_explained())}


def found(code: str, message: str) -> Finding:
    """A finding of a known code."""
    about = codes()[code]
    return Finding(code, about["kind"], about["severity"], message)
