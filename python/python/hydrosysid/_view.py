"""How results show themselves: text tables, LaTeX, data frames, charts."""

from __future__ import annotations

import importlib
import importlib.util
import math
import sys
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Rows = list[dict[str, Any]]
Z_95 = 1.96
"""Half-width of a 95 % interval in standard deviations of a normal: for estimates from large logs."""


def frame(rows: Rows, library: Literal["pandas", "polars"] | None = None) -> Any:
    """A data frame of rows: of the library asked for, else of the one that is in use or installed, pandas first."""
    names = ("pandas", "polars") if library is None else (library,)
    loaded = [name for name in names if name in sys.modules]
    there = loaded or [name for name in names if importlib.util.find_spec(name) is not None]
    if not there:
        raise ImportError(f"a data frame needs {' or '.join(names)}: pip install {names[0]}")
    made = importlib.import_module(there[0]).DataFrame
    # polars looks at a hundred rows only unless told otherwise
    return made(rows) if there[0] == "pandas" else made(rows, infer_schema_length=None)


def labelled(values: Any, names: list[str], columns: list[str] | None = None) -> Any:
    """Numbers under names: a Series of pandas, or a DataFrame where columns have names, too."""
    if importlib.util.find_spec("pandas") is None:
        raise ImportError("named numbers need pandas: pip install pandas")
    pandas = importlib.import_module("pandas")
    if columns is None:
        return pandas.Series(values, index=names, dtype=float)
    return pandas.DataFrame(values, index=names, columns=columns, dtype=float)


def stacked(parts: Sequence[tuple[tuple[str, ...], Any, Any]], levels: Sequence[str], name: str) -> Any:
    """Series of numbers, each under its own names and over its own stamps, as one Series of pandas."""
    if importlib.util.find_spec("pandas") is None:
        raise ImportError("named numbers need pandas: pip install pandas")
    pandas = importlib.import_module("pandas")
    series = {names: pandas.Series(values, index=stamps) for names, stamps, values in parts}
    # sorted, so that a part is found by its names without a search
    return pandas.concat(series, names=levels).rename(name).sort_index()


def number(value: Any) -> str:
    """Four significant digits; a blank for what is absent."""
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return ""
    if isinstance(value, bool):
        return "yes" if value else ""
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, list | tuple):
        return ", ".join(number(v) for v in value)
    return str(value)


LEAST_P = 1e-15
"""Least probability that is told, as on the terminal: those below it are this small at most."""
PROBABILITIES = ("p_value", "P>|z|")
"""Heads of columns that hold probabilities, none of which is 0."""
UNSETTLED = "?"
"""What stands behind a deviation of a fit that did not converge, as on the terminal."""


def probability(p: float) -> str:
    """A probability in words.

    >>> probability(0.0123), probability(0.0)
    ('p = 0.012', 'p < 1e-15')
    """
    return f"p < {LEAST_P:g}" if p <= LEAST_P else f"p = {p:.2g}"


def cell(row: Mapping[str, Any], head: str) -> str:
    """What a table shows of a row under this head."""
    value = row.get(head)
    if head in PROBABILITIES and isinstance(value, float) and value <= LEAST_P:
        return f"<{LEAST_P:g}"
    return number(value)


def deviation(std: float | None, converged: bool) -> float | str | None:
    """A deviation for a table, marked where the estimator did not converge, for then it is none."""
    return std if converged or std is None else f"{number(std)} {UNSETTLED}"


def is_numeric(rows: Rows, head: str) -> bool:
    """Whether a column holds numbers and blanks alone."""
    return all(isinstance(row.get(head), int | float | None) for row in rows)


