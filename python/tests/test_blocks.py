"""Building blocks against NumPy and against what can be had by hand."""

import pickle
import tracemalloc

import hydrosysid as hs
import matplotlib as mpl
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from matplotlib.patches import Rectangle
from scipy import stats

mpl.use("Agg")


@settings(max_examples=50, deadline=None)
@given(
    H=arrays(float, (12, 3), elements=st.floats(-10, 10, width=32)),
    theta=arrays(float, 3, elements=st.floats(-100, 100)),
    noise=arrays(float, 12, elements=st.floats(-1, 1, width=32)),
)
def test_least_squares_is_that_of_numpy(H: np.ndarray, theta: np.ndarray, noise: np.ndarray) -> None:
    H = H + 20.0 * np.eye(12, 3)  # far from dependent columns
    y = H @ theta + noise + 1e-3
    if np.linalg.cond(H) > 1e3:
        return
    fit = hs.least_squares(H, y)
    expected, *_ = np.linalg.lstsq(H, y, rcond=None)
    # cond(H) < 1e3 costs three of sixteen digits, the size of θ some more
    np.testing.assert_allclose(fit.coefficients, expected, rtol=1e-9, atol=1e-9)
    e = y - H @ expected
    covariance = np.linalg.inv(H.T @ H) * (e @ e) / 9.0
    np.testing.assert_allclose(fit.covariance, covariance, rtol=1e-5, atol=1e-12)
    np.testing.assert_allclose(fit.standard_errors, np.sqrt(np.diag(covariance)), rtol=1e-5, atol=1e-12)
    assert fit.condition_number == pytest.approx(np.linalg.cond(H.T @ H), rel=1e-6)
    assert fit.rank == 3


def test_exact_line_through_five_points() -> None:
    fit = hs.least_squares(np.c_[np.ones(5), np.arange(5.0)], [1, 3, 2, 5, 4], ["offset", "slope"])
    np.testing.assert_allclose(fit.coefficients, [1.4, 0.8], rtol=1e-13)  # by hand
    assert fit.residual_std == pytest.approx(np.sqrt(1.2), rel=1e-13)
    assert fit.r_squared == pytest.approx(0.64, rel=1e-13)
    assert "slope" in fit.summary()
    assert "<table>" in fit._repr_html_()


@pytest.mark.parametrize("rows", [3, 5, 12, 10_000, 200_000])
def test_intervals_are_those_of_student(rows: int) -> None:
    H = np.c_[np.ones(rows), np.arange(rows, dtype=float)]
    fit = hs.least_squares(H, H @ [1.0, 2.0] + np.random.default_rng(rows).standard_normal(rows))
    reach = stats.t.ppf(0.975, rows - 2)
    for solved in (fit, pickle.loads(pickle.dumps(fit))):
        for row, value, std in zip(solved.rows(), fit.coefficients, fit.standard_errors, strict=True):
            assert row["[0.025"] == pytest.approx(value - reach * std, rel=1e-9)
            assert row["0.975]"] == pytest.approx(value + reach * std, rel=1e-9)
    drawn = [patch.get_width() for patch in fit.plot().patches if isinstance(patch, Rectangle)]
    expected = 100.0 * reach * fit.standard_errors / np.abs(fit.coefficients)
    np.testing.assert_allclose(sorted(drawn), sorted(expected), rtol=1e-9)


@pytest.mark.parametrize(
    ("H", "y", "error", "words"),
    [
        ([[1.0, 2.0], [2.0, 4.0], [3.0, 6.0]], [1.0, 2.0, 4.0], hs.DataError, "k_v"),
        ([[1.0, 2.0], [2.0, 3.0]], [1.0, 2.0], hs.DataError, "2 rows"),
        ([[1.0, 2.0], [2.0, np.nan], [3.0, 5.0]], [1.0, 2.0, 4.0], hs.DataError, r"H\[\(1, 1\)\] is nan"),
        ([[1.0, 2.0], [2.0, 4.5], [3.0, 6.0]], [1.0, np.inf, 4.0], hs.DataError, r"y\[1\] is inf"),
        ([1.0, 2.0, 3.0], [1.0, 2.0, 4.0], hs.UsageError, "shape"),
        ([[1.0, 2.0], [2.0, 4.5], [3.0, 6.0]], [1.0, 2.0], hs.UsageError, "3 rows, but y has 2"),
        ([["a", "b"]], [1.0], hs.UsageError, "H"),
    ],
)
def test_what_cannot_be_solved_is_named(H: object, y: object, error: type[Exception], words: str) -> None:
    with pytest.raises(error, match=words):
        hs.least_squares(H, y, ["k_u", "k_v"])  # type: ignore[arg-type]
    assert issubclass(error, ValueError)


