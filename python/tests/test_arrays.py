"""Arrays of every kind: understood or refused, never misread."""

import hydrosysid as hs
import numpy as np
import pandas as pd
import polars as pl
import pyarrow as pa
import pytest

T = np.array([0.0, 0.1, 0.2, 0.3])
U = np.array([0.0, 0.5, 0.7, 0.9])


def masked(values: np.ndarray) -> np.ma.MaskedArray:
    return np.ma.masked_array(values, mask=[False, False, True, False])


def test_a_masked_value_is_no_value() -> None:
    with pytest.raises(hs.DataError, match=r"u\[2\]"):
        hs.Run(t=T, u=masked(U))
    with pytest.raises(hs.DataError, match=r"u\[2\]"):
        hs.Run(t=T, u=masked(np.array([1, 2, 3, 4])))
    time, values = hs.Run(t=T, u=masked(U), missing="no_sample")["u"]
    assert (time.tolist(), values.tolist()) == ([0.0, 0.1, 0.3], [0.0, 0.5, 0.9])
    with pytest.raises(hs.DataError, match=r"t\[2\]"):
        hs.Run(t=masked(T), u=U)
    assert hs.Run(t=T, u=np.ma.masked_array(U))["u"][1].tolist() == U.tolist()
    run = hs.Run.from_numpy({"t": T, "u": masked(U)}, missing="no_sample")
    assert run["u"][1].tolist() == [0.0, 0.5, 0.9]
    with pytest.raises(hs.DataError, match=r"H\[\(2, 0\)\]"):
        hs.least_squares(np.ma.masked_array(np.ones((4, 1)), mask=[[0], [0], [1], [0]]), U)


@pytest.mark.parametrize("values", [U * 1j, (U * 1j).astype(object), list(U + 0j), (U + 0j).astype(np.complex64)])
def test_complex_numbers_are_refused(values: object) -> None:
    with pytest.raises(hs.UsageError, match="complex"):
        hs.Run(t=T, u=values)
    with pytest.raises(hs.UsageError, match="complex"):
        hs.least_squares(np.ones((4, 1)), values)
    with pytest.raises(hs.UsageError, match="complex"):
        hs.Run.from_numpy({"t": T, "speed": np.asarray(values, dtype=complex)}, columns={"u": "speed"})


def test_dates_and_durations_are_time_stamps_and_nothing_else() -> None:
    dates = np.datetime64("2024-07-01T10:40:00") + np.array([0, 100, 200, 300], dtype="timedelta64[ms]")
    lasted = np.array([0, 100, 200, 300], dtype="timedelta64[ms]")
    for stamps in (dates, lasted, dates.tolist(), dates.astype("M8[ns]")):
        assert hs.Run(t=stamps, u=U)["u"][0].tolist() == pytest.approx(T.tolist(), abs=1e-12)
        assert hs.Run.from_numpy(
            {"t": np.asarray(stamps, dtype=None if isinstance(stamps, np.ndarray) else "M8[ms]"), "u": U}
        )["u"][0].tolist() == pytest.approx(T.tolist(), abs=1e-12)
    # one clock for sensors with their own stamps: the earliest instant of all is 0
    run = hs.Run(u=(dates, U), r=(dates[1:], U[1:]), gaps=[dates[2]])
    assert run["r"][0].tolist() == pytest.approx([0.1, 0.2, 0.3], abs=1e-12)
    assert run.gaps == pytest.approx((0.2,), abs=1e-12)
    for values in (dates, lasted, list(dates)):
        with pytest.raises(hs.UsageError, match="dates"):
            hs.Run(t=T, u=values)
        with pytest.raises(hs.UsageError, match="dates"):
            hs.Run.from_numpy({"t": T, "when": np.asarray(values)}, columns={"u": "when"})
    with pytest.raises(hs.UsageError, match="one kind"):
        hs.Run(u=(dates, U), r=(T, U))
    with pytest.raises(hs.UsageError, match="seconds"):
        hs.Run(t=T, u=U).with_channels({"r": (dates, U)})
    lost = dates.copy()
    lost[1] = np.datetime64("NaT")
    for make in (hs.Run, lambda **k: hs.Run.from_numpy(k)):
        with pytest.raises(hs.DataError, match="time stamp"):
            make(t=lost, u=U)


