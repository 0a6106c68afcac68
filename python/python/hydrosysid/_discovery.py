"""The result of `discover`."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

from ._errors import Finding
from ._result import Result
from ._view import Rows, html_table, over_noise, text_table

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True)
class FoundParameter:
    """A parameter of an effect that was found, SI units."""

    name: str
    value: float
    std: float
    unit: str
    per_run: tuple[float, ...] = ()


@dataclass(frozen=True)
class FoundEffect:
    """An effect that the data asks for.

    Attributes:
        id: ``id``, ``id@dof`` or ``id@dof:other``.
        dofs: degrees of freedom in which it acts.
        parameters: its parameters in the final fit; none of a whole row of the Coriolis forces, which is tied to the
            inertias.
        p_value: probability of as much by chance, over all candidates.
        also_possible: other names that this data allows.
        evidence: one sentence.
    """

    id: str
    dofs: tuple[str, ...]
    parameters: tuple[FoundParameter, ...]
    p_value: float
    also_possible: tuple[str, ...]
    evidence: str


@dataclass(frozen=True)
class Where:
    """A stretch, `from_` to `to` in s, where the baseline disagrees with the data."""

    run: str
    dof: str
    from_: float = field(metadata={"key": "from"})
    to: float
    times_noise: float
    condition: str


@dataclass(frozen=True)
class GapOfRun:
    """Root mean square error on one run, by degree of freedom."""

    run: str
    held_out_rms: dict[str, float]


@dataclass(frozen=True)
class GapStep:
    """Error on held-out runs after `added` came in; `None` for the refitted baseline, `dropped` if it went again."""

    added: str | None
    dropped: bool
    held_out_rms: dict[str, float]
    noise_floor: dict[str, float]
    runs: tuple[GapOfRun, ...]


def _label(step: GapStep) -> str:
    return (step.added or "baseline") + (" (dropped later)" if step.dropped else "")


@dataclass(frozen=True)
class LogFinding:
    """A fault of the log that looks like missing physics, and in one sentence what to do."""

    kind: str
    channel: str
    factor: float
    message: str


@dataclass(frozen=True)
class Dependence:
    """What a missing force goes with: a channel, a product of two, heading, depth, time or amplitude."""

    quantity: str
    correlation: float


@dataclass(frozen=True)
class Change:
    """An instant, s, at which the mean of a missing force changes in a run."""

    run: str
    at: float
    before: float
    after: float


@dataclass(frozen=True)
class Residual:
    """The force that the baseline lacks in one degree of freedom, root mean square, beside what noise makes of it."""

    dof: str
    rms: float
    noise: float
    unit: str
    goes_with: tuple[Dependence, ...]
    changes: tuple[Change, ...]
    sentence: str


@dataclass(frozen=True)
class SmallestVisible:
    """The smallest size of an effect that this data would have shown.

    `tied` is the whole row of the Coriolis forces, its coefficients those of the inertias: it has no parameter, and its
    size is the share of it, 1 for all of it.
    """

    id: str
    value: float
    unit: str
    tied: bool = False


@dataclass(frozen=True, eq=False, repr=False)
class Discovery(Result):
    """What the baseline lacks, if anything.

    Attributes:
        format: 1.
        verdict: ``nothing_missing``, ``explained``, ``partly_explained`` or ``unexplained``.
        effects: what was added, in order.
        where: where the baseline disagrees with the data.
        residuals: the force that the baseline lacks, by degree of freedom.
        gap: error on held-out runs before and after each step.
        removed: what was added and dropped again.
        log_findings: what looks like a fault of the log.
        smallest_visible: what this data could have shown.
        next_experiment: the run that would tell more.
        seed: seed of anything random.
        warnings: what there is to say.
    """

    format: int
    verdict: str
    effects: tuple[FoundEffect, ...]
    where: tuple[Where, ...]
    residuals: tuple[Residual, ...]
    gap: tuple[GapStep, ...]
    removed: tuple[str, ...]
    log_findings: tuple[LogFinding, ...]
    smallest_visible: tuple[SmallestVisible, ...]
    next_experiment: str | None
    seed: int
    warnings: tuple[Finding, ...]

    title: ClassVar[str] = "Missing effects"

    def rows(self) -> Rows:
        """One row a parameter of an effect that was found; one without for a row that is tied to the inertias."""

        def row(effect: FoundEffect, p: FoundParameter | None) -> dict[str, Any]:
            return {
                "effect": effect.id,
                "name": "whole row, tied to the inertias" if p is None else p.name,
                "value": None if p is None else p.value,
                "std": None if p is None else p.std,
                "unit": "" if p is None else p.unit,
                "p_value": effect.p_value,
                "also_possible": ", ".join(effect.also_possible),
            }

        return [row(effect, p) for effect in self.effects for p in effect.parameters or (None,)]

    def _gap_rows(self) -> Rows:
        return [
            {
                "with": _label(step),
                "dof": dof,
                "held-out rms": rms,
                "noise": step.noise_floor.get(dof),
            }
            for step in self.gap
            for dof, rms in step.held_out_rms.items()
        ]

    def summary(self) -> str:
        """Verdict, what was found, the gap on held-out runs, and what to do next."""
        found = [text_table(self.rows(), self.title)] if self.effects else []
        following = [f"next: {self.next_experiment}"] if self.next_experiment else []
        gap = text_table(self._gap_rows(), "Gap on held-out runs")
        return "\n".join([f"verdict: {self.verdict.replace('_', ' ')}", *found, gap, *following, *self._remarks()])

    def _repr_html_(self) -> str:
        head = f"<p><b>{self.verdict.replace('_', ' ')}</b></p>"
        return head + super()._repr_html_() + html_table(self._gap_rows(), "Gap on held-out runs")

    def plot(self, ax: Axes | None = None, **style: Any) -> Axes:
        """Error on held-out runs over the noise floor, step by step.

        Args:
            ax: axes to draw into; new ones when absent.
            style: passed on to `matplotlib.axes.Axes.plot`.
        """
        kept = [step for step in self.gap if not step.dropped]
        steps = [_label(step) for step in kept]
        place = range(len(steps))
        lines = {
            dof: (place, [step.held_out_rms[dof] / step.noise_floor[dof] for step in kept])
            for dof in (kept[0].held_out_rms if kept else ())
        }
        ax = over_noise(ax, lines, "held-out rms over sensor noise", style)
        ax.set_yscale("log")
        ax.set_xticks(place, [f"+ {step}" if k else step for k, step in enumerate(steps)])
        ax.margins(x=0.25)
        return ax