def test_views_and_other_layouts_are_taken() -> None:
    H = np.asfortranarray(np.c_[np.ones(6), np.arange(6.0)])
    y = np.repeat(np.arange(6), 2)[::2]  # integers, strided
    np.testing.assert_allclose(hs.least_squares(H, y).coefficients, [0.0, 1.0], atol=1e-13)


def test_rk4_is_of_fourth_order() -> None:
    def error(substeps: int) -> float:
        y = hs.rk4(lambda t, y: np.array([y[1], -y[0]]), [0.0, 1.0, 2.0], [0.0, 1.0], substeps)
        return float(np.abs(y[-1] - [np.sin(2.0), np.cos(2.0)]).max())

    assert error(10) / error(20) == pytest.approx(16.0, rel=0.1)  # the next order is 5 % at this step
    assert error(20) < 1e-6


def test_rk4_passes_the_functions_error_through() -> None:
    def wrong(t: float, y: np.ndarray) -> np.ndarray:
        raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        hs.rk4(wrong, [0.0, 1.0], [1.0])
    with pytest.raises(hs.UsageError, match="2 rates for 1"):
        hs.rk4(lambda t, y: [1.0, 2.0], [0.0, 1.0], [1.0])
    with pytest.raises(hs.DataError, match="smaller step"):
        hs.rk4(lambda t, y: [1e300 * float(y[0])], [0.0, 1.0], [1.0])
    with pytest.raises(hs.UsageError):
        hs.rk4(lambda t, y: y, [0.0, 1.0], [1.0], substeps=0)


def test_polynomial_filter_keeps_polynomials_in_uneven_time() -> None:
    t = np.cumsum(np.random.default_rng(1).uniform(0.05, 0.15, 60))
    x, rate = hs.polynomial_filter(t, 1.0 + t - 0.5 * t**2, samples=9, degree=2)
    np.testing.assert_allclose(x, 1.0 + t - 0.5 * t**2, atol=1e-10)
    np.testing.assert_allclose(rate, 1.0 - t, atol=1e-9)
    with pytest.raises(hs.DataError, match="odd"):
        hs.polynomial_filter(t, t, samples=4)
    with pytest.raises(hs.UsageError, match="samples or in seconds"):
        hs.polynomial_filter(t, t)


def test_thruster_with_a_dead_band() -> None:
    v = np.linspace(-1.0, 1.0, 81)
    x = np.maximum(0.0, np.abs(v) - 0.08)
    fit = hs.fit_thruster(v, np.sign(v) * (30.0 * x**2 + 12.0 * x), deadband=None)
    assert fit.deadband.value == pytest.approx(0.08, abs=1e-5)
    assert fit.forward.a.value == pytest.approx(30.0, rel=1e-3)
    assert fit.exponent is None


def test_regressors_find_the_vehicle(runs: list[hs.Run]) -> None:
    system = hs.regressors(runs, "surge", ["inertia", "linear_drag", "quadratic_drag"], samples=20)
    assert system.columns.shape == (len(system.rhs), 3) == (len(system.span), 3)
    fit = hs.least_squares(system.columns, system.rhs, system.names)
    # 2 mm/s of noise at rows of 2 s leave some per cent
    np.testing.assert_allclose(fit.coefficients, [250.0, 20.0, 120.0], rtol=0.15)
    held = hs.regressors(runs, "surge", ["inertia", "linear_drag", "quadratic_drag"], fixed={"linear_drag@surge": 20.0})
    assert held.names == ("m_u", "k_u|u|")
    with pytest.raises(hs.UsageError, match="degree of freedom"):
        hs.regressors(runs, "drift", ["inertia"])
    with pytest.raises(hs.UsageError):
        hs.regressors(runs, "surge", ["inertias"])


