"""The catalogue of effects, and their columns on runs."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import _native
from ._errors import UsageError
from ._plain import build
from ._run import Run

Array = NDArray[np.float64]


@dataclass(frozen=True)
class EffectParameter:
    """A parameter of an effect; `linear` ones are estimated by least squares in one step."""

    name: str
    unit: str
    linear: bool
    sname: str | None


@dataclass(frozen=True)
class Effect:
    """An entry of the catalogue: one physical effect between command and log.

    Attributes:
        id: stable id, as in a campaign.
        common_name: what practitioners call it.
        family: ``body``, ``actuator``, ``environment`` or ``sensor``.
        dofs: degrees of freedom in which it can act, or which it needs.
        formula: what it adds or changes.
        meaning: one sentence.
        source: where it comes from.
        shown_by: which data can show it.
        parameters: its parameters, at the first place where it can act.
    """

    id: str
    common_name: str
    family: str
    dofs: tuple[str, ...]
    formula: str
    meaning: str
    source: str
    shown_by: str
    parameters: tuple[EffectParameter, ...]


def effects(search: str = "") -> list[Effect]:
    """The catalogue of effects, in the order of the chain from command to log.

    Args:
        search: only those with all these words in their id, common name or meaning; case does not matter.

    Raises:
        UsageError: no effect matches; the message suggests what may have been meant.

    >>> [effect.id for effect in effects()][:2]
    ['inertia', 'added_mass_coupling']
    >>> [(effect.id, effect.common_name) for effect in effects("rotor lag")]
    [('thrust_lag', 'rotor lag')]
    """
    entries, near = json.loads(_native.effects(search))
    if not entries:
        meant = f"; did you mean {near!r}?" if near else ""
        raise UsageError(f"no effect has {search!r} in its id, common name or meaning{meant}")
    return [build(Effect, entry) for entry in entries]


class Regressors(NamedTuple):
    """The linear system H θ = rhs of a balance of momentum.

    Attributes:
        names: symbols of the parameters, one per column.
        columns: H, (n, p); unit of the momentum divided by that of the parameter.
        rhs: right-hand side, N·s or N·m·s, (n).
        span: begin and end of each row, s, (n, 2).
    """

    names: tuple[str, ...]
    columns: Array
    rhs: Array
    span: Array


def regressors(
    run: Run | Iterable[Run],
    dof: str,
    effects: Sequence[str],
    *,
    dofs: Sequence[str] | None = None,
    fixed: Mapping[str, float] | None = None,
    coriolis: str = "free",
    samples: int | None = 1,
    every_stamp: bool = True,
) -> Regressors:
    """Integral regressors of the balance of one degree of freedom; nothing noisy is differentiated.

    Args:
        run: one run, or several that are stacked.
        dof: ``surge`` … ``yaw``.
        effects: ids of the catalogue, ``id`` or ``id@dof``.
        dofs: all degrees of freedom of the model; `dof` alone when absent.
        fixed: values of effects that are known; they go to the right-hand side.
        coriolis: ``free`` coefficients, as the paper's k_uv, or ``tied`` to the inertias.
        samples: intervals of the sensor that one row spans, 1 as in the paper; `None`: from the start to each sample.
        every_stamp: integrate over the stamps of all channels, not of the velocity's sensor alone.

    >>> t = np.linspace(0.0, 10.0, 1001)
    >>> u = 1.0 - np.exp(-t)  # 2 du/dt + 2 u = 2
    >>> system = regressors(Run(t=t, u=u, tau_u=np.full(1001, 2.0)), "surge", ["inertia", "linear_drag"])
    >>> system.names
    ('m_u', 'k_u')
    >>> from hydrosysid import least_squares
    >>> least_squares(system.columns, system.rhs, system.names).coefficients.round(2).tolist()
    [2.0, 2.0]
    """
    runs = [run] if isinstance(run, Run) else list(run)
    if not runs:
        raise UsageError("regressors need at least one run")
    held = [(name, float(value)) for name, value in (fixed or {}).items()]
    names, columns, rhs, span = _native.regressors(
        runs=[r._native() for r in runs],
        dof=dof,
        dofs=list(dofs or [dof]),
        effects=list(effects),
        fixed=held,
        coriolis=coriolis,
        samples=samples,
        every_stamp=every_stamp,
    )
    return Regressors(tuple(names), columns, rhs, span)
