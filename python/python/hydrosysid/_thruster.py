"""A thruster's curve from a bollard-pull table."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from numpy.typing import ArrayLike

from . import _native
from ._arrays import array
from ._result import Result
from ._view import Rows, known_and_unknown

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True)
class Estimate:
    """A number and its standard deviation; 0 for a held number."""

    value: float
    std: float


@dataclass(frozen=True)
class ThrustDirection:
    """One direction of a thruster: |F| = a x² + b x, N, with x = max(0, |V| − deadband); covariance of a and b."""

    a: Estimate
    b: Estimate
    rows: int
    residual_std: float
    covariance: float = 0.0


@dataclass(frozen=True, eq=False, repr=False)
class ThrusterFit(Result):
    """A thruster's curve, |F| = (a x² + b x) (V_s/V_ref)ⁿ with x = max(0, |V| − deadband).

    Attributes:
        forward: coefficients for positive commands.
        reverse: coefficients for negative commands.
        deadband: dead band, unit of the command.
        exponent: n of the supply voltage; `None` if the table has fewer than two.
    """

    forward: ThrustDirection
    reverse: ThrustDirection
    deadband: Estimate
    exponent: Estimate | None

    title: ClassVar[str] = "Thruster"

    def _found(self) -> list[tuple[str, Estimate]]:
        sides = (("forward", self.forward), ("reverse", self.reverse))
        found = [(f"{side} {name}", getattr(d, name)) for side, d in sides for name in ("a", "b")]
        return [*found, ("dead band", self.deadband), *([("exponent", self.exponent)] if self.exponent else [])]

    def rows(self) -> Rows:
        """One row per coefficient."""
        return [{"": name, "coef": e.value, "std err": e.std or "held"} for name, e in self._found()]

    def plot(self, ax: Axes | None = None, **style: Any) -> Axes:
        """Half of the 95 % interval as a share of each coefficient: which are known, and which are not.

        Args:
            ax: axes to draw into; new ones when absent.
            style: passed on to `matplotlib.axes.Axes.barh`.
        """
        free = [(name, e) for name, e in self._found() if e.std > 0.0 and e.value != 0.0]
        return known_and_unknown(ax, [(name, e.value, e.std, "") for name, e in free], style)


def fit_thruster(
    command: ArrayLike,
    force: ArrayLike,
    *,
    deadband: float | None = 0.0,
    supply: ArrayLike | None = None,
    reference_supply: float | None = None,
) -> ThrusterFit:
    """Fits a thruster's curve, equation (1) of the paper, to a bollard-pull table.

    Args:
        command: control voltage or normalised command of each row, (n).
        force: measured force, N, with the sign of the command, (n).
        deadband: fixed at this value, as in the paper at 0; `None`: fitted to the table.
        supply: supply voltage of each row, V.
        reference_supply: supply voltage at which the coefficients hold, V; the median when absent.

    Raises:
        DataError: a table that does not determine a curve.

    >>> import numpy as np
    >>> v = np.linspace(-1.0, 1.0, 21)
    >>> fit = fit_thruster(v, 30.0 * v * abs(v) + 10.0 * v)
    >>> round(fit.forward.a.value, 9), round(fit.reverse.b.value, 9)
    (30.0, 10.0)
    """
    volts = None if supply is None else array(supply, "supply")
    found = _native.fit_thruster(array(command, "command"), array(force, "force"), deadband, volts, reference_supply)

    def direction(entry: tuple[tuple[float, float], tuple[float, float], int, float, float]) -> ThrustDirection:
        a, b, rows, residual, covariance = entry
        return ThrustDirection(Estimate(*a), Estimate(*b), rows, residual, covariance)

    exponent = found["exponent"]
    return ThrusterFit(
        forward=direction(found["forward"]),
        reverse=direction(found["reverse"]),
        deadband=Estimate(*found["deadband"]),
        exponent=None if exponent is None else Estimate(*exponent),
    )
