"""The result of `plan`."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ._errors import Finding
from ._html import html_table, picture
from ._result import Result
from ._run import Run
from ._view import Rows, bars, text_table

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True)
class Push:
    """The law of one degree of freedom in a planned run.

    A sine about `offset` where there is a `period` (s), a zig-zag of `amplitude` where there is a `bound` (rad), the
    pose of the start held where there is a stiffness `hold`, else a constant force; N and N·m.
    """

    dof: str
    offset: float
    amplitude: float
    period: float | None = None
    bound: float | None = None
    hold: float | None = None


@dataclass(frozen=True)
class PlannedRun:
    """One run of a plan.

    Attributes:
        name: name.
        kind: kind of experiment.
        length: length, s.
        pushes: force law of each degree of freedom.
        greatest: highest predicted speed, by channel, m/s and rad/s.
        reach: largest horizontal distance from the start, m.
        worst: largest ratio of standard error to the requested one up to and including this run; NaN while a requested
            parameter is not identified.
    """

    name: str
    kind: str
    length: float
    pushes: tuple[Push, ...]
    greatest: dict[str, float]
    reach: float
    worst: float


@dataclass(frozen=True)
class PlannedParameter:
    """The predicted accuracy of one parameter, SI.

    Attributes:
        effect: id of the effect.
        dof: degree of freedom; `None` for the whole vehicle.
        name: symbol.
        value: value in the model.
        unit: unit.
        std_now: standard error in the model.
        wanted: requested standard error.
        std: predicted standard error; `None` if the plan cannot separate the parameter from others.
        other: the other degree of freedom of a coupling.
        rehearsed: root mean square of estimate − truth in the rehearsal.
    """

    effect: str
    dof: str | None
    name: str
    value: float
    unit: str
    std_now: float | None
    wanted: float | None
    std: float | None
    other: str | None = None
    rehearsed: float | None = None

    @property
    def term(self) -> str:
        """``id``, ``id@dof`` or ``id@dof:other``."""
        place = ":".join(d for d in (self.dof, self.other) if d)
        return f"{self.effect}@{place}" if place else self.effect


@dataclass(frozen=True, eq=False, repr=False)
class Plan(Result):
    """A plan of the next runs.

    Attributes:
        format: 1.
        sentence: the conclusion in words.
        runs: the runs, the most valuable first.
        parameters: the accuracy that they give together.
        covariance: predicted covariance in the order of `parameters`; `None` if the runs do not identify all of them.
        limits: limits of thrust of the plan, N and N·m.
        sensors: assumed noise (SI) and rate (Hz), by channel.
        candidates: number of evaluated candidates.
        rehearsal: result of simulated campaigns, if requested.
        warnings: warnings and notes.
        commands: the command history of each run, as runs.
    """

    format: int
    sentence: str
    runs: tuple[PlannedRun, ...]
    parameters: tuple[PlannedParameter, ...]
    covariance: NDArray[np.float64] | None
    limits: dict[str, float]
    sensors: dict[str, dict[str, float]]
    candidates: int
    rehearsal: Any
    warnings: tuple[Finding, ...]
    commands: tuple[Any, ...] = field(default=(), metadata={"own": True})

    title: ClassVar[str] = "Plan"

    def rows(self) -> Rows:
        """One row per parameter."""
        return [
            {
                "effect": p.term,
                "name": p.name,
                "value": p.value,
                "std_now": p.std_now,
                "wanted": p.wanted,
                "std": p.std,
                "rehearsed": p.rehearsed,
                "unit": p.unit,
            }
            for p in self.parameters
        ]

    def run_rows(self) -> Rows:
        """One row per run."""
        return [
            {"run": r.name, "kind": r.kind, "s": r.length, "m away": r.reach, "worst std/wanted": r.worst}
            for r in self.runs
        ]

    def command(self, name: str) -> Run:
        """The command history of the run of this name."""
        for run in self.commands:
            if run.name == name:
                return run  # type: ignore[no-any-return]
        raise KeyError(f"no run {name!r}; there are {', '.join(run.name for run in self.commands)}")

    def summary(self) -> str:
        """Runs, then the accuracy that they give."""
        return "\n".join([text_table(self.run_rows(), "Runs"), super().summary()])

    def _verdict(self) -> tuple[str, str]:
        return "", self.sentence

    def _tables(self) -> list[str]:
        return [html_table(self.run_rows(), "Runs"), html_table(self.rows(), "Accuracy that they give")]

    def _picture(self) -> str:
        known = sum(p.std is not None and bool(p.wanted) for p in self.parameters)
        return picture(lambda figure: self.plot(figure.add_subplot()), 5.0, 0.8 + 0.28 * known) if known else ""

    def plot(self, ax: Axes | None = None, **style: Any) -> Axes:
        """Ratio of planned to requested standard error of each parameter.

        Args:
            ax: axes to draw into; new ones when absent.
            style: passed on to `matplotlib.axes.Axes.barh`.
        """
        told = [(p.term, p.std / p.wanted) for p in self.parameters if p.std is not None and p.wanted]
        return bars(ax, told, 1.0, "planned over requested standard error", style)