def test_catalogue() -> None:
    catalogue = {effect.id: effect for effect in hs.effects()}
    assert catalogue["quadratic_drag"].parameters[0].unit == "kg/m"
    assert "surge" in catalogue["linear_drag"].dofs
    assert catalogue["thrust_lag"].family == "actuator"


def test_blocks_show_themselves_as_results_do() -> None:
    v = np.linspace(-1.0, 1.0, 21)
    noisy = 30.0 * v * abs(v) + 10.0 * v + 0.1 * np.cos(40.0 * v)
    H = np.c_[np.ones(5), np.arange(5.0)]
    for found in (hs.least_squares(H, [1, 3, 2, 5, 4], ["offset", "slope"]), hs.fit_thruster(v, noisy)):
        assert pickle.loads(pickle.dumps(found)) == found
        assert [frame.shape[0] for frame in (found.to_frame("pandas"), found.to_frame("polars"))] == [
            len(found.rows())
        ] * 2
        assert r"\begin{tabular}{lr" in found.to_latex()
        assert "<table>" in found._repr_html_()
        assert type(found).__name__ in repr(found)
        axes = found.plot()
        assert found.plot(ax=axes) is axes
        axes.figure.clear()


def test_effects_are_found_by_their_common_names() -> None:
    assert [(e.id, e.common_name) for e in hs.effects("MUNK")] == [
        ("coriolis_pitch", "the Munk moment in pitch"),
        ("coriolis_yaw", "the Munk moment"),
    ]
    assert [e.id for e in hs.effects(search="thrust-lag")] == ["thrust_lag"]
    assert {e.id for e in hs.effects("added mass")} >= {"inertia", "added_mass_coupling", "added_mass_amplitude"}
    assert len(hs.effects()) > 40
    with pytest.raises(hs.UsageError, match=r"no effect has 'munc'.*did you mean 'munk'\?"):
        hs.effects("munc")
    with pytest.raises(hs.UsageError, match=r"common name or meaning$"):
        hs.effects("warp drive")


def strided(H: np.ndarray) -> np.ndarray:
    wide = np.full((H.shape[0], 2 * H.shape[1]), np.nan)
    wide[:, ::2] = H
    return wide[:, ::2]


ORDERS = {
    "C": np.ascontiguousarray,
    "Fortran": np.asfortranarray,
    "strided": strided,
    "rows reversed": lambda H: np.ascontiguousarray(H[::-1])[::-1],
    "columns reversed": lambda H: np.asfortranarray(H[:, ::-1])[:, ::-1],
}


@pytest.mark.parametrize("order", ORDERS)
def test_a_long_system_is_read_where_it_lies(order: str) -> None:
    """100,000 rows of five columns in any order of memory: the same to the bit, and no copy of the 4 MB."""
    rng = np.random.default_rng(7)
    columns = rng.standard_normal((100_000, 5)) @ rng.standard_normal((5, 5))
    y = columns @ np.arange(1.0, 6.0) + rng.standard_normal(100_000)
    expected = hs.least_squares(columns, y)
    H = ORDERS[order](columns)
    np.testing.assert_array_equal(H, columns)
    tracemalloc.start()
    try:
        fit = hs.least_squares(H, y)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    # one column of H alone is 800 kB
    assert peak < 100_000
    for name in ("coefficients", "standard_errors", "covariance"):
        np.testing.assert_array_equal(getattr(fit, name), getattr(expected, name))
    assert (fit.residual_std, fit.r_squared) == (expected.residual_std, expected.r_squared)
    assert fit.condition_number == expected.condition_number
    # and of NumPy, to the digits that a well-conditioned system leaves
    np.testing.assert_allclose(fit.coefficients, np.linalg.lstsq(columns, y)[0], rtol=1e-10)
