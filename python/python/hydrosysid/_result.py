"""The common base of all results."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, fields
from typing import Any, ClassVar, Literal

from ._errors import Finding
from ._html import document, html_table
from ._plain import plain
from ._view import Rows, frame, latex_table, text_table


@dataclass(frozen=True, eq=False)
class Result(ABC):
    """A result: plain data that can be pickled, compared, tabulated and shown.

    Two results are equal when their `to_dict()` are.
    """

    title: ClassVar[str] = ""

    @abstractmethod
    def rows(self) -> Rows:
        """The main table, one dictionary per row."""

    def to_dict(self) -> dict[str, Any]:
        """Plain data with the keys of the command's ``--json``; NaN becomes `None`."""
        data: dict[str, Any] = plain(self)
        return data

    def to_frame(self, library: Literal["pandas", "polars"] | None = None) -> Any:
        """The main table as a data frame of pandas or polars, whichever is in use or installed."""
        return frame(self.rows(), library)

    def to_latex(self) -> str:
        """The main table as a LaTeX ``tabular``."""
        return latex_table(self.rows())

    def summary(self) -> str:
        """Tables and remarks as text."""
        return "\n".join([text_table(self.rows(), self.title), *self._remarks()])

    def _remarks(self) -> list[str]:
        return [f"{f.severity}: {f}" for f in self._findings()]

    def _findings(self) -> tuple[Finding, ...]:
        found: tuple[Finding, ...] = getattr(self, "errors", ()) + getattr(self, "warnings", ())
        return found

    def _repr_html_(self) -> str:
        light, verdict = self._verdict()
        parts = [*self._tables(), self._picture()]
        return document(self._heading(), parts, light=light, verdict=verdict, findings=self._findings())

    def _heading(self) -> str:
        return self.title

    def _verdict(self) -> tuple[str, str]:
        """The colour of the light (none: empty), and in words what the result comes to."""
        return "", ""

    def _tables(self) -> list[str]:
        """The tables that a notebook shows."""
        return [html_table(self.rows())]

    def _picture(self) -> str:
        """The small picture that a notebook shows; empty where there is nothing to draw."""
        return ""

    def __str__(self) -> str:
        return self.summary()

    def __eq__(self, other: object) -> bool:
        return type(other) is type(self) and plain(self) == plain(other)

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        shown = (f"{f.name}={_brief(getattr(self, f.name))}" for f in fields(self) if f.repr)
        return f"{type(self).__name__}({', '.join(shown)})"


def _brief(value: Any) -> str:
    text = repr(value)
    return (
        text if len(text) <= 60 else f"<{type(value).__name__} of {len(value)}>" if hasattr(value, "__len__") else text
    )
