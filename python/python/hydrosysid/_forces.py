"""The result of `force_components`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from . import _native
from ._html import html_table, picture
from ._result import Result
from ._view import Rows, axes, latex_table, text_table

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True, eq=False, repr=False)
class Forces(Result):
    """Forces in one degree of freedom of one run, at the logged motion, SI units.

    Attributes:
        run: name of the run.
        dof: degree of freedom.
        time: time stamps, s: those of the velocity.
        velocity: velocity, m/s or rad/s.
        terms: force of each term on the vehicle, in `unit`.
        total: their sum, what accelerates the vehicle, in `unit`.
        unit: ``N`` or ``N*m``.
    """

    run: str
    dof: str
    time: NDArray[np.float64]
    velocity: NDArray[np.float64]
    terms: dict[str, NDArray[np.float64]]
    total: NDArray[np.float64]
    unit: str

    title: ClassVar[str] = "Forces"

    def rows(self) -> Rows:
        """One row per instant, one column per term, and their total."""
        columns = {"t": self.time, "velocity": self.velocity} | self.terms | {"total": self.total}
        lists = [values.tolist() for values in columns.values()]
        return [dict(zip(columns, row, strict=True)) for row in zip(*lists, strict=True)]

    def _brief_rows(self) -> Rows:
        forces = self.terms | {"total": self.total}
        rms = {name: float(np.sqrt(np.mean(force**2))) for name, force in forces.items()}
        return [{"term": name, "rms": size, "unit": self.unit} for name, size in rms.items()]

    def summary(self) -> str:
        """Root mean square of each term."""
        return text_table(self._brief_rows(), self._heading())

    def _heading(self) -> str:
        return f"{self.title} of {self.run}, {self.dof}"

    def _verdict(self) -> tuple[str, str]:
        sizes = [(row["rms"], row["term"]) for row in self._brief_rows()]
        if len(sizes) < 2 or not len(self.time):
            return "", ""
        (largest, term), (total, _) = max(sizes[:-1]), sizes[-1]
        unit = self.unit.replace("*", " ")
        words = f"{_native.common_name(term)} is the largest, {largest:.3g} {unit} rms"
        return (
            "",
            f"Of {len(sizes) - 1} terms {words}; the total, which accelerates the vehicle, is {total:.3g} {unit} rms.",
        )

    def _tables(self) -> list[str]:
        return [html_table(self._brief_rows())]

    def _picture(self) -> str:
        return picture(lambda figure: self.plot(figure.add_subplot()), 6.0, 2.4)

    def to_latex(self) -> str:
        """Root mean square of each term."""
        return latex_table(self._brief_rows())

    def plot(self, ax: Axes | None = None, **style: Any) -> Axes:
        """Force of each term, and their total, over time.

        Args:
            ax: axes to draw into; new ones when absent.
            style: passed on to `matplotlib.axes.Axes.plot`.
        """
        ax = axes(ax)
        for name, force in self.terms.items():
            ax.plot(self.time, force, **({"label": _native.common_name(name)} | style))
        look: dict[str, Any] = {"label": "total", "color": "k", "linewidth": 0.8}
        ax.plot(self.time, self.total, **(look | style))
        ax.set(xlabel="t, s", ylabel=f"force, {self.unit}", title=f"{self.run}, {self.dof}")
        ax.legend()
        return ax
