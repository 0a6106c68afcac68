"""The compiled part; kept true by `mypy.stubtest`."""

from collections.abc import Callable, Mapping, Sequence
from os import PathLike
from typing import Any, Final, final

import numpy as np
from numpy.typing import NDArray

_Array = NDArray[np.float64]
_Path = str | PathLike[str]
_Run = tuple[str, str, str, list[float], Mapping[str, tuple[_Array, _Array]]]

__all__ = [
    "NativeCampaign",
    "__version__",
    "check_campaign",
    "check_logs",
    "command",
    "effects",
    "fit_thruster",
    "least_squares",
    "plan_campaign",
    "plan_model",
    "polynomial_filter",
    "read_log",
    "regressors",
    "rk4",
    "tank_campaign",
]

__version__: Final[str]

@final
class NativeCampaign:
    @staticmethod
    def load(path: _Path, allow_outside: bool) -> NativeCampaign: ...
    @staticmethod
    def from_runs(tables: str, runs: Sequence[_Run]) -> NativeCampaign: ...
    def about(self) -> str: ...
    def fit(self, estimator: str | None) -> tuple[str, str]: ...
    def simulate(self, model: str) -> str: ...
    def compare(self, model: str) -> str: ...
    def discover(self, families: Sequence[str] | None) -> str: ...

def check_campaign(path: _Path, allow_outside: bool) -> str: ...
def check_logs(paths: Sequence[_Path], log_options: str, required: Sequence[str]) -> str: ...
def command(arguments: Sequence[str]) -> int: ...
def effects() -> str: ...
def fit_thruster(
    command: _Array,
    force: _Array,
    deadband: float | None,
    supply: _Array | None,
    reference_supply: float | None,
) -> dict[str, Any]: ...
def least_squares(h: _Array, y: _Array, names: Sequence[str]) -> dict[str, Any]: ...
def plan_campaign(
    campaign: NativeCampaign, request: str
) -> tuple[str, list[tuple[str, str, dict[str, tuple[_Array, _Array]]]]]: ...
def plan_model(model: str, request: str) -> tuple[str, list[tuple[str, str, dict[str, tuple[_Array, _Array]]]]]: ...
def polynomial_filter(
    t: _Array, x: _Array, samples: int | None, seconds: float | None, degree: int, gaps: Sequence[float]
) -> tuple[_Array, _Array]: ...
def read_log(
    path: _Path, log_options: str, required: Sequence[str]
) -> tuple[dict[str, tuple[_Array, _Array]], dict[str, str], list[float], str]: ...
def regressors(
    runs: Sequence[_Run],
    dof: str,
    dofs: Sequence[str],
    effects: Sequence[str],
    fixed: Sequence[tuple[str, float]],
    coriolis: str,
    samples: int | None,
    every_stamp: bool,
) -> tuple[list[str], _Array, _Array, _Array]: ...
def rk4(f: Callable[[float, _Array], _Array], t: _Array, y0: _Array, substeps: int) -> _Array: ...
def tank_campaign(folder: _Path, seed: int, noise: float) -> None: ...
