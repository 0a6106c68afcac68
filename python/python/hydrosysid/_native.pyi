"""The compiled part; kept true by `mypy.stubtest`."""

from collections.abc import Callable, Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Any, Final, final

import numpy as np
from numpy.typing import NDArray

_Array = NDArray[np.float64]
_Path = str | PathLike[str]
_Progress = Callable[[str, int, int], object] | None
_Residuals = tuple[str, str, _Array, _Array, _Array]
_Arrays = dict[str, _Array]
_Trajectories = tuple[_Array, _Arrays, _Arrays, _Arrays]
_Series = tuple[_Array, _Array, _Arrays, _Array]
_Run = tuple[str, str, str, list[float], Mapping[str, str], Mapping[str, tuple[_Array, _Array]]]

__all__ = [
    "NativeCampaign",
    "__version__",
    "adopt",
    "block_bootstrap",
    "check_campaign",
    "check_logs",
    "codes_explained",
    "command",
    "common_name",
    "csv_of",
    "effects",
    "euler",
    "export_model",
    "fit_streamed",
    "fit_thruster",
    "init_campaign",
    "known_vehicles",
    "least_squares",
    "model_difference",
    "plan_campaign",
    "plan_model",
    "polynomial_filter",
    "read_log",
    "regressors",
    "rk4",
    "student_quantile",
    "tank_campaign",
    "to_body",
    "to_si",
    "too_large_to_keep",
    "watched_command",
]

__version__: Final[str]

@final
class NativeCampaign:
    @staticmethod
    def load(path: _Path, allow_outside: bool, progress: _Progress) -> NativeCampaign: ...
    @staticmethod
    def from_runs(tables: str, runs: Sequence[_Run]) -> NativeCampaign: ...
    def about(self) -> str: ...
    def fit(self, estimator: str | None, thorough: bool, progress: _Progress) -> tuple[str, str, list[_Residuals]]: ...
    def estimator(self, asked: str | None) -> str: ...
    def resample(
        self,
        method: str,
        estimator: str | None,
        numbers: tuple[int, int],
        seed: int | None,
        progress: _Progress,
    ) -> tuple[str, _Array]: ...
    def cross_validate(self, estimator: str | None, progress: _Progress) -> str: ...
    def simulate(self, model: str, progress: _Progress) -> tuple[str, list[_Trajectories]]: ...
    def components(self, model: str, progress: _Progress) -> tuple[str, list[_Series]]: ...
    def compare(self, model: str, progress: _Progress) -> str: ...
    def compare_published(self, model: str, params: str, name: str, progress: _Progress) -> str: ...
    def monitor(self, model: str, window: float, level: float, progress: _Progress) -> str: ...
    def discover(self, families: Sequence[str] | None, progress: _Progress) -> str: ...
    def report(
        self,
        discovery: bool,
        params: tuple[str, str] | None,
        command: str,
        inputs: Sequence[tuple[str, str]],
        progress: _Progress,
    ) -> str: ...
    def sources(self) -> list[Path]: ...
    def resampled(self, stretches: Sequence[tuple[int, float, float]]) -> NativeCampaign: ...
    def spans(self) -> str: ...

def block_bootstrap(h: _Array, y: _Array, block: int, draws: int, seed: int, progress: _Progress) -> _Array: ...
def check_campaign(path: _Path, allow_outside: bool, progress: _Progress) -> str: ...
def check_logs(paths: Sequence[_Path], log_options: str, required: Sequence[str], progress: _Progress) -> str: ...
def codes_explained() -> str: ...
def command(arguments: Sequence[str]) -> int: ...
def common_name(name: str) -> str: ...
def csv_of(run: _Run, origin: int | None) -> bytes: ...
def effects(text: str) -> str: ...
def euler(x: _Array, y: _Array, z: _Array, w: _Array) -> tuple[_Array, _Array, _Array]: ...
def export_model(
    model: str,
    is_file: bool,
    target: str,
    link: str | None,
    mass: float | None,
    inertia: Sequence[float] | None,
    at: Mapping[str, float],
    acting: bool,
    version: str | None,
) -> tuple[str, bytes]: ...
def fit_streamed(path: _Path, progress: _Progress) -> tuple[str, str]: ...
def fit_thruster(
    command: _Array,
    force: _Array,
    deadband: float | None,
    supply: _Array | None,
    reference_supply: float | None,
) -> dict[str, Any]: ...
def init_campaign(
    logs: Sequence[tuple[str | PathLike[str], str]],
    name: str,
    figures: Sequence[float | None],
    vehicle: str | None,
    log_options: str,
    learned: str,
) -> tuple[str, list[tuple[str, str]], list[str]]: ...
def known_vehicles() -> str: ...
def least_squares(h: _Array, y: _Array, names: Sequence[str]) -> dict[str, Any]: ...
def plan_campaign(
    campaign: NativeCampaign, request: str, progress: _Progress
) -> tuple[str, list[tuple[str, str, dict[str, tuple[_Array, _Array]]]]]: ...
def plan_model(
    model: str, request: str, progress: _Progress
) -> tuple[str, list[tuple[str, str, dict[str, tuple[_Array, _Array]]]]]: ...
def adopt(
    campaign: _Path, to: _Path | None, names: Sequence[str], training: Sequence[str], input: str | None
) -> None: ...
def model_difference(a: str, b: str, names: Sequence[str]) -> str: ...
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
def student_quantile(below: float, freedom: float) -> float: ...
def tank_campaign(folder: _Path, seed: int, noise: float) -> None: ...
def to_body(
    signals: Mapping[str, tuple[_Array, _Array]], frame: str
) -> tuple[dict[str, tuple[_Array, _Array]], str]: ...
def to_si(name: str, values: _Array, log_options: str) -> tuple[str, str, _Array]: ...
def too_large_to_keep(path: _Path, estimator: str | None) -> bool: ...
def watched_command(arguments: Sequence[str], progress: _Progress) -> int: ...
