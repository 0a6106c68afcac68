"""Effects of your own, as formulas or as Python functions that are read into one."""

from __future__ import annotations

import inspect
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ._between import read_at
from ._errors import UsageError
from ._run import Run

# how tightly an operator binds, as the formulas of a campaign are read
_SUM, _PRODUCT, _SIGN, _POWER, _ATOM = 5, 7, 9, 11, 13
_COMPARE, _NOT = 3, 9

_BINARY: Mapping[str, tuple[str, int, bool]] = {
    # name of the ufunc: operator, binding, whether a right operand of the same binding needs brackets
    "add": ("+", _SUM, False),
    "subtract": ("-", _SUM, True),
    "multiply": ("*", _PRODUCT, False),
    "divide": ("/", _PRODUCT, True),
    "greater": (">", _COMPARE, True),
    "less": ("<", _COMPARE, True),
    "greater_equal": (">=", _COMPARE, True),
    "less_equal": ("<=", _COMPARE, True),
    "logical_and": ("&&", 2, False),
    "logical_or": ("||", 1, False),
}
_FUNCTIONS: Mapping[str, str] = {
    "absolute": "abs",
    "fabs": "abs",
    "sign": "sign",
    "sin": "sin",
    "cos": "cos",
    "tan": "tan",
    "arctan": "atan",
    "tanh": "tanh",
    "exp": "exp",
    "log": "ln",
    "sqrt": "sqrt",
    "minimum": "min",
    "maximum": "max",
    "fmin": "min",
    "fmax": "max",
}


class Symbol(np.lib.mixins.NDArrayOperatorsMixin):
    """Stands for a channel while a function is read into a formula; operators and NumPy's functions extend its text."""

    __slots__ = ("_binding", "_text")

    def __init__(self, text: str, binding: int = _ATOM) -> None:
        self._text = text
        self._binding = binding

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **options: Any) -> Symbol:
        if method != "__call__" or options:
            raise UntraceableError(f"numpy.{ufunc.__name__} cannot be part of a formula in this form")
        parts = [_part(x) for x in inputs]
        name = ufunc.__name__
        if name in _BINARY:
            return _binary(*_BINARY[name], *parts)
        if name in _FUNCTIONS:
            return Symbol(f"{_FUNCTIONS[name]}({', '.join(p._text for p in parts)})")
        if name in ("power", "float_power"):
            # the operator binds to the right and above a sign
            return Symbol(f"{_bracketed(parts[0], _ATOM)}^{_bracketed(parts[1], _ATOM)}", _POWER)
        if name == "square":
            return Symbol(f"{_bracketed(parts[0], _ATOM)}^2", _POWER)
        if name == "reciprocal":
            return Symbol(f"1/{_bracketed(parts[0], _PRODUCT + 1)}", _PRODUCT)
        if name == "arctan2":
            raise UntraceableError("numpy.arctan2 has no formula; write it with arctan")
        if name == "negative":
            return Symbol(f"-{_bracketed(parts[0], _POWER)}", _SIGN)
        if name == "positive":
            return parts[0]
        if name == "logical_not":
            return Symbol(f"!{_bracketed(parts[0], _POWER)}", _NOT)
        raise UntraceableError(f"numpy.{name} has no formula; there are {', '.join(sorted({*_FUNCTIONS}))}")

    def __bool__(self) -> bool:
        raise UntraceableError(
            "the function branches on a value (if, and, or, max): write it with comparisons, minimum and maximum"
        )

    def __float__(self) -> float:
        raise UntraceableError("the function converts to a number (float, math): use numpy's functions")

    __int__ = __float__
    __index__ = __float__

    def __iter__(self) -> Any:
        raise UntraceableError("the function iterates over the samples: write it for whole arrays")

    def __array__(self, *_: Any, **__: Any) -> NDArray[Any]:
        raise UntraceableError("the function makes an array from a channel: use operators and numpy's ufuncs")

    def __repr__(self) -> str:
        return f"<Symbol {self._text}>"


class UntraceableError(TypeError):
    """A function that cannot be read into a formula; the message says where it stops."""


