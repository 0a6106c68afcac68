"""Exports in the tools that read them, under the same commands for a minute; one that is not installed is skipped.

How far each may be off is what docs/exports.md quotes of it.
"""

import copy
import math
import shutil
import subprocess
import sys
import xml.etree.ElementTree as xml
from collections.abc import Callable
from pathlib import Path
from typing import Any

import hydrosysid as hs
import numpy as np
import pytest
from exported_models import (
    FLOATING,
    INERTIA,
    SECONDS,
    SIZE,
    STEP,
    VELOCITIES,
    assert_quoted,
    command,
    euler_rates,
    exported,
)


@pytest.fixture(scope="module")
def by_module(tmp_path_factory: pytest.TempPathFactory) -> np.ndarray:
    """Angles and velocities by the Fossen module, in steps of Runge and Kutta."""
    fossen = exported("fossen-python", tmp_path_factory.mktemp("module"))

    def rate(t: float, x: np.ndarray) -> np.ndarray:
        # x: angles, nu; commands are held from step to step
        eta = np.concatenate([np.zeros(3), x[:3]])
        tau = command(STEP * np.floor(t / STEP + 1e-6))
        return np.concatenate([euler_rates(x[0], x[1]) @ x[6:9], fossen.nu_dot(eta, x[3:], tau)])

    x = np.zeros(9)
    path = []
    for k in range(round(SECONDS / STEP)):
        path.append(x)
        # the stages of a step see the command of its begin
        t = k * STEP
        a = rate(t, x)
        b = rate(t, x + 0.5 * STEP * a)
        c = rate(t, x + 0.5 * STEP * b)
        x = x + STEP / 6.0 * (a + 2.0 * b + 2.0 * c + rate(t, x + STEP * c))
    return np.array(path)


@pytest.fixture(scope="module")
def truth(by_module: np.ndarray) -> np.ndarray:
    """Velocities by the library's own simulation of the model file, commands held from step to step.

    It finds the state to begin with from what is logged, here what the module did; then it sees the commands alone.
    """
    names = ["phi", "theta", "psi", *VELOCITIES]
    t = STEP * np.arange(len(by_module))
    forces = np.array([command(time) for time in t])
    channels = dict(zip(names, by_module.T, strict=True))
    channels |= {f"tau_{velocity}": column for velocity, column in zip(VELOCITIES, forces.T, strict=True)}
    held = hs.Model(FLOATING.read_text().replace('input = "linear"', 'input = "hold"'))
    campaign = hs.Campaign(
        vehicle={"name": "floating", "mass": 200.0},
        dofs=["surge", "sway", "heave", "roll", "pitch", "yaw"],
        effects=["inertia"],
        runs=[hs.Run(t=t, name="minute", kind="free", role="validate", **channels)],
    )
    run = hs.simulate(campaign, held)["minute"]
    np.testing.assert_array_equal(run.time, t)
    path = np.array([run.simulated[velocity] for velocity in VELOCITIES]).T
    # it begins at rest as the module does
    np.testing.assert_allclose(path[0], 0.0, atol=1e-6)
    return path


def test_fossens_module_moves_as_the_library(by_module: np.ndarray, truth: np.ndarray) -> None:
    # the same equations and the same steps, coefficients written with eleven digits
    assert np.abs(truth).max() > 0.5
    assert_quoted("fossen-python", by_module[:, 3:], truth)


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
        mujoco.set_mjcb_act_bias(None)
    # the same scheme; the attitude by quaternions here, by angles there
    assert_quoted("mujoco", np.array(path), truth)


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
        mujoco.set_mjcb_act_bias(None)


def test_mujoco_leaves_other_models_as_they_are(lossy: hs.Model, tmp_path: Path) -> None:
    mujoco = pytest.importorskip("mujoco")
    ball = '<mujoco><worldbody><body><freejoint/><geom size="0.1"/></body></worldbody></mujoco>'

    def fallen() -> float:
        model = mujoco.MjModel.from_xml_string(ball)
        data = mujoco.MjData(model)
        mujoco.mj_step(model, data)
        return float(data.qvel[2])

    def pushed(vehicle: Any, model: Any) -> np.ndarray:
        data = mujoco.MjData(model)
        for _ in range(20):
            data.ctrl[:] = command(0.0)
            mujoco.mj_step(model, data)
        return np.array(vehicle.velocity(data))

    alone = fallen()
    first, second = exported("mujoco", tmp_path), exported("mujoco", tmp_path, lossy)
    try:
        model, _ = first.load()
        before = pushed(first, model)
        assert fallen() == alone
        # another vehicle, with coefficients of its own
        other, _ = second.load()
        differs = pushed(second, other)
        assert np.abs(differs - before).max() > 1e-6
        np.testing.assert_array_equal(pushed(first, model), before)
        np.testing.assert_array_equal(pushed(second, second.load()[0]), differs)
        assert fallen() == alone
        # a copy would stand still in a vacuum: it is refused until it is told of
        twin = copy.copy(model)
        with pytest.raises(RuntimeError, match=r"make it by load\(\), or put a copy in LOADED"):
            pushed(first, twin)
        first.LOADED.add(twin)
        np.testing.assert_array_equal(pushed(first, twin), before)
    finally:
        mujoco.set_mjcb_act_bias(None)


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
    assert_quoted("`python-vehicle-simulator`", np.array(path), truth)


