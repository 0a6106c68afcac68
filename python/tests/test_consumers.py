"""Exports in the tools that read them, under the same commands for a minute; one that is not installed is skipped."""

import importlib.util
import shutil
import subprocess
import sys
import xml.etree.ElementTree as xml
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import hydrosysid as hs
import numpy as np
import pytest

FLOATING = Path(__file__).parent / "floating.toml"
INERTIA = (20.0, 25.0, 28.0)
STEP, SECONDS = 0.02, 60.0
SIZE = np.array([90.0, 80.0, 70.0, 9.0, 10.0, 12.0])


def command(t: float) -> np.ndarray:
    """Forces and moments, held for a step: each with a period of its own."""
    i = np.arange(6)
    return SIZE * np.sin((0.5 + 0.13 * i) * t + i) + 0.2 * SIZE


def module(text: str, folder: Path, name: str) -> Any:
    path = folder / f"{name}.py"
    path.write_text(text)
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None
    assert spec.loader is not None
    made: ModuleType = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(made)
    return made


def exported(target: str, folder: Path) -> Any:
    made = hs.export(FLOATING, target, inertia=INERTIA)
    assert made.lost == ()
    return module(made.text, folder, target.replace("-", "_"))


def euler_rates(phi: float, theta: float) -> np.ndarray:
    s, c, t = np.sin(phi), np.cos(phi), np.tan(theta)
    return np.array([[1.0, s * t, c * t], [0.0, c, -s], [0.0, s / np.cos(theta), c / np.cos(theta)]])


@pytest.fixture(scope="module")
def truth(tmp_path_factory: pytest.TempPathFactory) -> np.ndarray:
    """Velocities of the model, by its Fossen module, which the Rust tests hold to the library's own simulation."""
    fossen = exported("fossen-python", tmp_path_factory.mktemp("truth"))

    def rate(t: float, x: np.ndarray) -> np.ndarray:
        # x: angles, nu; commands are held from step to step
        eta = np.concatenate([np.zeros(3), x[:3]])
        tau = command(STEP * np.floor(t / STEP + 1e-6))
        return np.concatenate([euler_rates(x[0], x[1]) @ x[6:9], fossen.nu_dot(eta, x[3:], tau)])

    x = np.zeros(9)
    path = []
    for k in range(round(SECONDS / STEP)):
        path.append(x[3:])
        # the stages of a step see the command of its begin
        t = k * STEP
        a = rate(t, x)
        b = rate(t, x + 0.5 * STEP * a)
        c = rate(t, x + 0.5 * STEP * b)
        x = x + STEP / 6.0 * (a + 2.0 * b + 2.0 * c + rate(t, x + STEP * c))
    return np.array(path)


def differences(path: np.ndarray, truth: np.ndarray) -> np.ndarray:
    """Root mean square difference of each velocity over that of the velocity."""
    return np.sqrt(np.mean((path - truth) ** 2, axis=0) / np.mean(truth**2, axis=0))


def test_mujoco_moves_as_the_model(truth: np.ndarray, tmp_path: Path) -> None:
    mujoco = pytest.importorskip("mujoco")
    vehicle = exported("mujoco", tmp_path)
    model, data = vehicle.load()
    try:
        model.opt.timestep = STEP
        path = []
        for k in range(len(truth)):
            path.append(vehicle.velocity(data))
            data.ctrl[:] = command(k * STEP)
            mujoco.mj_step(model, data)
    finally:
        mujoco.set_mjcb_passive(None)
    # the same scheme; the attitude by quaternions here, by angles there
    worst = differences(np.array(path), truth)
    assert worst.max() < 1e-4, worst


def test_a_force_from_outside_moves_mujoco_as_a_command(tmp_path: Path) -> None:
    mujoco = pytest.importorskip("mujoco")
    vehicle = exported("mujoco", tmp_path)

    def moved(push: Callable[[Any, np.ndarray], None]) -> np.ndarray:
        model, data = vehicle.load()
        for _ in range(500):
            push(data, vehicle.TURN * [30.0, 20.0, -10.0, 2.0, 3.0, 4.0])
            mujoco.mj_step(model, data)
        return np.array(vehicle.velocity(data))

    def outside(data: Any, wrench: np.ndarray) -> None:
        # about the centre of mass, in world axes
        rotation = data.xmat[1].reshape(3, 3)
        place = np.array([0.05, 0.0, -0.03])
        data.xfrc_applied[1, :3] = rotation @ wrench[:3]
        data.xfrc_applied[1, 3:] = rotation @ (wrench[3:] - np.cross(place, wrench[:3]))

    def inside(data: Any, wrench: np.ndarray) -> None:
        data.ctrl[:] = vehicle.TURN * wrench

    try:
        # one is turned at the begin of a step, the other in its stages
        np.testing.assert_allclose(moved(outside), moved(inside), rtol=0.0, atol=2e-3)
    finally:
        mujoco.set_mjcb_passive(None)