@pytest.mark.parametrize(
    "stamps",
    [
        np.array([0, 1, 400], "m8[Y]"),
        np.array([0, 1, 2**62], "m8[M]"),
        np.array(["2000", "2001", "2500"], "M8[s]"),
        np.array(["1200", "2000", "2001"], "M8[D]"),
    ],
)
def test_an_instant_that_nanoseconds_do_not_hold_is_refused(stamps: np.ndarray) -> None:
    """NumPy and pandas wrap it to another."""
    bad = 1 if stamps[0] == np.datetime64("1200") else 3
    told = (
        rf"t.*: the time stamp of sample {bad} is .*: a (date from 1678 to 2261|duration up to 292 years) can be read"
    )
    with pytest.raises(hs.DataError, match=told):
        hs.Run(t=stamps, u=U[:3])
    with pytest.raises(hs.DataError, match=told):
        hs.Run.from_numpy({"t": stamps, "u": U[:3]})
    if stamps.dtype == "M8[s]":
        with pytest.raises(hs.DataError, match=told):
            hs.Run.from_pandas(pd.DataFrame({"t": stamps, "u": U[:3]}))


def test_a_run_of_more_than_292_years_is_refused() -> None:
    with pytest.raises(hs.DataError, match="longer than the 292 years"):
        hs.Run(t=np.array(["1700", "2200"], "M8[Y]"), u=U[:2])
    years = np.array([0, 1, 2, 3], "m8[Y]")
    assert hs.Run(t=years, u=U)["u"][0].tolist() == [0.0, 31556952.0, 63113904.0, 94670856.0]


def test_a_setting_that_is_no_number_is_told_by_its_key() -> None:
    run = hs.Run(t=np.arange(50) / 10, u=np.sin(np.arange(50)), tau_u=np.cos(np.arange(50)))

    def made(**tables: object) -> hs.Campaign:
        return hs.Campaign(dofs=["surge"], effects=["inertia", "linear_drag"], runs=[run], **tables)  # type: ignore[arg-type]

    for tables, key in [
        ({"vehicle": {"mass": np.nan}}, r"vehicle\.mass = nan"),
        ({"noise": {"u": np.float32("inf")}}, r"noise\.u = inf"),
        ({"parameters": [{"effect": "inertia@surge", "value": float("nan")}]}, r"parameter\[0\]\.value = nan"),
        ({"vehicle": {"cg": np.array([0.0, np.nan, 0.0])}}, r"vehicle\.cg\[1\] = nan"),
        ({"vehicle": {"mass": 1j}}, r"vehicle\.mass"),
        ({"vehicle": {"mass": np.ma.masked}}, r"vehicle\.mass"),
    ]:
        with pytest.raises(hs.UsageError, match=key):
            made(**tables)
    assert made(vehicle={"mass": np.float32(100.0)}, noise={"u": np.float64(0.01)}).name == ""


def test_absent_values_are_no_samples_whoever_says_so() -> None:
    for absent in (
        np.ma.masked_array(U, mask=[0, 1, 0, 0]),
        pd.array([U[0], pd.NA, *U[2:]], dtype="Float64"),
        pd.Series([U[0], None, *U[2:]], dtype="Float64"),
        [U[0], None, *U[2:]],
        [U[0], pd.NA, *U[2:]],
        pl.Series([U[0], None, *U[2:]]),
        pa.array([U[0], None, *U[2:]]),
    ):
        run = hs.Run(t=T, u=absent, missing="no_sample")
        assert run["u"][0].tolist() == [T[0], T[2], T[3]]
        assert run["u"][1].tolist() == [U[0], U[2], U[3]]
        with pytest.raises(hs.DataError, match=r"u\[1\] is nan"):
            hs.Run(t=T, u=absent)
    nullable = pd.DataFrame({"t": T, "u": pd.array([U[0], pd.NA, *U[2:]], dtype="Float64")})
    assert hs.Run.from_frame(nullable, missing="no_sample")["u"][1].tolist() == [U[0], U[2], U[3]]
    whole = pd.DataFrame({"t": T, "u": pd.array([1, 2, 3, 4], dtype="Int32")})
    assert hs.Run.from_frame(whole)["u"][1].tolist() == [1.0, 2.0, 3.0, 4.0]


