"""Experimental identification of underwater vehicles.

From logs of bollard-pull, constant-velocity, oscillatory and zig-zag runs to a trustworthy model, and to the
name of what it still lacks. The verbs of the command are functions here::

    import hydrosysid as hs

    campaign = hs.Campaign.from_file("campaign.toml")
    fit = hs.fit(campaign)
    print(fit.summary())
    hs.compare(campaign, fit).plot()

Arrays are NumPy arrays in SI units; body axes are forward, starboard, down, earth axes north, east, down. Results are
plain typed data: they pickle, and so do campaigns, so that a list of campaigns maps over any
`concurrent.futures.Executor`.
"""

from importlib import import_module

from ._native import __version__

# what type checkers set; at run time a part is imported when it is first asked for, and NumPy with it
TYPE_CHECKING = False
if TYPE_CHECKING:
    from ._campaign import Campaign
    from ._catalogue import Effect, EffectParameter, Regressors, effects, regressors
    from ._check import Check, CheckedLog
    from ._convert import convert, explain
    from ._cross import Crossed, CrossValidation, OwnEstimate, OwnModel
    from ._discovery import (
        BehavesLike,
        Change,
        ChangedParameter,
        Dependence,
        Discovery,
        FoundEffect,
        FoundParameter,
        GapForce,
        GapOfRun,
        GapStep,
        LogFinding,
        Residual,
        RunInstant,
        SmallestVisible,
        Where,
    )
    from ._errors import DataError, Finding, HydrosysidError, UsageError
    from ._fit import Fit, FittedCurve, Parameter, RunResiduals, Stage, StageEstimate
    from ._fits import Fits
    from ._forces import Forces
    from ._many import map_fit, resample
    from ._model import Model
    from ._models import (
        Export,
        Joint,
        ModelDifference,
        Monitored,
        ParameterDifference,
        PublishedComparison,
        PublishedParameter,
        Reason,
        Shift,
        Window,
    )
    from ._motion import Comparison, Disagreement, SimulatedRun, Simulation
    from ._noise import HeldBack, Noise, Prediction, RandomForce, SensorNoise
    from ._numbers import LeastSquares, least_squares, polynomial_filter, rk4
    from ._own_effect import OwnEffect
    from ._page import View, view
    from ._pages import demo, export, report, tank_campaign
    from ._planning import Plan, PlannedParameter, PlannedRun, Push
    from ._resampling import Resampling, Scatter, block_bootstrap
    from ._run import Run
    from ._scaffold import init, vehicles
    from ._thruster import Estimate, ThrustDirection, ThrusterFit, fit_thruster
    from ._verbs import (
        check,
        compare,
        compare_models,
        compare_published,
        cross_validate,
        discover,
        fit,
        force_components,
        monitor,
        plan,
        simulate,
    )

__all__ = [
    "BehavesLike",
    "Campaign",
    "Change",
    "ChangedParameter",
    "Check",
    "CheckedLog",
    "Comparison",
    "CrossValidation",
    "Crossed",
    "DataError",
    "Dependence",
    "Disagreement",
    "Discovery",
    "Effect",
    "EffectParameter",
    "Estimate",
    "Export",
    "Finding",
    "Fit",
    "Fits",
    "FittedCurve",
    "Forces",
    "FoundEffect",
    "FoundParameter",
    "GapForce",
    "GapOfRun",
    "GapStep",
    "HeldBack",
    "HydrosysidError",
    "Joint",
    "LeastSquares",
    "LogFinding",
    "Model",
    "ModelDifference",
    "Monitored",
    "Noise",
    "OwnEffect",
    "OwnEstimate",
    "OwnModel",
    "Parameter",
    "ParameterDifference",
    "Plan",
    "PlannedParameter",
    "PlannedRun",
    "Prediction",
    "PublishedComparison",
    "PublishedParameter",
    "Push",
    "RandomForce",
    "Reason",
    "Regressors",
    "Resampling",
    "Residual",
    "Run",
    "RunInstant",
    "RunResiduals",
    "Scatter",
    "SensorNoise",
    "Shift",
    "SimulatedRun",
    "Simulation",
    "SmallestVisible",
    "Stage",
    "StageEstimate",
    "ThrustDirection",
    "ThrusterFit",
    "UsageError",
    "View",
    "Where",
    "Window",
    "__version__",
    "block_bootstrap",
    "check",
    "compare",
    "compare_models",
    "compare_published",
    "convert",
    "cross_validate",
    "demo",
    "discover",
    "effects",
    "explain",
    "export",
    "fit",
    "fit_thruster",
    "force_components",
    "init",
    "least_squares",
    "map_fit",
    "monitor",
    "plan",
    "polynomial_filter",
    "regressors",
    "report",
    "resample",
    "rk4",
    "simulate",
    "tank_campaign",
    "vehicles",
    "view",
]

# where each public name is at home
_HOMES = {
    "_campaign": "Campaign",
    "_catalogue": "Effect EffectParameter Regressors effects regressors",
    "_check": "Check CheckedLog",
    "_convert": "convert explain",
    "_cross": "Crossed CrossValidation OwnEstimate OwnModel",
    "_discovery": (
        "BehavesLike Change ChangedParameter Dependence Discovery FoundEffect FoundParameter GapForce GapOfRun GapStep "
        "LogFinding Residual RunInstant SmallestVisible Where"
    ),
    "_errors": "DataError Finding HydrosysidError UsageError",
    "_fit": "Fit FittedCurve Parameter RunResiduals Stage StageEstimate",
    "_fits": "Fits",
    "_forces": "Forces",
    "_many": "map_fit resample",
    "_model": "Model",
    "_models": (
        "Export Joint ModelDifference Monitored ParameterDifference PublishedComparison "
        "PublishedParameter Reason Shift Window"
    ),
    "_motion": "Comparison Disagreement SimulatedRun Simulation",
    "_noise": "HeldBack Noise Prediction RandomForce SensorNoise",
    "_numbers": "LeastSquares least_squares polynomial_filter rk4",
    "_own_effect": "OwnEffect",
    "_page": "View view",
    "_pages": "demo export report tank_campaign",
    "_planning": "Plan PlannedParameter PlannedRun Push",
    "_resampling": "Resampling Scatter block_bootstrap",
    "_run": "Run",
    "_scaffold": "init vehicles",
    "_thruster": "Estimate ThrustDirection ThrusterFit fit_thruster",
    "_verbs": (
        "check compare compare_models compare_published cross_validate discover fit force_components "
        "monitor plan simulate"
    ),
}
_HOME_OF = {name: part for part, names in _HOMES.items() for name in names.split()}


def __getattr__(name: str) -> object:
    if name not in _HOME_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value: object = getattr(import_module("." + _HOME_OF[name], __name__), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