def attitude_euler(eta: np.ndarray, nu: np.ndarray, h: float) -> np.ndarray:
    """The attitude a sample later, as PythonVehicleSimulator 2025 has it in `lib/gnc.py`, `attitudeEuler`."""
    angles = eta[3:] + h * euler_rates(eta[3], eta[4]) @ nu[3:]
    return np.concatenate([eta[:3], angles])


def test_the_vehicle_class_moves_as_the_model_in_the_simulators_loop(truth: np.ndarray, tmp_path: Path) -> None:
    vehicle = exported("python-vehicle-simulator", tmp_path).identified()
    assert (vehicle.dimU, len(vehicle.controls), vehicle.controlMode) == (6, 6, "stepInput")
    assert vehicle.stepInput(0.0).shape == (6,)
    eta, nu, u_actual = np.zeros(6), vehicle.nu, vehicle.u_actual
    path = []
    # `simulate` of lib/mainLoop.py (2025): dynamics, then the attitude by the new velocities
    for k in range(len(truth)):
        vehicle.tau = command(k * STEP)
        path.append(nu)
        for _ in range(2):
            nu, u_actual = vehicle.dynamics(eta, nu, u_actual, vehicle.stepInput(k * STEP), 0.5 * STEP)
            eta = attitude_euler(eta, nu, 0.5 * STEP)
    # the attitude of the simulator is of first order: a sample of 10 ms
    worst = differences(np.array(path), truth)
    assert worst.max() < 0.01, worst


def test_holoocean_gets_accelerations(tmp_path: Path) -> None:
    made = exported("python-vehicle-simulator", tmp_path)
    vehicle = made.IdentifiedHoloOcean("manualControl")
    eta, nu, tau = np.array([0, 0, 5, 0.1, -0.2, 1.0]), np.full(6, 0.2), command(3.0)
    rate, actual = vehicle.dynamics(eta, nu, np.zeros(6), tau, 1 / 30)
    np.testing.assert_array_equal(rate, made.nu_dot(eta, nu, tau))
    np.testing.assert_array_equal(actual, tau)
    assert vehicle.config_fnc is None


def test_a_steady_current_carries_the_vehicle_along(tmp_path: Path) -> None:
    made = exported("python-vehicle-simulator", tmp_path)
    vehicle = made.identified(V_current=0.4, beta_current=0.7)
    eta, nu = np.zeros(6), np.zeros(6)
    neutral = made.NET_WEIGHT
    assert neutral[0] != 0.0, "it drifts up as well"
    for _ in range(6000):
        nu, _ = vehicle.dynamics(eta, nu, nu, np.zeros(6), 0.02)
    np.testing.assert_allclose(nu[:2], [0.4 * np.cos(0.7), 0.4 * np.sin(0.7)], atol=0.02)


def test_urdf_is_read_with_its_rigid_body(tmp_path: Path) -> None:
    yourdfpy = pytest.importorskip("yourdfpy")
    path = tmp_path / "vehicle.urdf"
    text = hs.export(FLOATING, "urdf", path, inertia=INERTIA).text
    inertial = yourdfpy.URDF.load(str(path)).link_map["base_link"].inertial
    assert inertial.mass == 200.0
    np.testing.assert_allclose(inertial.origin[:3, 3], [0.05, 0.0, -0.03])
    assert xml.fromstring(text.encode()).find("hydrodynamics/hydrostatics/buoyancy") is not None
    # I_b − m (r·r 1 − r rᵀ)
    r = np.array([0.05, 0.0, -0.03])
    central = np.diag(INERTIA) - 200.0 * (r @ r * np.eye(3) - np.outer(r, r))
    np.testing.assert_allclose(inertial.inertia, central, atol=1e-9)


