"""The command of the wheel: what Python adds to it, and what it shares with the functions."""

import json
import os
import subprocess
import sys
import urllib.error
import urllib.request
from pathlib import Path

import hydrosysid as hs
import numpy as np
import pytest
from mcap.reader import make_reader

MAP = """
body_frame = "flu"
[columns]
t = { name = "time", unit = "ms" }
u = "speed"
v = { name = "side", unit = "mm/s" }
"""


def command(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    run = [sys.executable, "-m", "hydrosysid", *words]
    return subprocess.run(run, cwd=folder, capture_output=True, text=True, check=False)


@pytest.fixture
def table(tmp_path: Path) -> Path:
    np.savez(tmp_path / "dive.npz", time=np.arange(30) * 50, speed=np.arange(30) / 7.0, side=np.arange(30) * 3.0)
    (tmp_path / "map.toml").write_text(MAP)
    return tmp_path


def test_convert_reads_what_the_functions_read(table: Path) -> None:
    done = command(table, "convert", "dive.npz", "-o", "out.csv", "--map", "map.toml")
    assert done.returncode == 0, done.stderr
    assert "30 rows, 2 channels: u, v" in done.stdout
    assert "L211" in done.stderr
    direct = hs.convert(table / "dive.npz", map=table / "map.toml")
    again = hs.Run.from_csv(table / "out.csv")
    for channel in ("u", "v"):
        np.testing.assert_array_equal(again[channel], direct[channel])
    assert again["v"][1].tolist() == [-3.0 * k / 1e3 for k in range(30)]
    assert command(table, "convert", "dive.npz", "-o", "out.csv", "--map", "map.toml").returncode == 2
    assert command(table, "convert", "dive.npz", "out.csv", "--map", "map.toml", "--force", "-q").stdout == ""


def test_convert_of_csv_takes_a_map_too(table: Path) -> None:
    rows = "".join(f"{50 * k},{k / 7.0!r},{3.0 * k}\n" for k in range(30))
    (table / "dive.csv").write_text("time,speed,side\n" + rows)
    done = command(table, "convert", "dive.csv", "-o", "a.csv", "--map", "map.toml")
    assert done.returncode == 0, done.stderr
    assert command(table, "convert", "dive.npz", "-o", "b.csv", "--map", "map.toml").returncode == 0
    assert (table / "a.csv").read_bytes() == (table / "b.csv").read_bytes()
    hs.convert(table / "dive.csv", table / "c.csv", map=table / "map.toml")
    assert (table / "a.csv").read_bytes() == (table / "c.csv").read_bytes()


def test_json_and_refusals_of_convert(table: Path) -> None:
    words = ("convert", "dive.npz", "-o", "o.csv", "--map", "map.toml")
    told = json.loads(command(table, *words, "--json", "-", "--quiet").stdout)
    assert told["channels"]["u"] == {"samples": 30, "from": 0.0, "to": 1.45}
    wrong = command(table, "convert", "dive.npz", "-o", "p.csv", "--log", 'columns.t = "clock"')
    assert wrong.returncode == 2
    assert "columns.t = 'clock' is not there" in wrong.stderr
    (table / "bad.npz").write_bytes(b"no zip")
    bad = command(table, "convert", "bad.npz", "-o", "p.csv")
    assert bad.returncode == 1
    assert "bad.npz" in bad.stderr
    assert not (table / "p.csv").exists()
    (table / "typo.toml").write_text('colums = { u = "speed" }\n')
    typo = command(table, "convert", "dive.npz", "-o", "p.csv", "--map", "typo.toml")
    assert "did you mean `columns`" in typo.stderr


def test_check_of_another_format_names_the_command_that_reads_it(table: Path) -> None:
    done = command(table, "check", "dive.npz", "--columns", "t,u")
    assert done.returncode == 1
    # the terminal breaks lines where its width asks for it
    told = " ".join(done.stderr.split())
    assert "`hydrosysid init LOG -o FOLDER` reads it and writes a campaign" in told
    assert "L216" in told
    (error,) = hs.check(table / "dive.npz").errors
    assert (error.code, error.kind) == ("L216", "other-format")
    assert "`hydrosysid init LOG -o FOLDER`" in error.message
    assert json.loads(command(table, "check", "dive.npz", "--json", "-").stdout)["verdict"] == "red"
    (table / "bag").mkdir()
    (table / "bag" / "metadata.yaml").write_text("rosbag2_bagfile_information: {}\n")
    told = " ".join(command(table, "check", "bag").stderr.split())
    assert "a ROS 2 bag: `hydrosysid init FOLDER -o dive`" in told


@pytest.mark.parametrize(("name", "content"), [("bad.BIN", bytes(20)), ("bad.csv", b"nothing")])
def test_strict_init_refuses_a_log_that_it_cannot_read(tmp_path: Path, name: str, content: bytes) -> None:
    """By Python and by the crate."""
    (tmp_path / name).write_bytes(content)
    lax = command(tmp_path, "init", name, "-o", "lax")
    assert lax.returncode == 0, lax.stderr
    assert f"warning: not read: {name}" in lax.stderr
    done = command(tmp_path, "init", name, "-o", "dive", "--strict")
    assert done.returncode == 1
    assert f"warning: not read: {name}" in done.stderr
    assert "--strict treats warnings as errors" in done.stderr
    assert not (tmp_path / "dive" / "campaign.toml").exists()


@pytest.mark.parametrize("verb", ["convert", "init"])
def test_jobs_limit_the_threads(table: Path, verb: str) -> None:
    """By the variable that the pool of the compiled part asks."""
    own = ["--map", "map.toml"] if verb == "convert" else []
    program = (
        "import os, sys; from hydrosysid._command import run_with\n"
        f"code = run_with([{verb!r}, 'dive.npz', '-o', 'made', '-q', *sys.argv[1:]])\n"
        "print(code, os.environ.get('RAYON_NUM_THREADS'))"
    )

    def threads(*words: str) -> str:
        run = [sys.executable, "-c", program, *own, "--force", *words]
        unset = {key: value for key, value in os.environ.items() if key != "RAYON_NUM_THREADS"}
        return subprocess.run(run, cwd=table, env=unset, capture_output=True, text=True, check=True).stdout.strip()

    assert threads() == "0 None"
    assert threads("-j", "1") == "0 1"
    assert command(table, verb, "dive.npz", "-o", "other", "--jobs", "none", *own).returncode == 2


def test_series_side_by_side(folder: Path, fit_of_folder: hs.Fit) -> None:
    (folder / "model.toml").write_text(fit_of_folder.model.to_toml(), encoding="utf-8")
    simulated = hs.simulate(folder / "campaign.toml", folder / "model.toml")
    words = ("campaign.toml", "--model", "model.toml", "--series")
    assert command(folder, "simulate", *words, "s.csv").returncode == 0
    assert command(folder, "compare", *words, "c.csv").returncode == 0
    assert (folder / "s.csv").read_bytes() == (folder / "c.csv").read_bytes()
    simulated.to_csv(folder / "py.csv")
    assert (folder / "s.csv").read_bytes() == (folder / "py.csv").read_bytes()
    back = hs.Run.from_csv(folder / "s.csv", missing="no_sample")
    run = simulated["surge_2.csv"]
    there = np.isfinite(run.measured["u"])
    np.testing.assert_array_equal(back["surge_2.csv/u/simulated"], (run.time, run.simulated["u"]))
    residual = (run.measured["u"] - run.simulated["u"])[there]
    np.testing.assert_array_equal(back["surge_2.csv/u/residual"], (run.time[there], residual))


def test_series_as_mcap(folder: Path, fit_of_folder: hs.Fit) -> None:
    (folder / "model.toml").write_text(fit_of_folder.model.to_toml(), encoding="utf-8")
    done = command(folder, "simulate", "campaign.toml", "--model", "model.toml", "--series", "s.mcap")
    assert done.returncode == 0, done.stderr
    simulated = hs.simulate(folder / "campaign.toml", folder / "model.toml")
    simulated.to_mcap(folder / "py.mcap")
    assert (folder / "s.mcap").read_bytes() == (folder / "py.mcap").read_bytes()
    with (folder / "s.mcap").open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        read = [(m.log_time, json.loads(m.data)) for _, _, m in reader.iter_messages(topics=["/surge_1.csv/u"])]
    run = simulated["surge_1.csv"]
    assert [at for at, _ in read] == [round(t * 1e9) for t in run.time.tolist()]
    assert [m["simulated"] for _, m in read] == run.simulated["u"].tolist()
    measured = [m["measured"] for _, m in read if "measured" in m]
    assert measured == run.measured["u"][np.isfinite(run.measured["u"])].tolist()
    assert all(m["residual"] == m["measured"] - m["simulated"] for _, m in read if "measured" in m)
    again = hs.Run.from_mcap(folder / "s.mcap", columns={"u": "/surge_1.csv/u:measured"}, missing="no_sample")
    assert again["u"][1].tolist() == measured
    refused = command(folder, "simulate", "campaign.toml", "--series", "s.mcap")
    assert refused.returncode == 2
    assert "s.mcap exists" in refused.stderr


def test_series_of_runs_that_begin_before_zero(tmp_path: Path) -> None:
    times, values = np.array([-1.25, 0.5]), np.array([1.0, 2.0])
    run = hs.SimulatedRun("a", "train", times, {"u": values}, {"u": values})
    hs.Simulation(1, (run,), ()).to_mcap(tmp_path / "a.mcap")
    with (tmp_path / "a.mcap").open("rb") as file:
        reader = make_reader(file)
        assert [m.log_time for _, _, m in reader.iter_messages()] == [750_000_000, 2_500_000_000]
        assert [record.metadata["time_shift_s"] for record in reader.iter_metadata()] == ["2"]


@pytest.fixture
def fit_of_folder(campaign: hs.Campaign) -> hs.Fit:
    return hs.fit(campaign)


def test_init_report_and_explain_are_functions_too(folder: Path) -> None:
    text = hs.init([folder / "surge_1.csv", folder / "surge_2.csv"], folder / "new.toml", name="small", mass=150.0)
    typed = ("init", "surge_1.csv", "surge_2.csv", "--name", "small", "--mass", "150")
    assert command(folder, *typed).stdout == text == (folder / "new.toml").read_text(encoding="utf-8")
    assert len(hs.Campaign.from_file(folder / "new.toml").runs) == 2
    with pytest.raises(hs.UsageError, match="exists"):
        hs.init([folder / "surge_1.csv"], folder / "new.toml")
    with pytest.raises(hs.UsageError, match="no such log"):
        hs.init(["/surge_1.csv"], folder / "other.toml")
    page = hs.report(folder / "campaign.toml", folder / "r.html", discovery=False)
    assert "small: identification" in page.read_text(encoding="utf-8")
    assert hs.explain("L105")[0]["meaning"] in " ".join(command(folder, "explain", "L105").stdout.split())
    with pytest.raises(hs.UsageError, match="X999"):
        hs.explain("X999")


def test_the_page_is_served_until_it_is_stopped(tmp_path: Path) -> None:
    with hs.view(tmp_path, browser=False) as page:
        with urllib.request.urlopen(page.address, timeout=30) as answer:
            assert "Drop logs here" in answer.read().decode()
        with pytest.raises(urllib.error.HTTPError, match="403"):
            urllib.request.urlopen(page.address.split("?")[0], timeout=30)
        assert page.address in repr(page)
        assert "href" in page._repr_html_()
    assert not page.is_served
    assert repr(page) == "View(ended)"
    with pytest.raises(hs.UsageError, match="no such folder"):
        hs.view(tmp_path / "nowhere", browser=False)


def test_every_verb_of_the_command_is_a_function() -> None:
    helped = subprocess.run([sys.executable, "-m", "hydrosysid", "--help"], capture_output=True, text=True, check=True)
    listed = helped.stdout.split("Commands:")[1].split("Options:")[0].splitlines()
    verbs = {line.split()[0] for line in listed if line.startswith("  ") and not line.startswith("   ")}
    assert len(verbs) > 10
    for verb in verbs - {"completions", "man", "help"}:
        assert callable(getattr(hs, verb)), verb
