"""Building blocks: least squares, Runge-Kutta, the polynomial filter."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from ._arrays import array, shaped
from ._errors import DataError, UsageError
from ._result import Result
from ._view import Rows, known_and_unknown

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False, repr=False)
class LeastSquares(Result):
    """A solved system of n rows and p unknowns.

    Attributes:
        coefficients: θ̂, (p).
        standard_errors: σ_θ = √diag((HᵀH)⁻¹ σ̂²), equation (14) of the paper, (p).
        residual_std: σ̂ = √(|e|²/(n − p)), equation (15), unit of y.
        r_squared: 1 − |e|²/Σ(y − ȳ)² where H has a constant column, else 1 − |e|²/Σy².
        condition_number: cond(HᵀH), as the paper prints it.
        condition_number_scaled: cond(H) with columns of unit length.
        rank: rank of H: p, since less is an error.
        covariance: (HᵀH)⁻¹ σ̂², (p, p).
        names: names of the columns.
        system: H and y, from which residuals are computed on first access.
    """

    coefficients: Array
    standard_errors: Array
    residual_std: float
    r_squared: float
    condition_number: float
    condition_number_scaled: float
    rank: int
    covariance: Array
    names: tuple[str, ...]
    system: tuple[Array, Array] = field(repr=False, metadata={"own": True})

    title: ClassVar[str] = "Least squares"

    @cached_property
    def residuals(self) -> Array:
        """e = y − H θ̂, (n)."""
        h, y = self.system
        found = y - h @ self.coefficients
        freedom = len(y) - len(self.coefficients)
        expected, rounding = self.residual_std * np.sqrt(freedom), 1e-10 * np.linalg.norm(y)
        if not abs(np.linalg.norm(found) - expected) <= 1e-6 * expected + rounding:
            raise UsageError("H or y was changed after the fit: the residuals would be wrong")
        return np.asarray(found)

    @property
    def _t_95(self) -> float:
        """Half-width of a 95 % interval in standard errors, wider for few rows."""
        # a copy has residuals and no system
        rows = len(self.system[1]) or len(self.residuals)
        return _native.student_quantile(0.975, rows - len(self.coefficients))

    def to_dict(self) -> dict[str, Any]:
        """Plain data, the residuals among them."""
        return super().to_dict() | {"residuals": self.residuals.tolist()}

    def __reduce__(self) -> tuple[Any, ...]:
        # what a system of other rows would say of a copy: its residuals are kept, and H is not
        kept = {key: value for key, value in vars(self).items() if key != "system"}
        return (_solved, (kept | {"residuals": self.residuals},))

    def rows(self) -> Rows:
        """One row per coefficient, with its 95 % interval, by Student's t with n − p degrees of freedom."""
        columns = zip(self.names, self.coefficients.tolist(), self.standard_errors.tolist(), strict=True)
        return [
            {
                "": n,
                "coef": c,
                "std err": s,
                "t": c / s if s else None,
                "[0.025": c - self._t_95 * s,
                "0.975]": c + self._t_95 * s,
            }
            for n, c, s in columns
        ]

    def summary(self) -> str:
        """The coefficients with 95 % intervals, in the layout of statsmodels' summaries."""
        foot = (
            f"rows {len(self.residuals)}, rank {self.rank}, residual std {self.residual_std:.4g}, "
            f"R² {self.r_squared:.4g}, cond(HᵀH) {self.condition_number:.4g}, "
            f"cond scaled {self.condition_number_scaled:.4g}"
        )
        return super().summary() + "\n" + foot

    def plot(self, ax: Axes | None = None, **style: Any) -> Axes:
        """Half-width of the 95 % interval relative to each coefficient: which are known, and which are not.

        Args:
            ax: axes to draw into; new ones when absent.
            style: passed on to `matplotlib.axes.Axes.barh`.
        """
        columns = zip(self.names, self.coefficients.tolist(), self.standard_errors.tolist(), strict=True)
        return known_and_unknown(ax, [(n, c, s, "") for n, c, s in columns if c != 0.0 and s > 0.0], style, self._t_95)


