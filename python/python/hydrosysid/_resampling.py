"""The result of `resample`, and the block bootstrap of a linear system."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from ._arrays import array
from ._errors import UsageError
from ._progress import Progress, listener
from ._result import Result
from ._view import Rows


@dataclass(frozen=True)
class Scatter:
    """How far the refits of one parameter scatter, SI units.

    Attributes:
        term: ``id``, ``id@dof`` or ``id@dof:other``.
        name: symbol.
        value: the estimate that the draws start from.
        mean: mean of the draws; what it is off `value` is bias.
        std: standard deviation of the draws.
        interval: 2.5 and 97.5 per cent of the draws lie below.
        unit: unit.
        run: the run whose value it is; `None` for a common one.
    """

    term: str
    name: str
    value: float
    mean: float
    std: float
    interval: tuple[float, float]
    unit: str
    run: str | None = None


@dataclass(frozen=True, eq=False, repr=False)
class Resampling(Result):
    """Refits of a campaign.

    Attributes:
        format: 1.
        method: ``bootstrap`` or ``monte_carlo``.
        draws: refits that took part.
        failed: refits without a solution, left out.
        seed: seed of the draws.
        parameters: scatter of each free parameter.
    """

    title: ClassVar[str] = "Refits"

    format: int
    method: str
    draws: int
    failed: int
    seed: int
    parameters: tuple[Scatter, ...]

    def rows(self) -> Rows:
        """One row a parameter."""
        return [
            {
                "term": p.term,
                "run": p.run,
                "value": p.value,
                "mean": p.mean,
                "std": p.std,
                "low": p.interval[0],
                "high": p.interval[1],
                "unit": p.unit,
            }
            for p in self.parameters
        ]


def block_bootstrap(
    H: ArrayLike,
    y: ArrayLike,
    *,
    block: int,
    draws: int = 1000,
    seed: int = 1,
    progress: Progress = None,
) -> NDArray[np.float64]:
    """Least-squares solutions of H θ = y on blocks of rows that are drawn with replacement, on all cores.

    Args:
        H: columns of regressors, (n, p).
        y: right-hand side, (n).
        block: rows of a block: longer than residuals stay correlated.
        draws: number of refits.
        seed: seed of the draws; the result does not depend on the number of cores.
        progress: called as ``progress(what, done, of)``; `True` shows a bar.

    Returns:
        θ of each refit, (draws, p); refits without a solution are left out.

    Raises:
        DataError: as `least_squares`, and fewer than two blocks.

    >>> x = np.linspace(0.0, 1.0, 200)
    >>> y = 2.0 * x + np.random.default_rng(1).normal(0.0, 0.1, 200)
    >>> thetas = block_bootstrap(x[:, None], y, block=10)
    >>> bool(abs(thetas.mean() - 2.0) < 0.1 and 0.005 < thetas.std() < 0.02)
    True
    """
    if block < 1 or draws < 1:
        raise UsageError(f"block = {block}, draws = {draws}: both are at least 1")
    h, right = array(H, "H", 2), array(y, "y")
    if h.shape[0] != len(right):
        raise UsageError(f"H has {h.shape[0]} rows, y has {len(right)}")
    with listener(progress) as heard:
        return _native.block_bootstrap(h, right, block, draws, seed, heard)
