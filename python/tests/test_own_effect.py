"""Effects of one's own: functions that are read into formulas, and those that cannot be."""

import math
import pickle

import hydrosysid as hs
import numpy as np
import pytest


def formula(function):
    return hs.OwnEffect("own", "surge", function, unit="1").formula


@pytest.mark.parametrize(
    ("function", "expected"),
    [
        (lambda u: -(u**2), "-u^2"),
        (lambda u: (-u) ** 2, "(-u)^2"),
        (lambda u, c: u * abs(u) - (u - c) * abs(u - c), "u*abs(u) - (u - c)*abs(u - c)"),
        (lambda u, v: u / (v * u), "u/(v*u)"),
        (lambda u, v: u - (v - 1), "u - (v - 1)"),
        (lambda u: 2.0 ** (u / 3), "2^(u/3)"),
        (lambda u: np.maximum(u, 0) * np.sqrt(np.square(u)), "max(u, 0)*sqrt(u^2)"),
        (lambda u, theta: u * np.sin(theta) + 0.5, "u*sin(theta) + 0.5"),
        (lambda u: (u > 0.2) * u, "(u > 0.2)*u"),
        (lambda t: np.tanh(np.arctan(t)) + np.log(np.exp(t)), "tanh(atan(t)) + ln(exp(t))"),
    ],
)
def test_functions_are_read_into_formulas(function, expected):
    assert formula(function) == expected


@pytest.mark.parametrize(
    "function",
    [
        lambda u: u if u > 0 else 0.0,
        lambda u: math.sin(u),
        lambda u: np.interp(u, [0.0, 1.0], [0.0, 2.0]),
        lambda u: sum(x for x in u),
        lambda u: np.cumsum(u),
    ],
)
def test_what_cannot_be_read_has_no_formula(function):
    assert formula(function) is None


def test_arguments_have_names():
    with pytest.raises(hs.UsageError, match="name each argument"):
        hs.OwnEffect("own", "surge", lambda *channels: channels[0], unit="1")


