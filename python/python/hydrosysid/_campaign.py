"""A campaign: one vehicle, its runs, and the options."""

from __future__ import annotations

import html
import json
import os
from collections.abc import Iterable, Mapping, Sequence
from os import PathLike, fspath
from typing import Any

from . import _native
from ._errors import Finding, UsageError
from ._html import document, html_table
from ._own_effect import OwnEffect, prepared
from ._plain import build
from ._progress import Listener, Progress, listener
from ._run import Run
from ._settings import settings


class Campaign:
    """One vehicle, its runs, and the baseline model: the input of every verb.

    The arguments are the tables of a campaign file, as mappings; the runs are in memory. Logs are read and checked at
    once. A campaign pickles as what it was made from and is made anew where it is unpickled.

    Args:
        vehicle: ``name``, ``mass``, ``volume``, ``weight``, ``buoyancy``, ``length``, ``cg``, ``cb`` in SI units.
        dofs: degrees of freedom: ``surge``, ``sway``, ``heave``, ``roll``, ``pitch``, ``yaw``.
        effects: the baseline, ids of the catalogue: ``id`` or ``id@dof``.
        runs: the runs.
        coriolis: ``tied`` to the inertias, or ``free`` coefficients.
        input: inputs between samples: ``linear`` or ``hold``.
        water: ``density``, ``kinematic_viscosity``.
        noise: standard deviation of the noise of each channel; estimated from the data when absent.
        parameters: start, bounds, fixed value or prior: ``{"effect": "quadratic_drag@surge", "value": 309.0}``.
        own_effects: effects of your own: `OwnEffect`, or ``{"id", "dof", "formula", "unit", "role"}``.
        observe: logged functions of the states: ``{"channel", "formula"}``.
        tables: further tables of a campaign file by name: ``thruster``, ``efficiency``, ``fit``, ``stage``, …

    Raises:
        UsageError: an invalid table; the message names the key.
        DataError: runs that lack what the model reads.
    """

    def __init__(
        self,
        *,
        vehicle: Mapping[str, Any] | None = None,
        dofs: Sequence[str],
        effects: Sequence[str],
        runs: Iterable[Run],
        coriolis: str = "tied",
        input: str = "linear",
        water: Mapping[str, float] | None = None,
        noise: Mapping[str, float] | None = None,
        parameters: Sequence[Mapping[str, Any]] = (),
        own_effects: Sequence[OwnEffect | Mapping[str, Any]] = (),
        observe: Sequence[Mapping[str, str]] = (),
        **tables: Any,
    ) -> None:
        effect_tables, kept = prepared(own_effects, runs, dofs, held=input == "hold")
        model = {"dofs": list(dofs), "effects": list(effects), "coriolis": coriolis, "input": input}
        # a campaign file names a log for each run; here the runs are at hand
        listed = [{"file": f"run{k}.csv", "kind": r.kind, "role": r.role} for k, r in enumerate(kept)]
        whole = {
            "format": 1,
            "vehicle": dict(vehicle or {}),
            "water": dict(water or {}),
            "noise": dict(noise or {}),
            "model": model,
            "parameter": [dict(p) for p in parameters],
            "effect": effect_tables,
            "observe": [dict(o) for o in observe],
            **tables,
            "run": listed,
        }
        text = json.dumps(settings({key: value for key, value in whole.items() if value or key == "vehicle"}))
        self._make(("runs", text, kept))

    @classmethod
    def from_file(
        cls, path: str | PathLike[str], *, allow_outside: bool = False, progress: Progress = None
    ) -> Campaign:
        """Reads a campaign file and its logs.

        Args:
            path: the TOML file.
            allow_outside: let logs lie outside the campaign's folder.
            progress: as for `discover`.
        """
        campaign = object.__new__(cls)
        with listener(progress) as tell:
            campaign._make(("file", fspath(path), allow_outside), tell)
        return campaign

    def with_effects(self, names: Sequence[str], training: Sequence[str] = (), *, input: str | None = None) -> Campaign:
        """The same campaign with further effects in its baseline, as `Discovery.adopt` puts them there.

        Args:
            names: ids of the catalogue; those already present are not repeated.
            training: names of runs, as in `runs`, that get the role ``train``.
            input: ``hold`` or ``linear``, if the commands are taken otherwise than in this campaign.

        Raises:
            UsageError: no such effect or run, or the campaign was read from a file, which defines its baseline.
        """
        kind, text, *rest = self._source
        if kind == "file":
            raise UsageError(f"this campaign is what {text} says: give the path, so that the effects are written there")
        (given,) = rest
        shown = [name for name, *_ in self.runs]
        unknown = [name for name in training if name not in shown]
        if unknown:
            raise UsageError(f"no run is named {unknown[0]!r}: the runs are {', '.join(shown)}")
        kept = [run.with_role("train") if name in training else run for name, run in zip(shown, given, strict=True)]
        tables = json.loads(text)
        there = tables["model"]["effects"]
        tables["model"]["effects"] = list(dict.fromkeys([*there, *names]))
        if input is not None:
            tables["model"]["input"] = input
        for table, run in zip(tables["run"], kept, strict=True):
            table["role"] = run.role
        return _unpickled(type(self), (kind, json.dumps(tables), kept))

    def _make(self, source: tuple[Any, ...], tell: Listener | None = None) -> None:
        self._source = source
        self._folder = os.getcwd()
        if source[0] == "file":
            self._native = _native.NativeCampaign.load(source[1], source[2], tell)
        else:
            self._native = _native.NativeCampaign.from_runs(source[1], [run._native() for run in source[2]])
        self.name, self.dofs, self.effects, self.runs, findings = json.loads(self._native.about())
        self.findings = tuple(build(Finding, entry) for entry in findings)

    name: str
    """Name of the vehicle."""
    dofs: list[str]
    """Degrees of freedom of the model."""
    effects: list[str]
    """Terms of the baseline."""
    runs: list[list[str]]
    """Name, kind and role of each run; a repeated name gets a number."""
    findings: tuple[Finding, ...]
    """Findings of reading and preparing."""

    def __reduce__(self) -> tuple[Any, ...]:
        kind, place, *rest = self._source
        # another process may stand in another folder
        source = (kind, os.path.join(self._folder, place), *rest) if kind == "file" else self._source
        return (_unpickled, (type(self), source))

    def __repr__(self) -> str:
        return f"<Campaign {self.name!r}: {len(self.runs)} runs, {' '.join(self.dofs)}, {len(self.effects)} terms>"

    def _repr_html_(self) -> str:
        rows = [{"run": name, "kind": kind, "role": role} for name, kind, role in self.runs]
        about = f"<p>{html.escape(' · '.join(self.dofs))}: {html.escape(', '.join(self.effects))}</p>"
        return document(f"Campaign {self.name}", [about, html_table(rows)], findings=self.findings)


def _unpickled(kind: type[Campaign], source: tuple[Any, ...]) -> Campaign:
    campaign = object.__new__(kind)
    campaign._make(source)
    return campaign


def campaign_of(given: Campaign | str | PathLike[str], tell: Listener | None = None) -> Campaign:
    """A campaign, or the one in this file; `tell` hears of its reading."""
    if isinstance(given, Campaign):
        return given
    if isinstance(given, str | PathLike):
        return Campaign.from_file(given, progress=tell)
    raise UsageError(f"a campaign or the path of one is expected, not {type(given).__name__}")
