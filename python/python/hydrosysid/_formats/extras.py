"""Libraries that are loaded only when a format needs them."""

from __future__ import annotations

import importlib
from typing import Any

from .._errors import UsageError


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
