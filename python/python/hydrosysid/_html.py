"""How results show themselves in a notebook: a verdict, tables, a small picture, and what there is to say."""

from __future__ import annotations

import base64
import html
import importlib.util
import io
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any

from ._view import Rows, cell, is_numeric, number

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ._errors import Finding

MOST_ROWS = 40
"""Rows of a table that a notebook shows."""
_STYLE = """<style>
.hydrosysid {font: 13px/1.45 system-ui, sans-serif; max-width: 62em}
.hydrosysid h4 {margin: .2em 0; font-size: 14px}
.hydrosysid p {margin: .3em 0}
.hydrosysid .light {display: inline-block; width: .75em; height: .75em; border-radius: 50%; margin-right: .45em}
.hydrosysid .green {background: #2e9e4f} .hydrosysid .amber {background: #e08a00} .hydrosysid .red {background: #d03a3a}
.hydrosysid table {border-collapse: collapse; margin: .5em 0; font: inherit; font-variant-numeric: tabular-nums}
.hydrosysid caption {caption-side: top; text-align: left; font-weight: 600; padding: .2em 0; color: inherit}
.hydrosysid th, .hydrosysid td {padding: .12em .7em; text-align: left; border: 0; white-space: nowrap}
.hydrosysid th {border-bottom: 1px solid rgba(128, 128, 128, .8)}
.hydrosysid td {border-bottom: 1px solid rgba(128, 128, 128, .2)}
.hydrosysid .n {text-align: right}
.hydrosysid .w {white-space: normal; min-width: 16em}
.hydrosysid .wide {overflow-x: auto}
.hydrosysid ul {list-style: none; margin: .4em 0; padding: 0}
.hydrosysid li {border-left: 3px solid #8a8a8a; padding: .1em .6em; margin: .25em 0}
.hydrosysid li.warning {border-color: #e08a00} .hydrosysid li.error {border-color: #d03a3a}
.hydrosysid img {max-width: 100%; height: auto; background: white; border-radius: 3px}
</style>"""


def html_table(rows: Rows, title: str = "") -> str:
    """An HTML table without its empty columns, numbers to the right; a last line says how many rows are not shown."""
    if not rows:
        return f"<p>{html.escape(title)}</p>" if title else ""
    heads = [head for head in rows[0] if any(number(row.get(head)) for row in rows)]
    kinds = [_kind(rows, head) for head in heads]
    top = "".join(f"<th{kind}>{html.escape(head)}</th>" for head, kind in zip(heads, kinds, strict=True))
    lines = (
        "<tr>"
        + "".join(f"<td{k}>{html.escape(cell(row, head))}</td>" for head, k in zip(heads, kinds, strict=True))
        + "</tr>"
        for row in rows[:MOST_ROWS]
    )
    caption = f"<caption>{html.escape(title)}</caption>" if title else ""
    more = len(rows) - MOST_ROWS
    rest = f"<p>and {more} more rows: <code>.to_frame()</code> has them all</p>" if more > 0 else ""
    body = f"<thead><tr>{top}</tr></thead><tbody>{''.join(lines)}</tbody>"
    return f'<div class="wide"><table>{caption}{body}</table></div>{rest}'


def _kind(rows: Rows, head: str) -> str:
    if is_numeric(rows, head):
        return ' class="n"'
    return ' class="w"' if any(len(number(row.get(head))) > 60 for row in rows) else ""


def document(
    title: str, parts: Iterable[str], *, light: str = "", verdict: str = "", findings: Sequence[Finding] = ()
) -> str:
    """A result as HTML under a style of its own, in the colours of the page about it.

    Args:
        title: what it is.
        parts: its tables and pictures.
        light: ``green``, ``amber`` or ``red``, shown before the verdict; nothing where it is empty.
        verdict: what it comes to, in words.
        findings: warnings and notes.
    """
    lamp = f'<span class="light {light}" title="{light}"></span>' if light else ""
    said = f"<p>{lamp}<b>{html.escape(verdict)}</b></p>" if verdict else ""
    notes = "".join(f'<li class="{f.severity}">{html.escape(str(f))}</li>' for f in findings)
    notes = f"<ul>{notes}</ul>" if notes else ""
    return f'<div class="hydrosysid">{_STYLE}<h4>{html.escape(title)}</h4>{said}{"".join(parts)}{notes}</div>'


def picture(draw: Callable[[Figure], object], width: float, height: float) -> str:
    """What `draw` draws into a figure of so many inches, as an image; nothing where there is no matplotlib."""
    if importlib.util.find_spec("matplotlib") is None:
        return ""
    figure: Any = importlib.import_module("matplotlib.figure").Figure((width, height), dpi=150, layout="constrained")
    draw(figure)
    for ax in figure.axes:
        _lighten(ax)
    sink = io.BytesIO()
    figure.savefig(sink, format="png")
    data = base64.b64encode(sink.getvalue()).decode()
    return f'<img width="{round(96 * width)}" alt="" src="data:image/png;base64,{data}">'


def _lighten(ax: Any) -> None:
    """Letters of a small picture: those of the page about it."""
    ax.tick_params(labelsize=8)
    for text in (ax.xaxis.label, ax.yaxis.label, ax.title):
        text.set_fontsize(8.5)
    legend = ax.get_legend()
    for text in legend.get_texts() if legend else ():
        text.set_fontsize(8)