def text_table(rows: Rows, title: str = "") -> str:
    """A table in the shape that statsmodels' users know: rules above, below and under the heads."""
    if not rows:
        return title
    heads = list(rows[0])
    cells = [[cell(row, head) for head in heads] for row in rows]
    numeric = [is_numeric(rows, head) for head in heads]
    widths = [max(len(h), *(len(line[k]) for line in cells)) for k, h in enumerate(heads)]

    def line(entries: Sequence[str]) -> str:
        parts = [e.rjust(w) if n else e.ljust(w) for e, w, n in zip(entries, widths, numeric, strict=True)]
        return "  ".join(parts).rstrip()

    width = sum(widths) + 2 * (len(widths) - 1)
    body = ["=" * width, line(heads), "-" * width, *(line(c) for c in cells), "=" * width]
    return "\n".join(([title.center(width).rstrip()] if title else []) + body)


_LATEX = {"\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}"} | {
    c: "\\" + c for c in "&%$#_{}"
}


def latex(text: str) -> str:
    """Text with LaTeX's own characters escaped."""
    return "".join(_LATEX.get(c, c) for c in text)


def latex_table(rows: Rows) -> str:
    """A `tabular` with one line a row."""
    heads = list(rows[0]) if rows else []
    signs = "".join("r" if is_numeric(rows, head) else "l" for head in heads)
    lines = [heads, *([cell(row, head) for head in heads] for row in rows)]
    body = [" & ".join(latex(text) for text in line) + r" \\" for line in lines]
    body.insert(1, r"\hline")
    return "\n".join([rf"\begin{{tabular}}{{{signs}}}", *body, r"\end{tabular}"])


def axes(ax: Axes | None) -> Axes:
    """The axes given, or new ones."""
    return new_figure().add_subplot() if ax is None else ax


def new_figure(width: float | None = None, height: float | None = None) -> Figure:
    """A new figure, of so many inches. Matplotlib is loaded here and nowhere earlier."""
    try:
        import matplotlib.pyplot as plt
    except ImportError as error:
        raise ImportError("plots need matplotlib: pip install 'hydrosysid[plot]'") from error
    size = None if width is None or height is None else (width, height)
    return plt.figure(figsize=size, layout="constrained")


def bars(ax: Axes | None, found: Sequence[tuple[str, float]], line: float, label: str, style: dict[str, Any]) -> Axes:
    """A bar a (name, value), from the top, with a line at the value to compare with."""
    ax = axes(ax)
    place = list(range(len(found)))[::-1]
    ax.barh(place, [value for _, value in found], **style)
    ax.axvline(line, color="0.3", linewidth=0.8)
    ax.set_yticks(place, [name for name, _ in found])
    ax.set_xlabel(label)
    return ax


def over_noise(
    ax: Axes | None, lines: Mapping[str, tuple[Sequence[float], Sequence[float]]], label: str, style: dict[str, Any]
) -> Axes:
    """Lines (x, y) by their name, y in units of the noise, with the noise itself."""
    ax = axes(ax)
    for name, (x, y) in lines.items():
        ax.plot(x, y, **({"marker": "o", "label": name} | style))
    ax.axhline(1.0, color="0.3", linewidth=0.8)
    ax.set_ylabel(label)
    if lines:
        ax.legend()
    return ax


def known_and_unknown(
    ax: Axes | None,
    found: Sequence[tuple[str, float, float, str]],
    style: dict[str, Any],
    quantile: float = Z_95,
) -> Axes:
    """Half of the 95 % interval of each (name, value, std, unit) as a share of the value, in red from all of it on.

    `quantile` is this half in standard deviations.
    """
    half = [quantile * std for _, _, std, _ in found]
    share = [100.0 * h / abs(value) for h, (_, value, _, _) in zip(half, found, strict=True)]
    texts = zip(half, found, strict=True)
    names = [f"{name}\n{number(value)} ± {h:.2g} {unit}".rstrip() for h, (name, value, _, unit) in texts]
    colours = {"color": ["C3" if s >= 100.0 else "C0" for s in share]}
    rows = list(zip(names, share, strict=True))
    ax = bars(ax, rows, 100.0, "half-width of the 95 % interval, % of the estimate", colours | style)
    ax.set_xscale("log")
    return ax