class OwnEffect:
    """An effect of your own: a force or moment proportional to a formula, with one parameter.

    A function is converted to a formula once by calling it with symbols: its arguments have the names of states, forces
    and channels, and it may use operators and NumPy's functions. What cannot be converted (``if``,
    loops, look-up tables) is evaluated beforehand on each run, where all its arguments are logged.

    Args:
        id: a name, unlike those of the catalogue.
        dof: degree of freedom in whose balance it acts.
        formula: a formula, or a function of arrays that is converted to one.
        unit: unit of the parameter that multiplies it, such as ``kg/m``.
        role: ``candidate`` is tried by `discover`, ``baseline`` is in the model from the start.

    Raises:
        UsageError: a function whose arguments have no names.

    >>> import numpy as np
    >>> def sail(wind_speed, wind_dir, psi):
    ...     return wind_speed**2 * np.cos(wind_dir - psi)
    >>> OwnEffect("sail", "surge", sail, unit="kg/m").formula
    'wind_speed^2*cos(wind_dir - psi)'
    """

    __slots__ = ("_why", "dof", "formula", "function", "id", "role", "unit")

    def __init__(
        self,
        id: str,
        dof: str,
        formula: str | Callable[..., Any],
        *,
        unit: str,
        role: Literal["candidate", "baseline"] = "candidate",
    ) -> None:
        self.id, self.dof, self.unit, self.role = id, dof, unit, role
        self.function = None if isinstance(formula, str) else formula
        self.formula: str | None
        """The formula; `None` if the function cannot be converted to one."""
        self._why = ""
        if isinstance(formula, str):
            self.formula = formula
            return
        try:
            self.formula = _part(formula(*map(Symbol, self.arguments)))._text
        except UntraceableError as error:
            self.formula, self._why = None, str(error)

    @property
    def arguments(self) -> tuple[str, ...]:
        """Names of the channels that the function reads; empty for a formula."""
        if self.function is None:
            return ()
        parameters = inspect.signature(self.function).parameters.values()
        named = (inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.POSITIONAL_ONLY)
        if any(p.kind not in named for p in parameters):
            raise UsageError(f"effect {self.id!r}: name each argument of the function as the channel it reads")
        return tuple(p.name for p in parameters)

    def table(self) -> dict[str, str]:
        """The ``[[effect]]`` table of a campaign file."""
        formula = self.formula if self.formula is not None else self.id
        return {"id": self.id, "dof": self.dof, "formula": formula, "unit": self.unit, "role": self.role}

    def evaluated_on(self, run: Run, *, held: bool = False) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Time stamps of the first argument's channel, and the values of the function there.

        Args:
            run: a run that logs all arguments.
            held: commands keep their value until the next sample, as with ``input = "hold"``; else interpolated
                linearly between samples, like all other channels.

        Raises:
            UsageError: the function does not return one value per sample.
        """
        time = run[self.arguments[0]][0]
        read = [read_at(time, name, *run[name], held=held) for name in self.arguments]
        assert self.function is not None
        values = np.asarray(self.function(*read), dtype=np.float64)
        if values.shape != time.shape:
            raise UsageError(f"effect {self.id!r}: the function returned {values.shape} for {time.shape} samples")
        return time, values

    def __repr__(self) -> str:
        return f"<OwnEffect {self.id}@{self.dof}: {self.formula or 'evaluated on the runs'}>"


def prepared(
    own: Sequence[OwnEffect | Mapping[str, Any]], runs: Iterable[Run], dofs: Sequence[str], *, held: bool
) -> tuple[list[dict[str, Any]], tuple[Run, ...]]:
    """The ``[[effect]]`` tables, and the runs with a channel for each function that is no formula.

    `held` says whether commands are held between samples.
    """
    kept = tuple(runs)
    tables: list[dict[str, Any]] = []
    for effect in own:
        if not isinstance(effect, OwnEffect):
            tables.append(dict(effect))
            continue
        tables.append(effect.table())
        if effect.formula is None:
            kept = tuple(_with_channel(effect, run, dofs, held) for run in kept)
            warnings.warn(
                f"effect {effect.id!r} is no formula ({effect._why}): it was evaluated on the logged "
                f"{', '.join(effect.arguments)} beforehand",
                stacklevel=3,
            )
    return tables, kept


_STATES: Mapping[str, tuple[str, ...]] = {
    "surge": ("u",),
    "sway": ("v",),
    "heave": ("w",),
    "roll": ("p", "phi"),
    "pitch": ("q", "theta"),
    "yaw": ("r", "psi"),
}


def _with_channel(effect: OwnEffect, run: Run, dofs: Sequence[str], held: bool) -> Run:
    simulated = [name for name in effect.arguments if any(name in _STATES.get(dof, ()) for dof in dofs)]
    absent = [name for name in effect.arguments if name not in run.channels]
    where = f"effect {effect.id!r} is no formula ({effect._why})"
    if simulated:
        raise UsageError(f"{where}, and {', '.join(simulated)} is simulated: only a formula can follow it")
    if absent or not effect.arguments:
        raise UsageError(f"{where}, and run {run.name!r} does not log {', '.join(absent) or 'anything it reads'}")
    return run.with_channels({effect.id: effect.evaluated_on(run, held=held)})


def _part(x: Any) -> Symbol:
    if isinstance(x, Symbol):
        return x
    if isinstance(x, bool | np.bool_ | int | float | np.integer | np.floating) and np.isfinite(x):
        value = float(x)
        text = str(int(value)) if value.is_integer() and abs(value) < 1e15 else repr(value)
        return Symbol(text, _SIGN if value < 0 else _ATOM)
    raise UntraceableError(f"{type(x).__name__} cannot stand in a formula")


def _bracketed(part: Symbol, least: int) -> str:
    return part._text if part._binding >= least else f"({part._text})"


def _binary(operator: str, binding: int, strict: bool, a: Symbol, b: Symbol) -> Symbol:
    # comparisons do not chain
    left = _bracketed(a, binding + (binding == _COMPARE))
    right = _bracketed(b, binding + strict)
    space = "" if binding == _PRODUCT else " "
    return Symbol(f"{left}{space}{operator}{space}{right}", binding)
