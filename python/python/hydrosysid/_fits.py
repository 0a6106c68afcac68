"""The result of `map_fit`: many fits, side by side."""

from __future__ import annotations

import importlib
import importlib.util
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from ._fit import Fit
from ._html import html_table, picture
from ._result import Result
from ._view import Z_95, Rows, axes, deviation, text_table

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True, eq=False, repr=False)
class Fits(Result):
    """Fits of many campaigns, in the order of these; one that failed is its error, in its place.

    It has a length, and is iterated and indexed like a list.

    Attributes:
        format: 1.
        names: name of each campaign: of its vehicle, or of its file or folder under the one that all are in.
        results: a `Fit`, or the error, of each campaign: `HydrosysidError`, or what ended its worker.
    """

    format: int
    names: tuple[str, ...]
    results: tuple[Fit | Exception, ...]

    title: ClassVar[str] = "Fits"

    def __len__(self) -> int:
        return len(self.results)

    def __iter__(self) -> Iterator[Fit | Exception]:
        return iter(self.results)

    def __getitem__(self, place: int) -> Fit | Exception:
        """The fit or the error of the campaign at this index."""
        return self.results[place]

    @property
    def done(self) -> list[Fit]:
        """The successful fits."""
        return [result for result in self.results if isinstance(result, Fit)]

    @property
    def failures(self) -> dict[int, Exception]:
        """The errors, by the index of their campaign."""
        return {k: result for k, result in enumerate(self.results) if isinstance(result, Exception)}

    def rows(self) -> Rows:
        """One row per campaign and parameter, and one for a campaign that failed."""

        def of(name: str, result: Fit | Exception) -> Rows:
            if isinstance(result, Exception):
                return [{"campaign": name} | dict.fromkeys(KEYS) | {"error": _told(result)}]
            told = {"converged": result.converged, "error": None}
            return [{"campaign": name} | {key: row[key] for key in KEYS} | told for row in result.rows()]

        return [row for name, result in zip(self.names, self.results, strict=True) for row in of(name, result)]

    @property
    def params(self) -> Any:
        """Estimates, SI: a pandas DataFrame, a row per campaign, a column per parameter; NaN where there is none."""
        return self._wide("params")

    @property
    def bse(self) -> Any:
        """Standard errors in the shape of `params`; 0 for a fixed parameter."""
        return self._wide("bse")

    def _wide(self, attribute: str) -> Any:
        if importlib.util.find_spec("pandas") is None:
            raise ImportError("named numbers need pandas: pip install pandas")
        pandas = importlib.import_module("pandas")
        columns = list(dict.fromkeys(name for fit in self.done for name in fit.names))
        own = [getattr(r, attribute).to_dict() if isinstance(r, Fit) else {} for r in self.results]
        return pandas.DataFrame(own, index=pandas.Index(self.names, name="campaign"), columns=columns, dtype=float)

    def to_dict(self) -> dict[str, Any]:
        """Plain data: of each campaign its name, and its fit or error."""

        def plain(name: str, result: Fit | Exception) -> dict[str, Any]:
            told = {"fit": result.to_dict()} if isinstance(result, Fit) else {"error": _told(result)}
            return {"campaign": name} | told

        return {"format": self.format, "fits": [plain(*one) for one in zip(self.names, self.results, strict=True)]}

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Fits) and self.to_dict() == other.to_dict()

    __hash__ = None

    def __repr__(self) -> str:
        return f"<Fits of {len(self)} campaigns, {len(self.failures)} failed>"

    def _spread_rows(self) -> Rows:
        """One row per parameter: its spread over the campaigns, and the standard errors of the fits."""
        found: dict[str, list[tuple[float, float, str]]] = {}
        loose: set[str] = set()
        for fit in self.done:
            for name, p in zip(fit.names, fit.parameters, strict=True):
                found.setdefault(name, []).append((p.value, p.std or 0.0, p.unit))
            loose.update(() if fit.converged else fit.names)
        rows = []
        for name, entries in found.items():
            values = np.array([value for value, _, _ in entries])
            quantiles = np.quantile(values, [0.05, 0.5, 0.95]).tolist()
            stated = float(np.sqrt(np.mean([std**2 for _, std, _ in entries])))
            spread = float(values.std(ddof=1)) if len(values) > 1 else None
            rows.append(
                {"parameter": name, "fits": len(values), "median": quantiles[1], "5 %": quantiles[0]}
                | {"95 %": quantiles[2], "spread": spread, "typical std": deviation(stated, name not in loose)}
                | {"unit": entries[0][2]}
            )
        return rows

    def _failed_rows(self) -> Rows:
        return [{"place": k, "campaign": self.names[k], "error": _told(e)} for k, e in self.failures.items()]

    def summary(self) -> str:
        """The spread of each parameter over the campaigns, and the failures."""
        failed = [text_table(self._failed_rows(), "Failed")] if self.failures else []
        return "\n".join([self._verdict()[1], text_table(self._spread_rows(), "Over the campaigns"), *failed])

    def _heading(self) -> str:
        return f"Fits of {len(self)} campaigns"

    def _verdict(self) -> tuple[str, str]:
        failed, loose = len(self.failures), sum(not fit.converged for fit in self.done)
        words = f"{len(self) - failed} of {len(self)} fitted"
        words += f", {failed} failed" if failed else ""
        words += f", {loose} not converged" if loose else ""
        return "red" if failed == len(self) and failed else "amber" if failed or loose else "green", words

    def _tables(self) -> list[str]:
        failed = self._failed_rows()
        return [html_table(self._spread_rows(), "Over the campaigns"), html_table(failed, "Failed") if failed else ""]

    def _picture(self) -> str:
        count = len(self._spread_rows())
        return picture(lambda figure: self.plot(ax=figure.add_subplot()), 5.6, 0.8 + 0.3 * count) if self.done else ""

    def plot(self, parameter: str | None = None, ax: Axes | None = None, **style: Any) -> Axes:
        """Each parameter of every campaign relative to its median; for one parameter, its values with 95 % intervals.

        Args:
            parameter: one of the columns of `params`, or its term or symbol; all parameters when absent.
            ax: axes to draw into; new ones when absent.
            style: passed on to `matplotlib.axes.Axes.plot`, or `errorbar` for one parameter.

        Raises:
            KeyError: no such parameter.
        """
        ax = axes(ax)
        if parameter is not None:
            return self._values(parameter, ax, style)
        shown = [(row["parameter"], row["median"]) for row in self._spread_rows() if row["median"] != 0.0]
        places = range(len(shown))[::-1]
        for place, (name, median) in zip(places, shown, strict=True):
            own = [p.value / median for f in self.done for n, p in zip(f.names, f.parameters, strict=True) if n == name]
            look: dict[str, Any] = {"color": "C0", "alpha": max(0.15, min(1.0, 12.0 / len(own))), "markersize": 9}
            ax.plot(own, [place] * len(own), "|", **(look | style))
        ax.axvline(1.0, color="0.3", linewidth=0.8, zorder=0)
        ax.set_yticks(list(places), [name for name, _ in shown])
        ax.set_ylim(-0.6, len(shown) - 0.4)
        ax.set_xlabel("estimate relative to the median of the campaigns")
        return ax

    def _values(self, parameter: str, ax: Axes, style: dict[str, Any]) -> Axes:
        found = [
            (k, p)
            for k, fit in enumerate(self.results)
            if isinstance(fit, Fit)
            for name, p in zip(fit.names, fit.parameters, strict=True)
            if parameter in (name, p.term, p.name)
        ]
        if not found:
            names = ", ".join(row["parameter"] for row in self._spread_rows())
            raise KeyError(f"no parameter {parameter!r}; there are {names}")
        look: dict[str, Any] = {"fmt": "o", "markersize": 3, "elinewidth": 0.8}
        half = [Z_95 * (p.std or 0.0) for _, p in found]
        ax.errorbar([k for k, _ in found], [p.value for _, p in found], yerr=half, **(look | style))
        ax.axhline(float(np.median([p.value for _, p in found])), color="0.3", linewidth=0.8, zorder=0)
        first = found[0][1]
        ax.set(xlabel="campaign", ylabel=f"{first.name}, {first.unit}", title=f"{first.term}, with 95 % intervals")
        return ax


KEYS = ("effect", "name", "value", "std", "unit", "fixed")
"""What the table tells of a parameter."""


def _told(error: Exception) -> str:
    lines = str(error).splitlines()
    return lines[0] if lines else type(error).__name__
