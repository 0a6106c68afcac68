"""The result of `cross_validate`."""

from __future__ import annotations

from dataclasses import dataclass
from statistics import median
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from ._html import picture
from ._result import Result
from ._view import Rows, axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True)
class OwnEstimate:
    """An estimate from one run alone, SI units."""

    term: str
    name: str
    value: float
    std: float


@dataclass(frozen=True)
class OwnModel:
    """Estimates from one run alone, for the degrees of freedom `dofs`."""

    run: str
    dofs: tuple[str, ...]
    estimates: tuple[OwnEstimate, ...]


@dataclass(frozen=True)
class Crossed:
    """The model of one run simulated on another.

    Attributes:
        model: run to which the model was fitted.
        run: run on which it was simulated.
        dof: degree of freedom; the channel of the position or angle (`z`, `psi`) where the run logs no velocity.
        mean_abs: mean of the absolute error, equation (25) of the paper, m/s or rad/s; m or rad of a position or angle.
        std_abs: its standard deviation, in the same unit.
    """

    model: str
    run: str
    dof: str
    mean_abs: float
    std_abs: float


def compared_unit(dof: str) -> str:
    """Unit of the velocity of a degree of freedom, or of a position or angle by its channel."""
    units = {"roll": "rad/s", "pitch": "rad/s", "yaw": "rad/s", "phi": "rad", "theta": "rad", "psi": "rad"}
    return units.get(dof, "m" if dof in ("x", "y", "z") else "m/s")


@dataclass(frozen=True, eq=False, repr=False)
class CrossValidation(Result):
    """Each run's own model on every other run.

    Attributes:
        format: 1.
        models: one per run that can be fitted alone.
        crossed: each model on each run, by degree of freedom.
        left_out: names of runs that were left out; the twenty longest make models, and of the others the twenty longest
            are simulated.
    """

    format: int
    models: tuple[OwnModel, ...]
    crossed: tuple[Crossed, ...]
    left_out: tuple[str, ...] = ()

    title: ClassVar[str] = "Each run's own model on every run"

    def rows(self) -> Rows:
        """One row per model, a run and a degree of freedom."""
        return [dict(vars(cell)) for cell in self.crossed]

    def _verdict(self) -> tuple[str, str]:
        own = {(cell.run, cell.dof): cell.mean_abs for cell in self.crossed if cell.model == cell.run}
        ratios = [
            (cell.mean_abs / own[cell.run, cell.dof], cell)
            for cell in self.crossed
            if cell.model != cell.run and own.get((cell.run, cell.dof), 0.0) > 0.0
        ]
        if not ratios:
            return "", "No model could be simulated on another run."
        worst, cell = max(ratios, key=lambda entry: entry[0])
        typical = median(ratio for ratio, _ in ratios)
        return "", (
            f"Models of other runs err {typical:.2g} × as much as a run's own (median), at most {worst:.2g} ×: "
            f"{cell.model} on {cell.run} in {cell.dof}."
        )

    def _picture(self) -> str:
        return picture(lambda figure: self.plot(ax=figure.add_subplot()), 4.6, 3.2) if self.crossed else ""

    def plot(self, dof: str | None = None, ax: Axes | None = None, **style: Any) -> Axes:
        """The matrix of one degree of freedom: one row per model, one column per run.

        Args:
            dof: degree of freedom; the first when absent.
            ax: axes to draw into; new ones when absent.
            style: passed on to `matplotlib.axes.Axes.imshow`.
        """
        ax = axes(ax)
        first = self.crossed[0].dof if self.crossed else ""
        chosen = first if dof is None else dof
        cells = {(cell.model, cell.run): cell.mean_abs for cell in self.crossed if cell.dof == chosen}
        if not cells:
            raise KeyError(
                f"no degree of freedom {dof!r}; there are {', '.join(sorted({c.dof for c in self.crossed}))}"
            )
        models, runs = (list(dict.fromkeys(pair[k] for pair in cells)) for k in (0, 1))
        matrix = np.array([[cells.get((model, run), np.nan) for run in runs] for model in models])
        ax.imshow(matrix, **({"cmap": "Blues"} | style))
        for (row, column), error in np.ndenumerate(matrix):
            dark = error > 0.5 * (np.nanmin(matrix) + np.nanmax(matrix))
            ax.text(column, row, f"{error:.3g}", ha="center", va="center", color="w" if dark else "k")
        ax.set_xticks(range(len(runs)), runs, rotation=45, ha="right")
        ax.set_yticks(range(len(models)), models)
        ax.set(xlabel="simulated run", ylabel="model of", title=f"mean |error| in {chosen}, {compared_unit(chosen)}")
        return ax
