"""Arrays of every kind: understood or refused, never misread."""

import hydrosysid as hs
import numpy as np
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