def simulated(seed, k, role):
    """Surge under a sail whose force is ``k`` times a function of the logged wind."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 60.0, 0.1)
    wind = 5.0 + 2.0 * np.sin(0.2 * t + seed)
    tau = 40.0 * np.sin(0.5 * t + seed)
    force = k * np.where(wind > 5.0, wind - 5.0, 0.0)
    u = np.zeros_like(t)
    for i in range(len(t) - 1):
        x = u[i]
        for j in range(10):
            push = np.interp(t[i] + 0.01 * j, t, tau + force)
            x += 0.01 * (push - 80.0 * x * abs(x)) / 100.0
        u[i + 1] = x
    noisy = u + 0.004 * rng.standard_normal(len(t))
    return hs.Run(t=t, u=noisy, tau_u=tau, wind_over_deck=wind, name=f"run{seed}", role=role)


def campaign(function, k=6.0):
    roles = ["train"] * 4 + ["validate"]
    return hs.Campaign(
        dofs=["surge"],
        effects=["inertia", "quadratic_drag"],
        runs=[simulated(seed, k, role) for seed, role in enumerate(roles)],
        own_effects=[hs.OwnEffect("sail", "surge", function, unit="kg/s")],
    )


def test_a_function_is_discovered():
    found = hs.discover(campaign(lambda wind_over_deck: np.maximum(wind_over_deck - 5.0, 0.0)))
    assert [effect.id for effect in found.effects] == ["sail@surge"]
    parameter = found.effects[0].parameters[0]
    # the tank of this test integrates by Euler, which is good to a percent
    assert abs(parameter.value - 6.0) < 4.0 * parameter.std + 0.1


def test_what_is_no_formula_is_evaluated_on_the_log():
    def sail(wind_over_deck):
        return np.interp(wind_over_deck, [5.0, 10.0], [0.0, 5.0])

    with pytest.warns(UserWarning, match="evaluated on the logged wind_over_deck"):
        made = campaign(sail)
    assert [effect.id for effect in hs.discover(made).effects] == ["sail@surge"]
    assert pickle.loads(pickle.dumps(made)).effects == made.effects


def read(function, held=False, **channels):
    """What a function says on a run of these channels, (time stamps, values) each."""
    effect = hs.OwnEffect("own", "surge", function, unit="1")
    return effect.evaluated_on(hs.Run(channels), held=held)[1]


@pytest.mark.parametrize("begin", [-np.pi, 0.0])
@pytest.mark.parametrize("name", ["phi", "psi"])
def test_angles_are_read_the_short_way_around(name, begin):
    turning = np.linspace(-2.0, 12.0, 15)
    logged = begin + (turning - begin) % (2.0 * np.pi)
    stamps, between = np.arange(15.0), np.linspace(0.0, 14.0, 57)
    function = {"phi": lambda wind, phi: np.array(list(phi)), "psi": lambda wind, psi: np.array(list(psi))}[name]
    found = read(function, wind=(between, np.zeros(57)), **{name: (stamps, logged)})
    expected = np.interp(between, stamps, turning)
    np.testing.assert_allclose(np.exp(1j * found), np.exp(1j * expected), atol=1e-12)
    # in the range in which it is logged
    assert begin <= found.min()
    assert found.max() <= begin + 2.0 * np.pi


def test_an_angle_that_counts_turns_goes_on_counting():
    found = read(lambda wind, psi: np.array(list(psi)), wind=([0.0, 0.5, 1.0], [0.0] * 3), psi=([0.0, 1.0], [6.0, 7.0]))
    assert found.tolist() == [6.0, 6.5, 7.0]


@pytest.mark.parametrize("name", ["tau_u", "V2", "F1"])
def test_commands_are_read_as_the_campaign_reads_them(name):
    functions = {
        "tau_u": lambda wind, tau_u: np.array(list(tau_u)),
        "V2": lambda wind, V2: np.array(list(V2)),
        "F1": lambda wind, F1: np.array(list(F1)),
    }
    channels = {"wind": ([0.0, 0.5, 1.0, 1.5], [0.0] * 4), name: ([0.0, 1.0], [2.0, 4.0])}
    assert read(functions[name], **channels).tolist() == [2.0, 3.0, 4.0, 4.0]
    assert read(functions[name], held=True, **channels).tolist() == [2.0, 2.0, 4.0, 4.0]
    # what a sensor says lies on a line whatever commands do
    other = {"wind": channels["wind"], "fog": channels[name]}
    assert read(lambda wind, fog: np.array(list(fog)), held=True, **other).tolist() == [2.0, 3.0, 4.0, 4.0]


def test_input_of_the_campaign_says_how_commands_are_read():
    seen = []

    def own(wind, tau_u):
        seen.append(np.array(list(tau_u)))
        return seen[-1]

    runs = [simulated(0, 0.0, "train").with_channels({"wind": (np.arange(0.05, 59.0, 0.1), np.zeros(590))})]
    for how in ("linear", "hold"):
        effect = hs.OwnEffect("own", "surge", own, unit="1")
        with pytest.warns(UserWarning, match="evaluated on"):
            hs.Campaign(dofs=["surge"], effects=["inertia"], runs=runs, own_effects=[effect], input=how)
    tau = runs[0]["tau_u"][1]
    np.testing.assert_allclose(seen[0], (tau[:590] + tau[1:591]) / 2.0, atol=1e-12)
    np.testing.assert_array_equal(seen[1], tau[:590])


def test_what_follows_a_simulated_state_must_be_a_formula():
    with pytest.raises(hs.UsageError, match="u is simulated"):
        campaign(lambda u: np.interp(u, [0.0, 1.0], [0.0, 2.0]))


def test_a_logged_function_of_the_states_is_observed():
    t = np.arange(0.0, 60.0, 0.1)
    runs = [simulated(seed, 0.0, "train") for seed in range(3)]
    theta = 0.4 * np.sin(0.3 * t)
    logged = [run.with_channels({"theta": (t, theta), "depth_rate": (t, -run["u"][1] * np.sin(theta))}) for run in runs]
    made = hs.Campaign(
        dofs=["surge"],
        effects=["inertia", "quadratic_drag"],
        runs=logged,
        observe=[{"channel": "depth_rate", "formula": "-u*sin(theta)"}],
    )
    measured = {entry.dof for entry in hs.compare(made).runs}
    assert measured == {"surge", "depth_rate"}


def test_families_restrict_the_search():
    made = campaign("max(wind_over_deck - 5, 0)")
    found = hs.discover(made, families=["sensor"])
    assert any(warning.code == "M205" for warning in found.warnings)
    with pytest.raises(hs.UsageError):
        hs.discover(made, families=["spirits"])