def _solved(kept: dict[str, Any]) -> LeastSquares:
    solved = object.__new__(LeastSquares)
    vars(solved).update(kept, system=(np.empty((0, len(kept["coefficients"]))), np.empty(0)))
    return solved


def least_squares(H: ArrayLike, y: ArrayLike, names: Sequence[str] | None = None) -> LeastSquares:
    """Solves H θ = y by Householder QR; HᵀH is never formed. Arrays of doubles are read in place, in any order.

    Args:
        H: columns of regressors, (n, p).
        y: right-hand side, (n).
        names: names of the columns, for messages and tables; ``column 0``, … when absent.

    Raises:
        DataError: too few rows, linearly dependent columns, values that are not finite.
        UsageError: shapes that do not fit.

    >>> fit = least_squares([[1, 0], [1, 1], [1, 2], [1, 3], [1, 4]], [1, 3, 2, 5, 4])
    >>> fit.coefficients.round(12).tolist()
    [1.4, 0.8]
    """
    h, right = shaped(H, "H", 2), shaped(y, "y")
    called = tuple(names) if names is not None else tuple(f"column {k}" for k in range(h.shape[1]))
    if len(called) != h.shape[1]:
        raise UsageError(f"{len(called)} names for the {h.shape[1]} columns of H")
    if h.shape[0] != len(right):
        raise UsageError(f"H has {h.shape[0]} rows, but y has {len(right)}")
    if h.shape[1] == 0:
        raise UsageError("H has no column: nothing to estimate")
    try:
        solved = _native.least_squares(h, right, list(called))
    except DataError:
        # the same said of the arrays as they were given, where it is a value that is not finite
        array(h, "H", 2)
        array(right, "y")
        raise
    return LeastSquares(names=called, system=(h, right), **solved)


def rk4(f: Callable[[float, Array], ArrayLike], t: ArrayLike, y0: ArrayLike, substeps: int = 1) -> Array:
    """Solves ẏ = f(t, y) by the classical Runge-Kutta scheme of fourth order.

    Args:
        f: rate of y, (p), at the time t.
        t: instants, s, (n).
        y0: y at the first instant, (p).
        substeps: equal steps from one instant to the next.

    Returns:
        y at the instants, (n, p); whatever `f` raises passes through.

    Raises:
        DataError: the solution is not finite.

    >>> y = rk4(lambda t, y: -y, [0.0, 0.5, 1.0], [1.0], substeps=20)
    >>> bool(abs(y[-1, 0] - np.exp(-1.0)) < 1e-7)
    True
    """
    if substeps < 1:
        raise UsageError(f"substeps = {substeps}: at least one step per interval is needed")

    def rate(at: float, y: Array) -> Array:
        return np.ascontiguousarray(f(at, y), dtype=np.float64)

    return _native.rk4(rate, array(t, "t"), array(y0, "y0"), substeps)


def polynomial_filter(
    t: ArrayLike,
    x: ArrayLike,
    *,
    samples: int | None = None,
    seconds: float | None = None,
    degree: int = 2,
    gaps: Sequence[float] = (),
) -> tuple[Array, Array]:
    """Savitzky-Golay filter for even and uneven time: a polynomial fitted to the window about each sample.

    Args:
        t: time stamps, s, (n).
        x: values, (n).
        samples: width of the window as an odd number of samples, or
        seconds: as a time.
        degree: degree of the polynomial.
        gaps: time stamps at which a gap ends; no window spans a gap.

    Returns:
        The filtered values and their first time derivative.

    >>> t = np.linspace(0.0, 1.0, 11)
    >>> x, rate = polynomial_filter(t, t**2, samples=5)
    >>> bool(np.allclose(x, t**2) and np.allclose(rate, 2 * t))
    True
    """
    return _native.polynomial_filter(
        array(t, "t"), array(x, "x"), samples, seconds, degree, array(list(gaps), "gaps").tolist()
    )
