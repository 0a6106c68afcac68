"""The reference of the Python package as one page, from signatures and docstrings.

    python reference.py ../docs/python.md

`tests/test_docs.py` holds the page to what this writes.
"""

from __future__ import annotations

import dataclasses
import inspect
import re
import sys
from pathlib import Path
from typing import Any

import hydrosysid as hs

HEAD = """# Python

Written from the package itself by `python/reference.py`. Arrays are NumPy arrays, all numbers SI; body axes are
forward, starboard, down, earth axes north, east, down. `pip install ./python` builds the wheel; the verbs are those of
the command.

Every result has `.summary()`, `.rows()`, `.to_frame()` (pandas or polars, whichever is there), `.to_latex()`,
`.to_dict()` (the command's `--json`), and shows itself in a notebook: verdict, tables, and a small picture where
matplotlib is there. All but `Export` have `.plot(ax=None)`, which returns the axes; of a simulation and a comparison it
draws a panel a channel. Results and campaigns pickle. `progress=` takes `True` for a bar (of tqdm where it is there) or
a function `(what, done, of)`; Ctrl-C ends long work.

Arrays may be masked, nullable (`None`, `pandas.NA`) or carry units (pint, astropy): what is absent is NaN, what has a
unit becomes SI.
"""
GROUPS = {
    "Campaigns and logs": ["Campaign", "Run", "Model", "OwnEffect", "tank_campaign", "init", "vehicles", "convert"],
    "Verbs": [
        *["check", "fit", "simulate", "force_components", "compare", "compare_published", "compare_models"],
        *[
            "cross_validate",
            "discover",
            "plan",
            "monitor",
            "export",
            "report",
            "view",
            "demo",
            "explain",
            "resample",
            "map_fit",
        ],
    ],
    "Building blocks": [
        *["effects", "regressors", "least_squares", "block_bootstrap", "rk4", "polynomial_filter", "fit_thruster"],
    ],
}
SECTIONS = {"Args": "Arguments", "Attributes": "Attributes", "Returns": "Returns", "Raises": "Errors"}
# of every result, said once above
COMMON = {"rows", "summary", "to_dict", "to_frame", "to_latex", "plot"}
MIXED_IN = {"Readers"}
"""Classes without a name of their own in the package whose members stand with those of the class that has them."""


def page() -> str:
    """The whole page."""
    names = [name for name in hs.__all__ if not name.startswith("__")]
    grouped = [name for group in GROUPS.values() for name in group]
    rest = [name for name in names if name not in grouped]
    errors = [name for name in rest if issubclass(getattr(hs, name), Exception)]
    results = [name for name in rest if hasattr(getattr(hs, name), "to_frame")]
    parts = [name for name in rest if name not in errors + results]
    groups = GROUPS | {"Results": results, "Parts of results": parts, "Errors": errors}
    if missing := set(grouped) - set(names):
        raise SystemExit(f"no such public names: {missing}")
    body = [f"\n## {title}\n" + "".join(entry(name) for name in group) for title, group in groups.items()]
    return HEAD + "".join(body)


def entry(name: str) -> str:
    """One public name."""
    thing = getattr(hs, name)
    shown = f"\n### `{name}`\n\n"
    if inspect.isclass(thing):
        return shown + of_class(thing)
    return shown + f"```python\n{signature(thing, name)}\n```\n\n{told(thing)}"


def of_class(thing: type) -> str:
    """A class: what it is, its fields, its own methods."""
    # a class without words of its own has those of its base, which say nothing of it
    text = told(thing)
    fields = dataclasses.fields(thing) if dataclasses.is_dataclass(thing) else ()
    if fields and "**Attributes**" not in text:
        text += "\nFields: " + ", ".join(f"`{f.name}: {f.type}`" for f in fields) + ".\n"
    if not fields and not issubclass(thing, Exception | tuple):
        text = f"```python\n{signature(thing, thing.__name__)}\n```\n\n" + text
    skipped = COMMON if hasattr(thing, "to_frame") and fields else set()
    methods: list[str] = []
    mixed_in = [base for base in thing.__mro__[1:] if base.__name__ in MIXED_IN]
    text += "".join("\n" + told(base) for base in mixed_in)
    for key, member in [item for place in (thing, *mixed_in) for item in vars(place).items()]:
        if (key.startswith("_") and key != "__getitem__") or key in skipped:
            continue
        if isinstance(member, property):
            methods.append(f"- `.{key}`: {first(member)}")
        elif callable(bare := getattr(member, "__func__", member)) and inspect.getdoc(bare):
            line = re.sub(r"\( *(cls|self)(, *)?", "(", signature(bare, key).replace("\n", " "), count=1)
            methods.append(f"- `{re.sub(' +', ' ', line).replace('( ', '(').replace(', )', ')')}`: {first(bare)}")
    return text.rstrip("\n") + "\n" + ("\n**Members**\n\n" + "\n".join(methods) + "\n" if methods else "")


def signature(thing: Any, name: str) -> str:
    """`name(…)`, one argument a line where it is long."""
    found = inspect.signature(thing)
    plain = [p.replace(annotation=_quoted(p.annotation)) for p in found.parameters.values()]
    line = name + str(found.replace(parameters=plain, return_annotation=_quoted(found.return_annotation)))
    if len(line) <= 110:
        return line
    star, lines = False, []
    for p in plain:
        if p.kind is inspect.Parameter.KEYWORD_ONLY and not star:
            lines.append("*")
            star = True
        lines.append(str(p))
    returns = "" if found.return_annotation is inspect.Signature.empty else f" -> {found.return_annotation}"
    return f"{name}(\n" + "".join(f"    {one},\n" for one in lines) + f"){returns}"


class _Plain(str):
    """An annotation that is shown without quotes."""

    def __repr__(self) -> str:
        return str(self)


def _quoted(annotation: Any) -> Any:
    return _Plain(annotation) if isinstance(annotation, str) else annotation


def first(thing: Any) -> str:
    """The first paragraph of a docstring in one line."""
    return code(" ".join((inspect.getdoc(thing) or "").split("\n\n")[0].split()))


def code(text: str) -> str:
    """Double backticks of docstrings as Markdown has them."""
    return text.replace("``", "`")


def told(thing: Any) -> str:
    """A docstring in Markdown: its sections as lists, its examples as code."""
    out: list[str] = []
    section = example = False
    for line in (inspect.getdoc(thing) or "").splitlines():
        word = line.rstrip(":")
        if line.endswith(":") and word in SECTIONS:
            out += [f"**{SECTIONS[word]}**", ""]
            section = True
            continue
        if line and not line.startswith(" "):
            section = False
        if line.startswith((">>>", "...")) and not example:
            out.append("```python")
            example = True
        if example and not line:
            out.append("```")
            example = False
        if example:
            out.append(line)
        elif section and (entry := re.match(r"    (\w[\w, ]*): (.*)", line)):
            out.append(f"- `{entry[1]}`: {code(entry[2])}")
        elif section and line:
            out.append(("  " if line.startswith("        ") else "") + code(line.strip()))
        else:
            out.append(code(line))
    return "\n".join([*out, "```"] if example else out) + "\n"


if __name__ == "__main__":
    Path(sys.argv[1]).write_text(page(), encoding="utf-8")
