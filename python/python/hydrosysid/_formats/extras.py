"""Libraries that are loaded only when a format needs them."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

from .._errors import DataError, UsageError


class MissingExtra(UsageError, ImportError):
    """A format needs a library that is not installed."""


def needed(module: str, extra: str, what: str) -> Any:
    """The module, or an error that says which extra brings it.

    Raises:
        MissingExtra: it is not installed.
    """
    try:
        return importlib.import_module(module)
    except ImportError as error:
        text = f"{what} need {module.partition('.')[0]}: pip install 'hydrosysid[{extra}]' ({error})"
        raise MissingExtra(text) from None


def read_by(reader: Callable[..., Any], path: Path, *arguments: Any, **options: Any) -> Any:
    """What a library's reader makes of a file.

    Raises:
        UsageError: there is no such file.
        DataError: the library cannot read it; its own words follow the name of the file.
    """
    if not path.exists():
        raise UsageError(f"{path}: there is no such file")
    try:
        return reader(path, *arguments, **options)
    except MissingExtra:
        raise
    except Exception as error:  # libraries raise errors of many kinds for files that are none of theirs
        raise DataError(f"{path}: this file cannot be read: {error}") from None
