"""The verb `convert`: a log in any format as plain CSV in SI units."""

from __future__ import annotations

import json
from os import PathLike, fspath
from pathlib import Path
from typing import Any

from . import _native
from ._errors import UsageError
from ._files import may_write
from ._formats import ColumnMap, is_known, open_source, run_of
from ._formats.column_map import read_toml
from ._run import Run


def convert(
    source: str | PathLike[str],
    output: str | PathLike[str] | None = None,
    *,
    map: str | PathLike[str] | None = None,
    force: bool = False,
    **options: Any,
) -> Run:
    """Reads a log in any format, and writes it as plain CSV in SI units if `output` is given.

    Args:
        source: a ROS bag (a file or a folder), ``.mcap``, ``.bin``, ``.ulg``, ``.mat``, ``.parquet``, ``.arrow``,
            ``.feather``, ``.nc``, ``.npz``, ``.npy``; everything else is read as CSV.
        output: the CSV to write: sensors with their own rates share the file, and cells are empty where one has no
            sample; read it back with ``missing = "no_sample"``.
        map: a TOML file with the reading options, ``columns`` among them.
        force: replace an existing file.
        options: reading options; they win over the map.

    Raises:
        DataError: the log was refused.
        UsageError: a wrong option or map, a missing library, or `output` exists.
    """
    if output is not None:
        may_write(output, force)
    path = Path(source)
    if is_known(path):
        columns = ColumnMap.of(options) if map is None else ColumnMap.from_file(map, options)
        opened, columns = open_source(path, columns)
        run = run_of(opened, columns, name=fspath(source))
    else:
        run = Run.from_csv(path, **((read_toml(map) if map is not None else {}) | options))
    if output is not None:
        run.to_csv(output, force=force)
    return run


def as_json(run: Run) -> str:
    """What was converted, as the command's ``--json`` writes it."""
    channels = {
        name: {"samples": len(t), "from": float(t[0]), "to": float(t[-1])} for name, (t, _) in run.signals.items()
    }
    warnings = [{k: v for k, v in vars(finding).items() if v is not None} for finding in run.findings]
    return json.dumps({"format": 1, "source": run.name, "channels": channels, "warnings": warnings}, indent=2)


def explain(code: str | None = None) -> list[dict[str, str]]:
    """What the code of a finding means, or all codes: ``code``, ``kind``, ``severity``, ``meaning``.

    >>> explain("L105")[0]["kind"]
    'gap'
    """
    entries: list[dict[str, str]] = json.loads(_native.codes_explained())
    meant = [e for e in entries if code is None or e["code"].lower() == code.lower() or e["kind"] == code]
    if not meant:
        raise UsageError(f"no finding has the code `{code}`; explain() lists them")
    return meant
