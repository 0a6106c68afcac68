"""A model: the effects of a vehicle with their parameters, as a model file holds it."""

from __future__ import annotations

import tomllib
from os import PathLike, fspath
from pathlib import Path
from typing import Any

from ._errors import UsageError
from ._files import write
from ._html import document, html_table
from ._view import Rows, frame, text_table


class Model:
    """A fitted model: the input of `simulate`, `compare`, `monitor`, `plan` and `export`.

    It is the content of a model file, which the command's ``--model`` reads and writes, and is immutable.

    Args:
        text: the TOML of a model file.

    Raises:
        UsageError: not a model file.
    """

    __slots__ = ("_table", "_text")

    _text: str
    _table: dict[str, Any]

    def __init__(self, text: str) -> None:
        try:
            table = tomllib.loads(text)
        except tomllib.TOMLDecodeError as error:
            raise UsageError(f"a model file is expected: {error}") from None
        if "hydrosysid" not in table or "model" not in table:
            raise UsageError("a model file is expected, which has [model] and says which version wrote it")
        object.__setattr__(self, "_text", text)
        object.__setattr__(self, "_table", table)

    @classmethod
    def from_file(cls, path: str | PathLike[str]) -> Model:
        """Reads a model file.

        Raises:
            UsageError: it cannot be read, or is not a model file.
        """
        try:
            return cls(Path(path).read_text(encoding="utf-8"))
        except (OSError, UnicodeDecodeError) as error:
            raise UsageError(f"{fspath(path)}: {error}") from None

    def to_toml(self) -> str:
        """The text of the model file."""
        return self._text

    def save(self, path: str | PathLike[str], *, force: bool = False) -> Path:
        """Writes the model file atomically, and returns its path.

        Args:
            path: file to write.
            force: replace an existing file.

        Raises:
            UsageError: it exists, or cannot be written.
        """
        write(path, self._text.encode(), force)
        return Path(path)

    @property
    def name(self) -> str:
        """Name of the vehicle."""
        return str(self._table.get("vehicle", {}).get("name", ""))

    @property
    def dofs(self) -> list[str]:
        """Degrees of freedom."""
        return list(self._table["model"].get("dofs", []))

    @property
    def effects(self) -> list[str]:
        """Terms, ``id`` or ``id@dof``."""
        return list(self._table["model"].get("effects", []))

    @property
    def envelope(self) -> dict[str, tuple[float, float]]:
        """Smallest and largest value of each channel in the runs of the fit, SI; beyond them the model extrapolates."""
        spans = self._table.get("envelope", {})
        return {name: (span[0], span[1]) for name, span in spans.items() if isinstance(span, list) and len(span) == 2}

    def rows(self) -> Rows:
        """One row per parameter: effect, symbol, value, standard deviation, unit, and whether it was fixed."""
        keys = ("effect", "name", "value", "std", "unit", "fixed")
        return [{key: entry.get(key) for key in keys} for entry in self._table.get("parameter", [])]

    def to_frame(self, library: Any = None) -> Any:
        """The parameters as a data frame of pandas or polars, whichever is in use or installed."""
        return frame(self.rows(), library)

    def __getitem__(self, name: str) -> float:
        """Value of the parameter of this term ``id@dof`` or of this symbol, SI."""
        found = [row for row in self.rows() if name in (row["effect"], row["name"])]
        if len(found) != 1:
            names = ", ".join(row["effect"] for row in found or self.rows())
            raise KeyError(f"{name!r} names {len(found)} parameters; there are {names}")
        return float(found[0]["value"])

    def _title(self) -> str:
        return f"Model of {self.name or 'a vehicle'} in {', '.join(self.dofs)}"

    def __str__(self) -> str:
        return text_table(self.rows(), self._title())

    def __repr__(self) -> str:
        return f"<Model of {self.name!r}: {' '.join(self.dofs)}, {len(self.effects)} terms>"

    def _repr_html_(self) -> str:
        return document(self._title(), [html_table(self.rows())])

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Model) and self._table == other._table

    __hash__ = None  # type: ignore[assignment]

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"a Model does not change: {name} cannot be set")

    def __reduce__(self) -> tuple[Any, ...]:
        return (Model, (self._text,))
