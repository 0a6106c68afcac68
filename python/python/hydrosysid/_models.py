"""The results of `export`, of comparing two models or published parameters, and of `monitor`."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field, replace
from statistics import median
from typing import TYPE_CHECKING, Any, ClassVar

from ._errors import Finding
from ._html import html_table, picture
from ._motion import Disagreement
from ._noise import Noise
from ._result import Result
from ._view import Z_95, Rows, axes, bars, over_noise, probability, text_table

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


MOST_RUNS = 20
"""Runs of which the small picture shows the errors."""


@dataclass(frozen=True, eq=False, repr=False)
class Export(Result):
    """A model as a file for another tool.

    Attributes:
        format: 1.
        target: name of the target.
        version: versions of the target for which the file is meant.
        lost: terms and coefficients of the model that the file cannot represent.
        warnings: warnings and notes.
        content: the file.
    """

    format: int
    target: str
    version: str
    lost: tuple[str, ...]
    warnings: tuple[Finding, ...]
    content: bytes = field(default=b"", metadata={"own": True})

    title: ClassVar[str] = "Export"

    @property
    def text(self) -> str:
        """The file as text; not for ``linear-mat``."""
        return self.content.decode()

    def rows(self) -> Rows:
        """One row per term or coefficient that is lost."""
        return [{"target": self.target, "lost": name} for name in self.lost]


class _Apart(Result, ABC):
    """Parameters next to others of the same name, and their differences."""

    parameters: tuple[ParameterDifference, ...] | tuple[PublishedParameter, ...]

    @abstractmethod
    def _difference(self) -> str:
        """What of what, in words."""

    def rows(self) -> Rows:
        """One row per parameter."""
        return [dict(vars(p)) for p in self.parameters]

    def _picture(self) -> str:
        known = sum(p.z is not None for p in self.parameters)
        return picture(lambda figure: self.plot(figure.add_subplot()), 5.2, 0.8 + 0.26 * known) if known else ""

    def plot(self, ax: Axes | None = None, **style: Any) -> Axes:
        """Difference of each parameter in units of its standard error, with the 95 % band.

        Args:
            ax: axes to draw into; new ones when absent.
            style: passed on to `matplotlib.axes.Axes.barh`.
        """
        known = [(f"{p.effect} {p.name}", p.z) for p in self.parameters if p.z is not None]
        ax = bars(ax, known, 0.0, f"{self._difference()}, standard deviations", style)
        ax.axvspan(-Z_95, Z_95, color="0.9", zorder=0)
        return ax


@dataclass(frozen=True)
class ParameterDifference:
    """One parameter of two models: `b` minus `a`, its standard error, 95 % interval, z and probability."""

    effect: str
    name: str
    unit: str
    a: float
    b: float
    std_a: float | None
    std_b: float | None
    difference: float
    std: float | None
    interval: tuple[float, ...] | None
    z: float | None
    p_value: float | None


@dataclass(frozen=True)
class Joint:
    """All common parameters together, with their covariances."""

    chi_squared: float
    degrees_of_freedom: int
    p_value: float


@dataclass(frozen=True, eq=False, repr=False)
class ModelDifference(_Apart):
    """The comparison of two models of a vehicle.

    Attributes:
        format: 1.
        a: name of the first model.
        b: name of the second model.
        parameters: those of both models.
        only_a: parameters of the first only.
        only_b: parameters of the second only.
        joint: all common parameters together.
        warnings: warnings and notes.
    """

    format: int
    a: str
    b: str
    parameters: tuple[ParameterDifference, ...]
    only_a: tuple[str, ...]
    only_b: tuple[str, ...]
    joint: Joint | None
    warnings: tuple[Finding, ...]

    title: ClassVar[str] = "Two models"

    def _difference(self) -> str:
        return f"{self.b} minus {self.a}"

    def _verdict(self) -> tuple[str, str]:
        if self.joint is None:
            return "", ""
        same = self.joint.p_value >= 0.05
        words = "the difference is within its uncertainty" if same else "the models differ"
        return (
            "green" if same else "red",
            f"{words}: {probability(self.joint.p_value)} of all common parameters together",
        )


@dataclass(frozen=True)
class PublishedParameter:
    """A published parameter next to your own estimate, in the signs of this package."""

    effect: str
    name: str
    unit: str
    sname: str | None
    published: float | None
    published_std: float | None
    own: float | None
    own_std: float | None
    interval: tuple[float, ...] | None
    z: float | None
    p_value: float | None


@dataclass(frozen=True, eq=False, repr=False)
class PublishedComparison(_Apart):
    """Published parameters compared with the runs of a campaign and your own estimates.

    Attributes:
        format: 1.
        source: where the published parameters come from.
        runs: errors of the published model on each run and degree of freedom.
        own_runs: the same for your own model.
        parameters: each parameter next to your own estimate.
        warnings: warnings and notes.
        noise: noise with which the published model explains the runs best, and its predictions.
        own_noise: the same for your own model.
    """

    format: int
    source: str
    runs: tuple[Disagreement, ...]
    own_runs: tuple[Disagreement, ...]
    parameters: tuple[PublishedParameter, ...]
    warnings: tuple[Finding, ...]
    noise: Noise | None = None
    own_noise: Noise | None = None

    title: ClassVar[str] = "Published parameters"

    def _difference(self) -> str:
        return "published minus own"

    def _verdict(self) -> tuple[str, str]:
        told = [(p.p_value, f"{p.effect} {p.name}") for p in self.parameters if p.p_value is not None]
        errors = _errors_over(self.runs, self.own_runs)
        if not told:
            return "", f"No published parameter has an estimate to be compared with{errors}."
        # of several parameters the least p-value, by Bonferroni
        least, name = min(told)
        joint = min(1.0, len(told) * least)
        agree = joint >= 0.05
        words = "agree with your own estimates" if agree else f"differ from your own estimates, most of all {name}"
        return "green" if agree else "red", f"The published parameters {words} ({probability(joint)}){errors}."

    def _picture(self) -> str:
        parameters = sum(p.z is not None for p in self.parameters)
        runs = min(len(self.runs), MOST_RUNS)
        if not parameters and not runs:
            return ""
        some = replace(self, runs=self.runs[:runs], own_runs=self.own_runs[:runs])

        def draw(figure: Figure) -> None:
            parts = [self.plot] * bool(parameters) + [some.plot_errors] * bool(runs)
            for part, ax in zip(parts, figure.subplots(1, len(parts), squeeze=False)[0], strict=True):
                part(ax)

        return picture(draw, 9.0, 1.0 + 0.26 * max(parameters, runs))

    def plot_errors(self, ax: Axes | None = None, **style: Any) -> Axes:
        """Root mean square error of both models on each run relative to the noise floor, on a logarithmic scale.

        Args:
            ax: axes to draw into; new ones when absent.
            style: passed on to `matplotlib.axes.Axes.plot`.
        """
        ax = axes(ax)
        place = list(range(len(self.runs)))[::-1]
        for label, runs, colour in (("own", self.own_runs, "C0"), ("published", self.runs, "C1")):
            ratios = [entry.rms / entry.noise_floor for entry in runs]
            ax.plot(ratios, place, **({"marker": "o", "linestyle": "", "color": colour, "label": label} | style))
        ax.axvline(1.0, color="0.3", linewidth=0.8)
        ax.set_xscale("log")
        ax.set_yticks(place, [f"{entry.run} {entry.dof}" for entry in self.runs])
        ax.set_xlabel("rms error over sensor noise")
        ax.margins(y=0.3)
        ax.legend()
        return ax


def _errors_over(published: tuple[Disagreement, ...], own: tuple[Disagreement, ...]) -> str:
    """How much more the published model errs than your own, in words: the median over held-out runs."""
    held_out = [(a, b) for a, b in zip(published, own, strict=True) if a.role == "validate"]
    pairs = held_out or list(zip(published, own, strict=True))
    ratios = [a.rms / b.rms for a, b in pairs if b.rms > 0.0]
    if not ratios:
        return ""
    return f"; its errors are {median(ratios):.2g} × those of your own model{' on held-out runs' if held_out else ''}"


@dataclass(frozen=True)
class Window:
    """One window of a log in one degree of freedom; `off` where the model does not fit there."""

    run: str
    dof: str
    from_: float = field(metadata={"key": "from"})
    to: float
    samples: int
    rms: float
    mean: float
    noise: float
    chi_squared: float
    likelihood_ratio: float
    p_value: float
    cusum: float
    large: bool
    off: bool


@dataclass(frozen=True)
class Shift:
    """A lasting change: from `from_` seconds on, innovations are `times_noise` times the expected size; their mean is
    `shift`."""

    run: str
    dof: str
    from_: float = field(metadata={"key": "from"})
    times_noise: float
    shift: float


@dataclass(frozen=True)
class Reason:
    """A change that would explain the disagreement.

    Attributes:
        id: term whose parameter has changed, or effect that has appeared.
        known: whether the term is in the model.
        parameter: symbol of its first parameter.
        before: its value in the model; `None` for an effect that has appeared.
        after: its value after the change, to first order.
        unit: its unit.
        explained: share of the disagreement that it explains, 0 to 1.
        meaning: the most likely cause.
    """

    id: str
    known: bool
    parameter: str
    before: float | None
    after: float | None
    unit: str
    explained: float
    meaning: str


@dataclass(frozen=True, eq=False, repr=False)
class Monitored(Result):
    """A model monitored along new logs.

    Attributes:
        format: 1.
        fits: whether the model still fits.
        changes: lasting changes.
        reasons: likely reasons, the best first.
        windows: all windows.
        warnings: warnings and notes.
        noise: the noise of the model, and its predictions of these logs; `None` if the model has none.
    """

    format: int
    fits: bool
    changes: tuple[Shift, ...]
    reasons: tuple[Reason, ...]
    windows: tuple[Window, ...]
    warnings: tuple[Finding, ...]
    noise: Noise | None = None

    title: ClassVar[str] = "Model along a log"

    def rows(self) -> Rows:
        """One row per window and degree of freedom."""
        return [{("from" if key == "from_" else key): value for key, value in vars(w).items()} for w in self.windows]

    def _verdict(self) -> tuple[str, str]:
        return ("green", "the model still fits") if self.fits else ("red", "the model no longer fits")

    def _tables(self) -> list[str]:
        # the reasons first; of the windows those where it does not fit
        off = [row for row, window in zip(self.rows(), self.windows, strict=True) if window.off]
        reasons = [dict(vars(r)) for r in self.reasons]
        return [html_table(reasons, "Likely reasons") if reasons else "", html_table(off, "Windows off") if off else ""]

    def _picture(self) -> str:
        return picture(lambda figure: self.plot(ax=figure.add_subplot()), 6.0, 2.3) if self.windows else ""

    def summary(self) -> str:
        """Changes and reasons as text."""
        verdict = "the model still fits" if self.fits else "the model no longer fits"
        reasons = text_table([dict(vars(r)) for r in self.reasons], "Likely reasons") if self.reasons else ""
        return "\n".join(part for part in [f"{self.title}: {verdict}", reasons, *self._remarks()] if part)

    def plot(self, run: str | None = None, ax: Axes | None = None, **style: Any) -> Axes:
        """Disagreement over noise of each window of a run, one line a degree of freedom.

        Args:
            run: name of the run; the first when absent.
            ax: axes to draw into; new ones when absent.
            style: passed on to the lines.
        """
        name = self.windows[0].run if run is None else run
        lines = {}
        for dof in dict.fromkeys(w.dof for w in self.windows if w.run == name):
            own = [w for w in self.windows if w.run == name and w.dof == dof]
            lines[dof] = ([0.5 * (w.from_ + w.to) for w in own], [w.rms / w.noise for w in own])
        ax = over_noise(ax, lines, "disagreement over noise", style)
        ax.set(xlabel="t, s", title=name)
        return ax