def test_holoocean_moves_as_the_model_in_its_interface(truth: np.ndarray, tmp_path: Path) -> None:
    made = exported("python-vehicle-simulator", tmp_path)
    vehicle = made.IdentifiedHoloOcean("manualControl")
    assert vehicle.config_fnc is None
    centre = np.array([0.05, 0.0, 0.03])
    turn = np.diag([1.0, -1.0, -1.0])
    ticks, path = 4, []
    h = STEP / ticks
    # world NWU: the centre of mass, as `DynamicsSensor` with `UseCOM` tells it
    attitude, v, omega = np.eye(3), np.zeros(3), np.zeros(3)
    for k in range(len(truth)):
        body = turn @ attitude.T
        path.append(np.concatenate([body @ v - np.cross(body @ omega, centre), body @ omega]))
        for _ in range(ticks):
            # `convert_NWU_to_NED` of fossen_dynamics (HoloOcean 2)
            body = turn @ attitude.T
            ned = turn @ attitude @ turn
            angles = [np.arctan2(ned[2, 1], ned[2, 2]), -np.arcsin(ned[2, 0]), np.arctan2(ned[1, 0], ned[0, 0])]
            eta = np.array([0.0, 0.0, 5.0, *angles])
            nu = np.concatenate([body @ v, body @ omega])
            rate, actual = vehicle.dynamics(eta, nu, np.zeros(6), command(k * STEP), h)
            np.testing.assert_array_equal(actual, command(k * STEP))
            # `convert_NED_to_NWU`, and a tick of the engine, velocities first
            v = v + h * (attitude @ turn @ rate[:3])
            omega = omega + h * (attitude @ turn @ rate[3:])
            attitude = turned(h * omega) @ attitude
    # steps of the first order, 200 a second
    assert_quoted("HoloOcean", np.array(path), truth)


def turned(angle: np.ndarray) -> np.ndarray:
    """The matrix of a turn by Rodrigues' formula."""
    size = float(np.linalg.norm(angle))
    if size == 0.0:
        return np.eye(3)
    x, y, z = angle / size
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + math.sin(size) * cross + (1.0 - math.cos(size)) * (cross @ cross)


LOSSES = (
    "eta_inter = { surge = 0.9, pitch = 0.85, yaw = 0.8 }\neta_adv = { slope = -0.4, intercept = 0.98, valid = [0, 1] }"
)
ETA_INTER = np.array([0.9, 1.0, 1.0, 1.0, 0.85, 0.8])


def states(count: int = 20) -> list[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]]:
    """Attitudes, velocities, nominal forces, and those that act by the paper's rule, a moment by the speed ahead."""
    rng = np.random.default_rng(7)
    found = []
    for _ in range(count):
        eta = np.concatenate([np.zeros(3), rng.uniform(-0.6, 0.6, 3)])
        nu, nominal = rng.uniform(-1.0, 1.0, 6), SIZE * rng.standard_normal(6)
        speed = np.abs(nu)[[0, 1, 2, 0, 0, 0]]
        found.append((eta, nu, nominal, ETA_INTER * (0.98 - 0.4 * speed) * nominal))
    return found


@pytest.fixture
def lossy() -> hs.Model:
    text = FLOATING.read_text()
    assert "eta_inter = []\n" in text
    return hs.Model(text.replace("eta_inter = []\n", LOSSES + "\n"))


@pytest.mark.parametrize("target", ["fossen-python", "python-vehicle-simulator", "mujoco"])
def test_nominal_forces_lose_in_the_module_what_they_lose_in_the_water(
    target: str, lossy: hs.Model, tmp_path: Path
) -> None:
    with_losses, without = exported(target, tmp_path, lossy), exported("fossen-python", tmp_path)
    for eta, nu, nominal, acting in states():
        # twelve products and sums in another order
        expected = without.nu_dot(eta, nu, acting)
        np.testing.assert_allclose(with_losses.nu_dot(eta, nu, nominal), expected, rtol=1e-10, atol=1e-12)
        assert np.abs(with_losses.nu_dot(eta, nu, acting) - expected).max() > 1e-3


def test_the_vehicle_class_and_mujoco_step_with_the_losses(lossy: hs.Model, tmp_path: Path) -> None:
    mujoco = pytest.importorskip("mujoco")
    without = exported("fossen-python", tmp_path)
    vehicle = exported("python-vehicle-simulator", tmp_path, lossy).identified()
    for eta, nu, nominal, acting in states():
        expected = without.nu_dot(eta, nu, acting)
        after, _ = vehicle.dynamics(eta, nu, np.zeros(6), nominal, 1e-6)
        # a step of a microsecond: the slope changes by less than 1e-4 of it
        np.testing.assert_allclose((after - nu) / 1e-6, expected, rtol=1e-3, atol=1e-4)
    in_mujoco = exported("mujoco", tmp_path, lossy)
    model, data = in_mujoco.load()
    try:
        for _, nu, nominal, acting in states():
            # upright, along the axes of the world
            data.qvel[:] = in_mujoco.TURN * nu
            data.ctrl[:] = nominal
            mujoco.mj_forward(model, data)
            rate = in_mujoco.TURN * data.qacc
            # qacc is that of the origin in world axes: nu_dot + omega x v
            expected = without.nu_dot(np.zeros(6), nu, acting)
            expected[:3] += np.cross(nu[3:], nu[:3])
            np.testing.assert_allclose(rate, expected, rtol=1e-9, atol=1e-9)
    finally:
        mujoco.set_mjcb_act_bias(None)


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
    assert_quoted("fossen-matlab", np.loadtxt(tmp_path / "path.txt"), truth)


def test_the_vehicle_class_needs_nothing_but_numpy(tmp_path: Path) -> None:
    text = hs.export(FLOATING, "python-vehicle-simulator", inertia=INERTIA).text
    (tmp_path / "vehicle.py").write_text(text)
    code = (
        "import sys, vehicle; v = vehicle.identified(); print(v.name, sorted(set(sys.modules) & {'mujoco', 'scipy'}))"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "floating []"
