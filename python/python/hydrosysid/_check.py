"""The result of `check`."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar

from ._errors import Finding
from ._html import picture
from ._result import Result
from ._view import Rows, axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes


MOST_LOGS = 20
"""Logs of which the small picture shows the lights."""


@dataclass(frozen=True)
class CheckedLog:
    """One log or run that was checked; `rows` samples over `duration` s.

    `lights` holds one light per topic, `log_findings` faults that a model could mistake for an effect. They rest on
    `rates` of the channels (Hz), `agreements` of sensors with each other (factor, latency in s), `answers` of the
    motion to its commands (gain, delay in s), the `excitation` of each degree of freedom, and `loops` that hold a
    speed.
    """

    file: str
    verdict: str
    rows: int
    duration: float
    segments: int
    channels: tuple[str, ...]
    lights: tuple[dict[str, Any], ...] = ()
    log_findings: tuple[dict[str, Any], ...] = ()
    rates: tuple[dict[str, Any], ...] = ()
    agreements: tuple[dict[str, Any], ...] = ()
    answers: tuple[dict[str, Any], ...] = ()
    excitation: tuple[dict[str, Any], ...] = ()
    loops: tuple[dict[str, Any], ...] = ()
    kind: str | None = None
    role: str | None = None


@dataclass(frozen=True, eq=False, repr=False)
class Check(Result):
    """The check of logs or a campaign.

    Attributes:
        format: 1.
        verdict: ``green``, ``amber`` or ``red``.
        logs: one entry per log or run.
        warnings: warnings and notes.
        errors: the reasons for refusals.
    """

    format: int
    verdict: str
    logs: tuple[CheckedLog, ...]
    warnings: tuple[Finding, ...]
    errors: tuple[Finding, ...]

    title: ClassVar[str] = "Check"

    def rows(self) -> Rows:
        """One row per log, with its light of each topic."""
        keys = ("file", "verdict", "rows", "duration", "segments", "kind", "role")
        lights = [{light["topic"]: light["light"] for light in log.lights} for log in self.logs]
        return [{key: getattr(log, key) for key in keys} | own for log, own in zip(self.logs, lights, strict=True)]

    def _verdict(self) -> tuple[str, str]:
        told = {"green": "nothing argues against a fit", "amber": "usable, with the findings below", "red": "refused"}
        return self.verdict, told.get(self.verdict, "")

    def _picture(self) -> str:
        shown = self.logs[:MOST_LOGS]
        topics = {light["topic"] for log in shown for light in log.lights}
        if not topics:
            return ""
        some = replace(self, logs=shown)
        size = 2.2 + 0.42 * len(topics), 1.4 + 0.26 * len(shown)
        return picture(lambda figure: some.plot(figure.add_subplot(), s=55.0), *size)

    def plot(self, ax: Axes | None = None, **style: Any) -> Axes:
        """The light of each topic and log; a topic that a log does not have is left out.

        Args:
            ax: axes to draw into; new ones when absent.
            style: passed on to `matplotlib.axes.Axes.scatter`.
        """
        ax = axes(ax)
        topics = list(dict.fromkeys(light["topic"] for log in self.logs for light in log.lights))
        names = {"green": "tab:green", "amber": "tab:orange", "red": "tab:red"}
        lights = [(k, light) for k, log in enumerate(self.logs) for light in log.lights if light["light"] in names]
        found = [(topics.index(light["topic"]), k, light["light"]) for k, light in lights]
        colours = [names[light] for *_, light in found]
        look: dict[str, Any] = {"s": 120.0, "c": colours}
        ax.scatter([x for x, *_ in found], [y for _, y, _ in found], **(look | style))
        ax.set_xticks(range(len(topics)), topics, rotation=45, ha="right")
        ax.set_yticks(range(len(self.logs)), [log.file for log in self.logs])
        ax.set_ylim(len(self.logs) - 0.5, -0.5)
        return ax
