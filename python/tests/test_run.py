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
        ({"t": T, "u": T, "gaps": [0.2, np.nan]}, r"gaps\[1\] is nan"),
        ({"t": T, "u": T, "gaps": [np.inf]}, r"gaps\[0\] is inf"),
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


def test_pulses_stay_pulses_until_the_thruster_is_known(tmp_path: Path) -> None:
    t = np.arange(0.0, 40.0, 0.1)
    pulse = 1500.0 + 300.0 * np.sin(t)
    speed = 0.2 * np.sin(t - 1.0)
    rows = "".join(f"{a!r},{b!r},{c!r}\n" for a, b, c in zip(t.tolist(), speed.tolist(), pulse.tolist(), strict=True))
    (tmp_path / "log.csv").write_text("t,u,V1 [us]\n" + rows)
    thruster = {
        "name": "main",
        "position": [0.0, 0.0, 0.0],
        "axis": [1.0, 0.0, 0.0],
        "forward": {"a": 30.0, "b": 5.0},
        "reverse": {"a": 30.0, "b": 5.0},
        "neutral": 1500.0,
        "span": 400.0,
    }
    model = {"dofs": ["surge"], "effects": ["inertia", "linear_drag"]}
    toml = "format = 1\n[model]\ndofs = ['surge']\neffects = ['inertia', 'linear_drag']\n[[thruster]]\nname = 'main'\n"
    toml += "position = [0.0, 0.0, 0.0]\naxis = [1.0, 0.0, 0.0]\nforward = { a = 30.0, b = 5.0 }\n"
    toml += (
        "reverse = { a = 30.0, b = 5.0 }\nneutral = 1500.0\nspan = 400.0\n[[run]]\nfile = 'log.csv'\nkind = 'free'\n"
    )
    (tmp_path / "campaign.toml").write_text(toml)
    of_file = hs.fit(tmp_path / "campaign.toml")
    read = hs.Run.from_csv(tmp_path / "log.csv")
    assert dict(read.units) == {"V1": "us"}
    mapped = hs.Run.from_numpy(
        {"t": t, "u": speed, "pwm": pulse}, columns={"u": "u", "V1": {"name": "pwm", "unit": "us"}}
    )
    for run in (read, mapped, hs.Run(t=t, u=speed, V1=pulse, units={"V1": "us"}), pickle.loads(pickle.dumps(read))):
        fit = hs.fit(hs.Campaign(runs=[run], thruster=[thruster], **model))  # type: ignore[arg-type]
        assert [p.value for p in fit.parameters] == [p.value for p in of_file.parameters]
    mapped.to_csv(tmp_path / "again.csv")
    assert (tmp_path / "again.csv").read_text().startswith("t [s],V1 [us],u [m/s]\n")
    with pytest.raises(hs.UsageError, match="units"):
        hs.Run(t=t, u=speed, units={"u": "us"})
