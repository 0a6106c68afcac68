"""The result of `fit`."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from statistics import NormalDist
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from . import _native
from ._errors import Finding, UsageError
from ._html import html_table, picture
from ._model import Model
from ._noise import Noise
from ._result import Result
from ._thruster import Estimate, ThrustDirection
from ._view import (
    UNSETTLED,
    Z_95,
    Rows,
    deviation,
    known_and_unknown,
    labelled,
    latex_table,
    number,
    stacked,
    text_table,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True)
class Parameter:
    """One parameter of a fit, in SI units.

    Attributes:
        effect: id of the effect.
        dof: degree of freedom of its balance; `None` for the whole vehicle.
        name: symbol, ``k_u|u|``.
        value: value.
        std: standard error; 0 for a fixed parameter.
        std_paper: standard deviation by equation (14) of the paper.
        unit: unit.
        sname: SNAME's name of the same quantity, ``X_u|u|``.
        sname_value: SNAME's value, which has the opposite sign; of an inertia and a coupling the added part.
        fixed: whether it was fixed.
        other: the other degree of freedom of a coupling.
        per_run: values of a parameter with one in each run.
    """

    effect: str
    dof: str | None
    name: str
    value: float
    std: float | None
    std_paper: float | None
    unit: str
    sname: str | None
    sname_value: float | None
    fixed: bool
    other: str | None = None
    per_run: dict[str, float] = field(default_factory=dict)

    @property
    def term(self) -> str:
        """``id``, ``id@dof`` or ``id@dof:other``."""
        place = ":".join(d for d in (self.dof, self.other) if d)
        return f"{self.effect}@{place}" if place else self.effect


def _no_model() -> Model:
    return Model('hydrosysid = ""\n[model]\n')


@dataclass(frozen=True)
class StageEstimate:
    """What one stage of the staged procedure has estimated, SI units."""

    effect: str
    dof: str
    name: str
    value: float
    std: float
    std_paper: float
    unit: str


@dataclass(frozen=True)
class Stage:
    """One fit that is part of a result; residual in the unit of the fitted quantity.

    `estimates` are those of a stage of the staged procedure, `numbers` the flow numbers of a single oscillation
    (``reynolds``, ``keulegan_carpenter``, ``lambda``, ``inertia_coefficient``).
    """

    name: str
    dof: str
    runs: tuple[str, ...]
    rows: int
    residual_std: float
    condition_number: float
    condition_number_scaled: float
    estimates: tuple[StageEstimate, ...] = ()
    numbers: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class FittedCurve:
    """The curve of thrusters fitted to their bollard table, equation (1)."""

    thrusters: tuple[str, ...]
    file: str
    forward: ThrustDirection
    reverse: ThrustDirection
    deadband: Estimate
    supply_exponent: Estimate | None = None


@dataclass(frozen=True, eq=False)
class RunResiduals:
    """The residuals of one run in one channel.

    Attributes:
        run: name of the run.
        channel: the channel; of integral least squares the degree of freedom whose balance it is.
        time: time stamps, s, (n); of a row of a balance its end.
        values: residuals, (n): of filter error measured less predicted one sample ahead, of output error measured less
            simulated, both in the unit of the channel; of integral least squares the impulse that the balance lacks,
            N·s or N·m·s.
        std: deviation that the filter expects of each, (n); empty of other estimators.
    """

    run: str
    channel: str
    time: NDArray[np.float64]
    values: NDArray[np.float64]
    std: NDArray[np.float64]


@dataclass(frozen=True, eq=False, repr=False)
class Fit(Result):
    """A fitted campaign.

    Attributes:
        format: 1.
        sentence: the verdict in words.
        converged: whether the estimator converged.
        parameters: the parameters, in the order of the model.
        estimator: ``filter_error``, ``output_error``, ``staged`` or ``integral``.
        std_method: how `Parameter.std` was computed.
        covariance: covariance in the order of `parameters`, SI, (p, p).
        stages: the fits of which it consists.
        warnings: warnings and notes.
        thrusters: curves of thrusters that were fitted to bollard tables.
        identifiability: what the data determine and what they do not (inflation, force shares, halves, groups,
            correlations, condition indices); `None` of a streamed fit.
        noise: random force, sensor noise, and prediction errors; of filter error only.
        model: the result as a model, which `simulate`, `compare` and `export` accept; `Model.to_toml` is
            its text, `Model.save` writes the file that the command's ``--model`` reads.
        residuals: residuals of the training runs, one entry per run and channel; none of the staged procedure, each
            of whose stages has rows of its own, of a streamed fit, and of `map_fit`.
    """

    format: int
    sentence: str
    converged: bool
    parameters: tuple[Parameter, ...]
    estimator: str
    std_method: str
    covariance: NDArray[np.float64]
    stages: tuple[Stage, ...]
    warnings: tuple[Finding, ...]
    thrusters: tuple[FittedCurve, ...] = ()
    identifiability: Any = None
    noise: Noise | None = None
    model: Model = field(default_factory=_no_model, metadata={"own": True})
    residuals: tuple[RunResiduals, ...] = field(default=(), metadata={"own": True})

    title: ClassVar[str] = "Fit"

    def rows(self) -> Rows:
        """One row per parameter."""
        return [
            {
                "effect": p.term,
                "name": p.name,
                "value": p.value,
                "std": p.std,
                "std_paper": p.std_paper,
                "unit": p.unit,
                "sname": p.sname,
                "sname_value": p.sname_value,
                "fixed": p.fixed,
            }
            for p in self.parameters
        ]

    def __getitem__(self, name: str) -> Parameter:
        """The parameter of the term ``id@dof``, or of this symbol."""
        found = [p for p in self.parameters if name in (p.term, p.name)]
        if len(found) != 1:
            names = ", ".join(p.term for p in found or self.parameters)
            raise KeyError(f"{name!r} names {len(found)} parameters; there are {names}")
        return found[0]

    @property
    def names(self) -> list[str]:
        """Effect and symbol of each parameter, ``inertia@surge m_u``: the labels of `params` and `bse`."""
        return [f"{p.term} {p.name}" for p in self.parameters]

    @property
    def params(self) -> Any:
        """Estimates, SI: a pandas Series over `names`."""
        return labelled([p.value for p in self.parameters], self.names)

    @property
    def bse(self) -> Any:
        """Standard errors, SI: a pandas Series over `names`; 0 for a fixed parameter."""
        return labelled([p.std for p in self.parameters], self.names)

    @property
    def nobs(self) -> int:
        """Number of observations: of residuals, where the fit has them, else of rows of its stages."""
        return sum(len(r.values) for r in self.residuals) or sum(s.rows for s in self.stages)

    @property
    def resid(self) -> Any:
        """The `residuals` as a pandas Series over run, channel and time, ``fit.resid["dive.csv", "u"]``.

        Raises:
            UsageError: this fit keeps none.
        """
        if not self.residuals:
            raise UsageError(f"this fit by {self.estimator.replace('_', ' ')} keeps no residuals: see `stages`")
        parts = [((r.run, r.channel), r.time, r.values) for r in self.residuals]
        return stacked(parts, ["run", "channel", "t"], "resid")

    def conf_int(self, alpha: float = 0.05) -> Any:
        """Normal confidence intervals of level 1 - `alpha`: a pandas DataFrame of `lower` and `upper`.

        Raises:
            ValueError: `alpha` is not between 0 and 1.
        """
        if not 0.0 < alpha < 1.0:
            raise ValueError(f"alpha is {alpha}; it must be the probability of a miss, between 0 and 1")
        reach = NormalDist().inv_cdf(1.0 - 0.5 * alpha)
        value = np.array([p.value for p in self.parameters], dtype=float)
        std = np.array([p.std for p in self.parameters], dtype=float)
        return labelled(np.column_stack([value - reach * std, value + reach * std]), self.names, ["lower", "upper"])

    def cov_params(self) -> Any:
        """Covariance of the estimates, SI: a pandas DataFrame over `names` twice."""
        return labelled(self.covariance, self.names, self.names)

    def summary(self) -> str:
        """The parameters, then the stages, in the layout of statsmodels' summaries.

        z is coef over std err, P the probability of a value as large by chance if the true value is 0.
        """

        def z(p: Parameter) -> float | None:
            return p.value / p.std if p.std and not p.fixed else None

        parameters = [
            {
                "": f"{p.term} {p.name}",
                "coef": p.value,
                "std err": "held" if p.fixed else deviation(p.std, self.converged),
                "z": z(p),
                "P>|z|": None if z(p) is None else math.erfc(abs(z(p) or 0.0) / math.sqrt(2.0)),
                "[0.025": None if p.std is None or p.fixed else p.value - Z_95 * p.std,
                "0.975]": None if p.std is None or p.fixed else p.value + Z_95 * p.std,
                "unit": p.unit,
            }
            for p in self.parameters
        ]
        title = f"Fit by {self.estimator.replace('_', ' ')}"
        done = "converged" if self.converged else f"not converged: what is marked {UNSETTLED} is not a standard error"
        foot = f"{self.nobs} observations, {done}; standard errors: {self.std_method}"
        parts = [self.sentence, text_table(parameters, title), foot]
        if self.stages:
            parts.append(text_table(self._stage_rows(), "Stages"))
        return "\n".join([*parts, *self._remarks()])

    def to_latex(self) -> str:
        """The parameters as a LaTeX ``tabular``; a fit that did not converge has its standard errors marked ``?``."""
        stds = ("std", "std_paper")
        marked = [{key: deviation(row[key], self.converged) for key in stds} for row in self.rows()]
        return latex_table([row | own for row, own in zip(self.rows(), marked, strict=True)])

    def _stage_rows(self) -> Rows:
        return [
            {
                "stage": s.name,
                "dof": s.dof,
                "rows": s.rows,
                "residual": s.residual_std,
                "cond(HᵀH)": s.condition_number,
                "cond scaled": s.condition_number_scaled,
            }
            for s in self.stages
        ]

    def _heading(self) -> str:
        return f"Fit by {self.estimator.replace('_', ' ')}"

    def _verdict(self) -> tuple[str, str]:
        doubtful = any(f.severity == "warning" for f in self.warnings)
        return "red" if not self.converged else "amber" if doubtful else "green", self.sentence

    def _tables(self) -> list[str]:
        return [html_table(self._shown_rows()), html_table(self._stage_rows(), "Stages")]

    def _shown_rows(self) -> Rows:
        def interval(p: Parameter) -> str:
            ends = [number(p.value + way * Z_95 * (p.std or 0.0)) for way in (-1.0, 1.0)]
            words = " to ".join(ends) if self.converged else f"{' to '.join(ends)} {UNSETTLED}"
            return "held" if p.fixed else "" if p.std is None else words

        return [
            {"effect": _native.common_name(p.effect), "term": p.term, "symbol": p.name, "value": p.value}
            | {"std": deviation(p.std, self.converged), "95 % interval": interval(p), "unit": p.unit}
            for p in self.parameters
        ]

    def _picture(self) -> str:
        free = sum(not p.fixed and bool(p.std) and p.value != 0.0 for p in self.parameters)
        return picture(lambda figure: self.plot(figure.add_subplot()), 6.0, 0.8 + 0.38 * free) if free else ""

    def plot(self, ax: Axes | None = None, **style: Any) -> Axes:
        """Half-width of the 95 % interval relative to the estimate: which parameters are known, and which are not.

        Args:
            ax: axes to draw into; new ones when absent.
            style: passed on to `matplotlib.axes.Axes.barh`.
        """
        free = [p for p in self.parameters if not p.fixed and p.std and p.value != 0.0]
        mark = "" if self.converged else f" {UNSETTLED}"
        shown = [(f"{_native.common_name(p.term)}, {p.name}", p.value, p.std or 0.0, p.unit + mark) for p in free]
        return known_and_unknown(ax, shown, style)