def test_pinocchio_has_the_mass_matrix_of_the_rigid_body(tmp_path: Path) -> None:
    pinocchio = pytest.importorskip("pinocchio")
    text = hs.export(FLOATING, "urdf", inertia=INERTIA).text
    model = pinocchio.buildModelFromXML(text, pinocchio.JointModelFreeFlyer())
    mass = pinocchio.crba(model, model.createData(), pinocchio.neutral(model))
    fossen = exported("fossen-python", tmp_path)
    turn = np.diag([1.0, -1.0, -1.0, 1.0, -1.0, -1.0])
    whole = np.triu(mass) + np.triu(mass, 1).T
    np.testing.assert_allclose(whole, turn @ fossen.M_RB @ turn, atol=1e-9)


def test_control_steps_the_linear_model_as_the_model_near_its_point(tmp_path: Path) -> None:
    control = pytest.importorskip("control")
    # at rest, where the motion is stable; ahead the Munk moment turns it
    linear = module(hs.export(FLOATING, "linear-python").text, tmp_path, "linear")
    names = list(linear.STATES)
    rows = [names.index(name) for name in ("phi", "theta", "u", "v", "w", "p", "q", "r")]
    fossen = exported("fossen-python", tmp_path)
    t = np.arange(0.0, SECONDS, 5.0 * STEP)
    push = np.array([0.01 * SIZE * np.sin((0.5 + 0.13 * np.arange(6)) * s) for s in t])
    states = np.asarray(control.forced_response(linear.system(), t, push.T).states)

    def rate(time: float, x: np.ndarray) -> np.ndarray:
        eta = np.array([0.0, 0.0, 0.0, x[0], x[1], 0.0])
        tau = linear.TAU0 + np.array([np.interp(time, t, column) for column in push.T])
        return np.concatenate([(euler_rates(x[0], x[1]) @ x[5:8])[:2], fossen.nu_dot(eta, x[2:], tau)])

    x0 = np.array(linear.X0)[rows]
    path = hs.rk4(rate, t, x0)
    # speeds below 0.03 m/s: quadratic drag is a few percent of the linear one
    worst = differences(states[rows].T, np.asarray(path) - x0)
    assert worst.max() < 0.05, worst


def test_octave_steps_the_function(truth: np.ndarray, tmp_path: Path) -> None:
    octave = shutil.which("octave-cli") or shutil.which("octave")
    if octave is None:
        pytest.skip("GNU Octave is not installed: the MATLAB function was not run")
    (tmp_path / "hydrosysid_vehicle.m").write_text(hs.export(FLOATING, "fossen-matlab", inertia=INERTIA).text)
    np.savetxt(tmp_path / "tau.txt", [command(k * STEP) for k in range(len(truth))])
    script = f"""
vehicle = hydrosysid_vehicle(); tau = load('tau.txt'); h = {STEP}; x = zeros(9, 1); path = zeros(rows(tau), 6);
for k = 1:rows(tau)
  path(k, :) = x(4:9)'; f = @(x) rate(vehicle, x, tau(k, :)');
  a = f(x); b = f(x + h / 2 * a); c = f(x + h / 2 * b); x += h / 6 * (a + 2 * b + 2 * c + f(x + h * c));
end
save -ascii path.txt path
"""
    rate = """
function dx = rate(vehicle, x, tau)
s = sin(x(1)); c = cos(x(1)); t = tan(x(2));
dx = [[1, s * t, c * t; 0, c, -s; 0, s / cos(x(2)), c / cos(x(2))] * x(7:9);
  vehicle.nu_dot([0; 0; 0; x(1:3)], x(4:9), tau)];
end
"""
    (tmp_path / "rate.m").write_text(rate)
    (tmp_path / "steps.m").write_text(script)
    subprocess.run([octave, "--no-gui", "--norc", "--quiet", "steps.m"], cwd=tmp_path, check=True, timeout=300)
    worst = differences(np.loadtxt(tmp_path / "path.txt"), truth)
    assert worst.max() < 1e-6, worst


def test_the_vehicle_class_needs_nothing_but_numpy(tmp_path: Path) -> None:
    text = hs.export(FLOATING, "python-vehicle-simulator", inertia=INERTIA).text
    (tmp_path / "vehicle.py").write_text(text)
    code = (
        "import sys, vehicle; v = vehicle.identified(); print(v.name, sorted(set(sys.modules) & {'mujoco', 'scipy'}))"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "floating []"
