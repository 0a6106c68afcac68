"""Runs from arrays, frames and files."""

import pickle
from pathlib import Path

import hydrosysid as hs
import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

T = np.arange(5) * 0.1


@settings(max_examples=30, deadline=None)
@given(st.lists(st.floats(-1e6, 1e6), min_size=2, max_size=30))
def test_frame_round_trip(values: list[float]) -> None:
    run = hs.Run(t=np.arange(len(values)) * 0.1, u=values, name="a")
    assert hs.Run.from_frame(run.to_frame(), name="a") == run
    assert pickle.loads(pickle.dumps(run)) == run


def test_sensors_keep_their_own_stamps() -> None:
    run = hs.Run(t=T, u=T, r=[1.0, np.nan, 2.0, np.nan, 3.0], missing="no_sample")
    assert run["r"][0].tolist() == [0.0, 0.2, 0.4]
    frame = run.to_frame("pandas")
    assert frame["r"].isna().tolist() == [False, True, False, True, False]


def test_names_of_a_frame_are_chosen() -> None:
    frame = pd.DataFrame({"time": T, "speed": T, "junk": "x"})
    assert hs.Run.from_frame(frame, columns={"t": "time", "u": "speed"}).channels == ("u",)
    with pytest.raises(hs.UsageError, match="no column 'fast'"):
        hs.Run.from_frame(frame, columns={"t": "time", "u": "fast"})


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"t": [0.0, 0.2, 0.1, 0.3, 0.4], "u": T}, r"t\[2\] = 0.1 does not follow 0.2"),
        ({"t": T, "u": [0.0, np.nan, 0.0, 0.0, 0.0]}, r"u\[1\] is nan"),
        ({"t": T, "u": [0.0, 1.0]}, "2 values for 5"),
        ({"u": T}, "no time stamps"),
        ({"t": T}, "no channel"),
        ({"t": T, "u": T, "kind": "zig"}, "kind = 'zig' is none of bollard"),
        ({"t": T, "u": T, "role": "test"}, "role"),
    ],
)
def test_what_is_no_run_is_named(arguments: dict[str, object], words: str) -> None:
    with pytest.raises(hs.HydrosysidError, match=words):
        hs.Run(**arguments)  # type: ignore[arg-type]


def test_a_run_does_not_change() -> None:
    run = hs.Run(t=T, u=T)
    with pytest.raises(AttributeError):
        run.name = "b"
    with pytest.raises(ValueError, match="read-only"):
        run["u"][1][0] = 7.0
    assert "<table>" in run._repr_html_()


def test_csv_units_are_converted(tmp_path: Path) -> None:
    log = tmp_path / "log.csv"
    log.write_text("t [ms];u [cm/s]\n" + "".join(f"{100 * k};{k},5\n" for k in range(9)))
    run = hs.Run.from_csv(log, delimiter=";", decimal=",", name="log")
    np.testing.assert_allclose(run["u"][0], np.arange(9) * 0.1, atol=1e-12)
    np.testing.assert_allclose(run["u"][1], (np.arange(9) + 0.5) / 100.0, rtol=1e-12)


def test_a_bad_cell_is_found_with_its_place(tmp_path: Path) -> None:
    log = tmp_path / "log.csv"
    log.write_text("t,u\n0,1\n0.1,abc\n0.2,1\n")
    with pytest.raises(hs.DataError, match=r"line 3.*column u") as caught:
        hs.Run.from_csv(log)
    finding = caught.value.findings[0]
    assert (finding.line, finding.column, finding.severity) == (3, "u", "error")
    again = pickle.loads(pickle.dumps(caught.value))
    assert (str(again), again.findings) == (str(caught.value), caught.value.findings)
    with pytest.raises(hs.UsageError):
        hs.Run.from_csv(tmp_path / "absent.csv")
    with pytest.raises(hs.UsageError, match="delimeter"):
        hs.Run.from_csv(log, delimeter=";")
