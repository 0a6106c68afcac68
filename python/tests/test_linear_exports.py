"""Linear models and models of filters in python-control, and their other files against these."""

import json
import tomllib
from pathlib import Path

import hydrosysid as hs
import numpy as np
import pytest
from exported_models import (
    FLOATING,
    SECONDS,
    SIZE,
    STEP,
    VELOCITIES,
    assert_quoted,
    euler_rates,
    exported,
    module,
)


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
    assert_quoted("linear-python", states[rows].T, np.asarray(path) - x0)


FORCES = {"surge": 5.0, "sway": 4.0, "yaw": 0.7}
SENSORS = {"u": 0.01, "v": 0.01, "w": 0.02, "p": 0.005, "q": 0.005, "theta": 0.01, "r": 0.005}


def noise() -> str:
    """The `[noise]` of a model file; that of r is coloured."""
    text = "[noise]\ninnovations_white = true\n"
    for dof, rms in FORCES.items():
        text += f'[[noise.force]]\ndof = "{dof}"\nrms = {rms}\nstd = 0.1\n'
        text += "correlation_time = 0.8\ncorrelation_time_std = 0.1\n"
    for channel, std in SENSORS.items():
        text += f'[[noise.sensor]]\nchannel = "{channel}"\nstd = {std}\nrestlessness = 1.0\n'
    return text + "coloured_std = 0.01\ncorrelation_time = 3.0\n"


@pytest.fixture(scope="module")
def noisy() -> hs.Model:
    """The floating vehicle with a random force and the noise of its sensors; the heading is not logged."""
    text = FLOATING.read_text()
    at = text.index("[[parameter]]")
    return hs.Model(text[:at] + noise() + "\n" + text[at:])


def test_control_steps_the_filters_model_as_the_model_near_its_point(noisy: hs.Model, tmp_path: Path) -> None:
    control = pytest.importorskip("control")
    made = hs.export(noisy, "kalman-python")
    found = module(made.text, tmp_path, "kalman")
    assert "Stability: eigenvalues of A (1/s) " in made.text
    assert "Limits: small motions" in made.text
    # A_d and B_d as python-control makes them of the continuous model, forces and noises held over a step
    sampled = control.c2d(found.system(), found.DT, method="zoh")
    inputs = len(found.INPUTS)
    np.testing.assert_allclose(sampled.A, found.A_D, rtol=1e-8, atol=1e-12)
    np.testing.assert_allclose(sampled.B[:, :inputs], found.B_D, rtol=1e-8, atol=1e-12)
    # Q_d as the integral of its definition by Simpson's rule of 200 steps
    fine = np.linspace(0.0, found.DT, 201)
    g, q = np.array(found.G), np.array(found.Q)
    each = []
    for s in fine:
        moved = control.c2d(found.system(), s, method="zoh").A @ g if s > 0.0 else g
        each.append(moved @ q @ moved.T)
    weights = np.ones(201)
    weights[1:-1:2], weights[2:-1:2] = 4.0, 2.0
    integral = np.tensordot(weights, np.array(each), axes=1) * found.DT / 600.0
    np.testing.assert_allclose(found.Q_D, integral, rtol=1e-8, atol=1e-14)
    # a minute of small commands against the model itself
    fossen = exported("fossen-python", tmp_path)
    t = np.arange(0.0, SECONDS, found.DT)
    push = np.array([0.01 * SIZE * np.sin((0.5 + 0.13 * np.arange(6)) * s) for s in t])
    by_control = np.asarray(
        control.forced_response(sampled, t, np.hstack([push, np.zeros((len(t), len(found.NOISES)))]).T).states
    )
    x, by_hand = np.zeros(len(found.STATES)), []
    for tau in push:
        by_hand.append(x)
        x = np.array(found.A_D) @ x + np.array(found.B_D) @ tau
    np.testing.assert_allclose(np.array(by_hand).T, by_control, rtol=1e-6, atol=1e-10)

    def rate(state: np.ndarray, tau: np.ndarray) -> np.ndarray:
        eta = np.array([0.0, 0.0, 0.0, state[0], state[1], 0.0])
        return np.concatenate([(euler_rates(state[0], state[1]) @ state[5:])[:2], fossen.nu_dot(eta, state[2:], tau)])

    rows = [found.STATES.index(name) for name in ("phi", "theta", *VELOCITIES)]
    start = np.array(found.X0)[rows]
    state, path = start, []
    for tau in push + np.array(found.TAU0):
        path.append(state)
        for _ in range(5):
            h = found.DT / 5.0
            a = rate(state, tau)
            b = rate(state + 0.5 * h * a, tau)
            c = rate(state + 0.5 * h * b, tau)
            state = state + h / 6.0 * (a + 2.0 * b + 2.0 * c + rate(state + h * c, tau))
    assert_quoted("kalman-python", np.array(by_hand)[:, rows], np.array(path) - start)


