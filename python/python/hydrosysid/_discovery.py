"""The result of `discover`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from html import escape
from typing import TYPE_CHECKING, Any, ClassVar, overload

from . import _native
from ._campaign import Campaign
from ._errors import Finding
from ._html import html_table, picture
from ._noise import Prediction
from ._result import Result
from ._view import Rows, over_noise, text_table

if TYPE_CHECKING:
    from os import PathLike

    from matplotlib.axes import Axes


@dataclass(frozen=True)
class FoundParameter:
    """A parameter of a discovered effect, SI units."""

    name: str
    value: float
    std: float
    unit: str
    per_run: tuple[float, ...] = ()


@dataclass(frozen=True)
class FoundEffect:
    """An effect that the data require.

    Attributes:
        id: ``id``, ``id@dof`` or ``id@dof:other``; of single thrusters ``id@T6`` or ``id@T2:T5``.
        common_name: what practitioners call it.
        dofs: degrees of freedom in which it acts.
        parameters: its parameters in the final fit; none for a whole row of the Coriolis forces, which is tied to the
            inertias, or for two exchanged thrusters.
        p_value: probability of such a gain by chance, over all candidates.
        also_possible: other effects that explain this data as well.
        evidence: one sentence.
    """

    id: str
    common_name: str
    dofs: tuple[str, ...]
    parameters: tuple[FoundParameter, ...]
    p_value: float
    also_possible: tuple[str, ...]
    evidence: str


@dataclass(frozen=True)
class RunInstant:
    """An instant of a run.

    Attributes:
        run: the run.
        at: the instant, s.
    """

    run: str
    at: float


@dataclass(frozen=True)
class ChangedParameter:
    """A parameter of the last model that is significantly not constant.

    Attributes:
        parameter: effect and symbol, or a property of the vehicle: ``drag``, ``thrust`` or ``mass``.
        run: run in which it differs, or in which the change begins.
        from_: instant from which it differs, s of the run; None if it differs in this run alone.
        between: earliest and latest instant of an event that the data cannot separate from `from_`; else empty.
        change: its value there minus that elsewhere.
        std: standard error of the change.
        unit: unit of both.
        p_value: probability of such a change by chance, over all parameters and parts of the log.
        gain: decrease of −2 ln L, beyond chance, if all parameters have their own values there.
        alone: whether this change explains everything; if not, the equations have the wrong form. For
            an event (`absent`, or a property of the vehicle), less than a tenth of its gain then remains.
        absent: whether the effect is not in the model and begins there, such as a thruster that fails.
        relative: whether ``change`` is a share of the value elsewhere: of the whole drag, or of all thrust.
    """

    parameter: str
    run: str
    from_: float | None = field(metadata={"key": "from"})
    between: tuple[RunInstant, ...]
    change: float
    std: float
    unit: str
    p_value: float
    gain: float
    alone: bool
    absent: bool
    relative: bool


@dataclass(frozen=True)
class BehavesLike:
    """An effect that improved the fit but violates a rule of physics or of the held-out runs: not adopted.

    Attributes:
        id: ``id``, ``id@dof`` or ``id@dof:other``.
        why: the violated rule, in words.
        gain: decrease of −2 ln L.
    """

    id: str
    why: str
    gain: float


@dataclass(frozen=True)
class GapForce:
    """The random force of a step of the gap in one degree of freedom, `rms` in `unit`, `correlation_time` in s."""

    dof: str
    rms: float
    unit: str
    correlation_time: float


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
    """Error on held-out runs after adding `added`; `None` for the refitted baseline, `dropped` if removed again.

    `force` is the random force of this step, which a true effect reduces; `prediction` the prediction errors.
    """

    added: str | None
    dropped: bool
    held_out_rms: dict[str, float]
    noise_floor: dict[str, float]
    runs: tuple[GapOfRun, ...]
    force: tuple[GapForce, ...] = ()
    prediction: tuple[Prediction, ...] = ()


def _label(step: GapStep, names: Mapping[str, str]) -> str:
    added = step.added or "baseline"
    return names.get(added, added) + (" (dropped later)" if step.dropped else "")


LIGHTS = {"nothing_missing": "green", "explained": "green", "partly_explained": "amber", "unexplained": "red"}
"""The light of each verdict."""


@dataclass(frozen=True)
class LogFinding:
    """A fault of the log that looks like missing physics, and what to do about it in one sentence."""

    kind: str
    channel: str
    factor: float
    message: str


@dataclass(frozen=True)
class Dependence:
    """What a missing force correlates with: a channel, a product of two, heading, depth, time or amplitude."""

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
    """Rms of the force that the baseline lacks in one degree of freedom, and the rms that noise alone causes."""

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

    `tied` marks an effect without a parameter, such as a row of the Coriolis forces with the inertias' coefficients, or
    two exchanged thrusters: its size is a share, 1 for the whole effect.
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
        sentence: the verdict in words.
        effects: the added effects, in order.
        where: where the baseline disagrees with the data.
        residuals: the force that the baseline lacks, by degree of freedom.
        gap: error on held-out runs before and after each step.
        changed_parameter: the parameter of the last model that is not constant, if there is one.
        behaves_like: effects that improved the fit but violate a rule of physics or of the held-out runs.
        adopt_names: the names in the campaign's list of effects once adopted; see `adopt`.
        took_part: runs of the role ``validate`` that took part in the fit, because those of the role ``train`` alone
            did not explain the others, or left a degree of freedom at rest.
        input: ``hold`` or ``linear`` if the search took the commands otherwise than the campaign says, because the data
            ask for it; else `None`.
        removed: effects that were added and removed again.
        log_findings: apparent faults of the log.
        smallest_visible: the smallest effects that this data could have shown.
        next_experiment: the most informative next run.
        seed: seed of anything random.
        warnings: warnings and notes.
    """

    format: int
    verdict: str
    sentence: str
    effects: tuple[FoundEffect, ...]
    where: tuple[Where, ...]
    residuals: tuple[Residual, ...]
    gap: tuple[GapStep, ...]
    changed_parameter: ChangedParameter | None
    behaves_like: tuple[BehavesLike, ...]
    adopt_names: tuple[str, ...] = field(metadata={"key": "adopt"})
    took_part: tuple[str, ...]
    input: str | None
    removed: tuple[str, ...]
    log_findings: tuple[LogFinding, ...]
    smallest_visible: tuple[SmallestVisible, ...]
    next_experiment: str | None
    seed: int
    warnings: tuple[Finding, ...]

    title: ClassVar[str] = "Missing effects"

    @overload
    def adopt(self, campaign: Campaign) -> Campaign: ...
    @overload
    def adopt(self, campaign: str | PathLike[str], to: str | PathLike[str] | None = None) -> None: ...
    def adopt(self, campaign: Campaign | str | PathLike[str], to: str | PathLike[str] | None = None) -> Campaign | None:
        """Adds the discovered effects to the model of a campaign.

        Args:
            campaign: a campaign in memory, which is not changed; or the campaign file, or the folder with
                ``campaign.toml``, whose comments and other content are kept. The runs of `took_part` get the role
                ``train``, and `input` is set.
            to: for files, another campaign in the same folder, so that the logs are found; a copy of `campaign` if it
                does not exist.

        Returns:
            The campaign with these effects and roles, for one in memory; `None` for files, which are written.

        Raises:
            UsageError: one of them is no campaign, `to` lies in another folder, or the campaign in memory was read from
                a file, which must be given instead.
        """
        if isinstance(campaign, Campaign):
            return campaign.with_effects(self.adopt_names, self.took_part, input=self.input)
        _native.adopt(campaign, to, list(self.adopt_names), list(self.took_part), self.input)
        return None

    def rows(self) -> Rows:
        """One row per parameter of an effect that was found; one without for a row that is tied to the inertias."""

        def row(effect: FoundEffect, p: FoundParameter | None) -> dict[str, Any]:
            return {
                "effect": effect.id,
                "common name": effect.common_name,
                "name": "as a whole" if p is None else p.name,
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
                "with": _label(step, {}),
                "dof": dof,
                "held-out rms": rms,
                "noise": step.noise_floor.get(dof),
            }
            for step in self.gap
            for dof, rms in step.held_out_rms.items()
        ]

    def summary(self) -> str:
        """Verdict, discovered effects, the gap on held-out runs, and what to do next."""
        found = [text_table(self.rows(), self.title)] if self.effects else []
        following = [f"next: {self.next_experiment}"] if self.next_experiment else []
        gap = text_table(self._gap_rows(), "Gap on held-out runs")
        return "\n".join([self.sentence, *found, gap, *following, *self._remarks()])

    def _verdict(self) -> tuple[str, str]:
        return LIGHTS.get(self.verdict, ""), self.sentence

    def _tables(self) -> list[str]:
        following = f"<p>Next: {escape(self.next_experiment)}</p>" if self.next_experiment else ""
        found = html_table(self.rows(), "What is missing") if self.effects else ""
        return [found, html_table(self._gap_rows(), "Gap on held-out runs"), following]

    def _picture(self) -> str:
        if not self.gap or not self.gap[0].held_out_rms:
            return ""
        return picture(lambda figure: self.plot(figure.add_subplot()), 5.6, 2.6)

    def plot(self, ax: Axes | None = None, **style: Any) -> Axes:
        """Error on held-out runs relative to the noise floor, step by step.

        Args:
            ax: axes to draw into; new ones when absent.
            style: passed on to `matplotlib.axes.Axes.plot`.
        """
        kept = [step for step in self.gap if not step.dropped]
        names = {effect.id: effect.common_name for effect in self.effects}
        steps = [_label(step, names) for step in kept]
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
