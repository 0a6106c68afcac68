"""Tables that a user gives as mappings: checked key by key, and written as TOML."""

from __future__ import annotations

import json
from collections.abc import Mapping
from os import PathLike, fspath
from typing import Any

import numpy as np

from ._errors import UsageError
from ._quantities import without_units


def settings(value: Any, key: str = "") -> Any:
    """Plain data of a table that a user gave: NumPy's numbers become Python's, those with units SI, and what is no
    setting is refused.

    Raises:
        UsageError: naming the key of a number that is not finite, or of something else than numbers, texts, lists
            and mappings, such as None.
    """
    if isinstance(value, Mapping):
        return {str(name): settings(entry, f"{key}.{name}" if key else str(name)) for name, entry in value.items()}
    value = without_units(value, key)
    if np.ma.is_masked(value):
        raise UsageError(f"{key} holds a masked value: a finite number is expected")
    if isinstance(value, np.ndarray | np.generic):
        return settings(value.tolist(), key)
    if isinstance(value, list | tuple):
        return [settings(entry, f"{key}[{k}]") for k, entry in enumerate(value)]
    if isinstance(value, float) and not np.isfinite(value):
        raise UsageError(f"{key} = {value}: a finite number is expected")
    if isinstance(value, PathLike):
        return fspath(value)
    if isinstance(value, str | bool | int | float):
        return value
    if value is None:
        raise UsageError(f"{key} = None: a number, a text, a list or a mapping is expected; leave the key out instead")
    raise UsageError(f"{key} = {value!r}: a number, a text, a list or a mapping is expected")


def toml_text(table: Mapping[str, Any]) -> str:
    """A mapping of texts, numbers, lists and mappings as TOML; JSON's texts, numbers and lists are TOML's too."""

    def value(entry: Any) -> str:
        if isinstance(entry, Mapping):
            return "{" + ", ".join(f"{json.dumps(str(key))} = {value(v)}" for key, v in entry.items()) + "}"
        return json.dumps(entry, ensure_ascii=False)

    table = settings(table)
    return "".join(f"{json.dumps(str(key))} = {value(entry)}\n" for key, entry in table.items())