def test_the_stationary_gain_is_that_of_a_filter_that_has_run_long(noisy: hs.Model, tmp_path: Path) -> None:
    pytest.importorskip("control")
    made = hs.export(noisy, "kalman-python")
    found = module(made.text, tmp_path, "kalman_gain")
    # nobody logs the heading, which a note tells
    assert found.UNSEEN == ["psi"]
    assert any(w.code == "X021" and "psi" in w.message for w in made.warnings)
    gain = found.gain()
    assert gain.shape == (len(found.STATES), len(found.OUTPUTS))
    seen = [k for k, name in enumerate(found.STATES) if name != "psi"]
    among = np.ix_(seen, seen)
    a, c, q, r = np.array(found.A_D)[among], np.array(found.C)[:, seen], np.array(found.Q_D)[among], np.array(found.R)
    p = np.eye(len(seen))
    for _ in range(20_000):
        own = a @ p @ c.T @ np.linalg.inv(c @ p @ c.T + r)
        p = a @ p @ a.T - own @ c @ p @ a.T + q
    np.testing.assert_allclose(gain[seen], own, rtol=1e-6, atol=1e-9)
    np.testing.assert_array_equal(gain[found.STATES.index("psi")], 0.0)
    assert np.abs(np.linalg.eigvals(a - own @ c)).max() < 1.0
    assert np.abs(gain).max() > 0.01


def test_a_filter_that_nothing_keeps_awake_has_no_stationary_gain(tmp_path: Path) -> None:
    pytest.importorskip("control")
    text = FLOATING.read_text()
    at = text.index("[[parameter]]")
    quiet = "[noise]\ninnovations_white = true\n"
    for channel, std in {**SENSORS, "psi": 0.01}.items():
        quiet += f'[[noise.sensor]]\nchannel = "{channel}"\nstd = {std}\nrestlessness = 1.0\n'
    made = hs.export(hs.Model(text[:at] + quiet + "\n" + text[at:]), "kalman-python")
    found = module(made.text, tmp_path, "kalman_quiet")
    assert found.UNSEEN == []
    # a logged heading neither decays nor is pushed
    with pytest.raises(ValueError, match="give Q_D what pushes your vehicle"):
        found.gain()


def test_every_file_of_a_filter_holds_the_same(noisy: hs.Model, tmp_path: Path) -> None:
    loadmat = pytest.importorskip("scipy.io").loadmat
    told = json.loads(hs.export(noisy, "kalman").text)
    toml = tomllib.loads(hs.export(noisy, "kalman-toml").text)
    hs.export(noisy, "kalman-mat", tmp_path / "filter.mat")
    mat = loadmat(tmp_path / "filter.mat")
    found = module(hs.export(noisy, "kalman-python").text, tmp_path, "kalman_same")
    for name in ("A", "B", "G", "C", "D", "Q", "R", "A_d", "B_d", "Q_d"):
        np.testing.assert_array_equal(mat[name], told[name])
        assert toml[name] == told[name]
        np.testing.assert_allclose(getattr(found, name.upper()), told[name], rtol=1e-10)
    assert toml["states"] == told["states"] == found.STATES == [text.strip() for text in mat["states"]]
