"""Arrays that carry units: those of pint and astropy, and columns of pint-pandas, each converted by its own library."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ._errors import UsageError


def quantity_of(values: Any) -> Any:
    """What carries units in `values`: itself, the quantity of a column, or a list of quantities as one; else `None`."""
    if _carries(values):
        return values
    inside = getattr(getattr(values, "array", None), "quantity", None)
    if _carries(inside):
        return inside
    if isinstance(values, list | tuple) and values and all(map(_carries, values)):
        kind: Any = type(values[0])
        return kind.from_list(list(values)) if hasattr(kind, "from_list") else kind(values)
    return None


def _carries(values: Any) -> bool:
    return _is_of_pint(values) or _is_of_astropy(values)


def _is_of_pint(values: Any) -> bool:
    return hasattr(values, "magnitude") and hasattr(values, "to_base_units")


def _is_of_astropy(values: Any) -> bool:
    return hasattr(values, "to_value") and hasattr(values, "unit")


def in_si(quantity: Any, name: str, units: Sequence[str] = ()) -> tuple[Any, str]:
    """The numbers of a quantity and their unit: the first of `units` that it can have, else that of SI.

    Raises:
        UsageError: it has another dimension.
    """
    for unit in units or ("",):
        try:
            return _converted(quantity, unit), unit
        except (TypeError, ValueError, AttributeError):
            continue  # what pint and astropy raise for another dimension
    has = quantity.units if _is_of_pint(quantity) else quantity.unit
    raise UsageError(f"{name} is in {has}: {' or '.join(map(_shown, units)) or 'a unit of SI'} is expected")


def _converted(quantity: Any, unit: str) -> Any:
    if _is_of_pint(quantity):
        return (quantity.to(_written(unit)) if unit else quantity.to_base_units()).magnitude
    return quantity.to_value(_written(unit)) if unit else quantity.si.value


def _written(unit: str) -> str:
    return "" if unit == "1" else unit


def _shown(unit: str) -> str:
    return "no unit" if unit == "1" else unit


def without_units(values: Any, name: str, units: Sequence[str] = ()) -> Any:
    """`values` as they are where they carry no units, else their numbers as `in_si` gives them."""
    quantity = quantity_of(values)
    return values if quantity is None else in_si(quantity, name, units)[0]
