"""Between plain data, as JSON holds it, and the typed results."""

from __future__ import annotations

import dataclasses
import types
import typing
from collections.abc import Mapping
from typing import Any, TypeVar

import numpy as np

T = TypeVar("T")


def key_of(field: dataclasses.Field[Any]) -> str:
    """Key of a field in JSON: its name, but for words that Python keeps for itself."""
    return str(field.metadata.get("key", field.name))


def build(kind: type[T], data: Mapping[str, Any]) -> T:
    """An instance of the dataclass `kind` from plain data; absent keys are left at their default."""
    hints = typing.get_type_hints(kind)
    fields = dataclasses.fields(kind)  # type: ignore[arg-type]
    values = {f.name: _value(hints[f.name], data[key_of(f)]) for f in fields if key_of(f) in data}
    return kind(**values)


def _value(hint: Any, data: Any) -> Any:
    origin, arguments = typing.get_origin(hint), typing.get_args(hint)
    if origin in (types.UnionType, typing.Union):
        return None if data is None else _value(next(a for a in arguments if a is not type(None)), data)
    if origin is np.ndarray:
        # null stands for what is not a number
        return np.array(data, dtype=float)
    if origin is tuple:
        return tuple(_value(arguments[0], entry) for entry in data)
    if origin is dict:
        return {name: _value(arguments[1], entry) for name, entry in data.items()}
    if dataclasses.is_dataclass(hint):
        return build(typing.cast("type[Any]", hint), data)
    if hint is float:
        return np.nan if data is None else float(data)
    return data


def plain(value: Any) -> Any:
    """Plain data again: dictionaries, lists, numbers, texts. Optional keys that say nothing are left out."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        fields = [f for f in dataclasses.fields(value) if not f.metadata.get("own", False)]
        shown = [(f, getattr(value, f.name)) for f in fields]
        return {key_of(f): plain(v) for f, v in shown if not (_optional(f) and _absent(v))}
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, tuple | list):
        return [plain(entry) for entry in value]
    if isinstance(value, Mapping):
        return {name: plain(entry) for name, entry in value.items()}
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value


def _optional(field: dataclasses.Field[Any]) -> bool:
    return field.default is not dataclasses.MISSING or field.default_factory is not dataclasses.MISSING


def _absent(value: Any) -> bool:
    return value is None or value is False or (isinstance(value, dict | tuple) and not value)
