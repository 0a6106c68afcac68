"""Files written atomically; an existing file is replaced only on request."""

from __future__ import annotations

import os
from os import PathLike
from pathlib import Path

from ._errors import UsageError


def may_write(path: str | PathLike[str], force: bool) -> Path:
    """The path, if a file may be written there.

    Raises:
        UsageError: there is a file already.
    """
    place = Path(path)
    if place.exists() and not force:
        raise UsageError(f"{place} exists: choose another name, or replace it with force")
    return place


def write(path: str | PathLike[str], data: bytes, force: bool = False) -> None:
    """Writes a file: beside its place first, then under its name.

    Raises:
        UsageError: there is a file already, or it cannot be written.
    """
    place = may_write(path, force)
    beside = place.with_name(f".{place.name}.{os.getpid()}")
    try:
        beside.write_bytes(data)
        beside.replace(place)
    except OSError as error:
        raise UsageError(f"{place} cannot be written: {error.strerror}") from None
    finally:
        # what is left where it could not be written, or Ctrl-C came first
        beside.unlink(missing_ok=True)