def test_units_of_pint_are_converted() -> None:
    pint = pytest.importorskip("pint")
    unit = pint.UnitRegistry()
    knots, degrees = unit.Quantity(U, "knot"), unit.Quantity(U, "degree")
    run = hs.Run(
        t=unit.Quantity(1e3 * T, "ms"),
        u=knots,
        r=degrees / unit.second,
        psi=degrees,
        tau_u=unit.Quantity(U, "kN"),
        tau_r=unit.Quantity(U, "N*m"),
        V1=unit.Quantity(np.full(4, 1.6), "ms"),
        V2=unit.Quantity(U, "mV"),
        wind=unit.Quantity(U, "km/hour"),
    )
    np.testing.assert_allclose(run["u"][0], T, rtol=1e-12)
    np.testing.assert_allclose(run["u"][1], U * 1852.0 / 3600.0, rtol=1e-12)
    np.testing.assert_allclose(run["r"][1], np.deg2rad(U), rtol=1e-12)
    np.testing.assert_allclose(run["psi"][1], np.deg2rad(U), rtol=1e-12)
    np.testing.assert_allclose(run["tau_u"][1], 1e3 * U, rtol=1e-12)
    np.testing.assert_allclose(run["wind"][1], U / 3.6, rtol=1e-12)
    # commands keep what a thruster understands: microseconds of a pulse, volts
    np.testing.assert_allclose(run["V1"][1], 1600.0)
    np.testing.assert_allclose(run["V2"][1], 1e-3 * U)
    assert dict(run.units) == {"V1": "us"}
    listed = hs.Run(t=T, u=[unit.Quantity(x, "knot") for x in U])
    np.testing.assert_array_equal(listed["u"][1], run["u"][1])
    masked = unit.Quantity(np.ma.masked_array(U, mask=[0, 1, 0, 0]), "knot")
    assert len(hs.Run(t=T, u=masked, missing="no_sample")["u"][1]) == 3
    with pytest.raises(hs.UsageError, match=r"u is in radian / second: m/s is expected"):
        hs.Run(t=T, u=unit.Quantity(U, "rad/s"))
    with pytest.raises(hs.UsageError, match=r"t is in meter: s is expected"):
        hs.Run(t=unit.Quantity(T, "m"), u=U)
    fit = hs.least_squares(np.vander(T, 2), unit.Quantity(2.0 * T, "km"))
    np.testing.assert_allclose(fit.coefficients, [2000.0, 0.0], atol=1e-9)
    long = hs.Run(t=np.arange(50) / 10, u=np.sin(np.arange(50)), tau_u=np.cos(np.arange(50)))
    pounds = hs.Campaign(
        vehicle={"name": "a", "mass": unit.Quantity(1000.0, "pound")},
        dofs=["surge"],
        effects=["inertia", "linear_drag"],
        runs=[long],
    )
    assert '"mass": 453.59237' in pounds._source[1]


def test_columns_of_a_frame_that_carry_units_are_converted() -> None:
    class Column:
        """As pint-pandas holds one: the quantity is in the array of the series."""

        def __init__(self, quantity: object) -> None:
            self.array = type("Array", (), {"quantity": quantity})

    class Frame(dict[str, Column]):
        columns = property(lambda self: list(self))

    pint = pytest.importorskip("pint")
    unit = pint.UnitRegistry()
    frame = Frame(t=Column(unit.Quantity(T, "s")), speed=Column(unit.Quantity(U, "knot")))
    run = hs.Run.from_frame(frame, columns={"t": "t", "u": "speed"})
    np.testing.assert_allclose(run["u"][1], U * 1852.0 / 3600.0, rtol=1e-12)
    with pytest.raises(hs.UsageError, match="carry units: give only the name"):
        hs.Run.from_frame(frame, columns={"t": "t", "u": {"name": "speed", "unit": "kn"}})
