"""Names that come from outside stay text in exported code: it compiles, and runs nothing of them."""

import ast
import json
import os
import shutil
import subprocess
from pathlib import Path

import hydrosysid as hs
import pytest

INERTIA = (20.0, 25.0, 28.0)
# as in tests/all/escaping.rs
HOSTILE = (
    'boat\nsystem(\'echo code\')\r%}\u2028\u0001\u0000\u000b"""\\\n--> <x/> */ {longest} \u202e\u2066\uffff\u0085,'
    "=cmd|' /C calc'!A0"
)
NOISE = """
[noise]
innovations_white = true
[[noise.sensor]]
channel = "u"
std = 0.01
restlessness = 1.0
"""


@pytest.fixture
def hostile() -> hs.Model:
    text = (Path(__file__).parent / "floating.toml").read_text()
    assert 'name = "floating"' in text
    # a string of JSON is one of TOML
    text = text.replace('name = "floating"', f"name = {json.dumps(HOSTILE)}")
    at = text.index("[[parameter]]")
    return hs.Model(text[:at] + NOISE + text[at:])


PYTHON = ("fossen-python", "python-vehicle-simulator", "mujoco", "linear-python", "kalman-python")


@pytest.mark.parametrize("target", PYTHON)
def test_python_compiles_and_has_no_statement_of_the_name(target: str, hostile: hs.Model) -> None:
    text = hs.export(hostile, target, inertia=None if "-python" in target and target != PYTHON[0] else INERTIA).text
    tree = ast.parse(text)
    plain = (ast.Assign, ast.Import, ast.ImportFrom, ast.FunctionDef, ast.ClassDef)
    assert isinstance(tree.body[0], ast.Expr)
    assert all(isinstance(node, plain) for node in tree.body[1:])
    calls = [node.func.id for node in ast.walk(tree) if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)]
    assert "system" not in calls
    names: dict[str, object] = {}
    exec(compile(text, "vehicle", "exec"), names)
    if target == "python-vehicle-simulator":
        made = names["identified"]
        assert callable(made)
        assert "system('echo code')" in made().name
        assert "{longest}" in made().name


def test_mujoco_takes_the_model_of_a_hostile_name(hostile: hs.Model) -> None:
    mujoco = pytest.importorskip("mujoco")
    names: dict[str, str] = {}
    exec(hs.export(hostile, "mujoco", inertia=INERTIA, link=HOSTILE).text, names)
    assert mujoco.MjModel.from_xml_string(names["MJCF"]).nbody == 2


def test_c_compiles_with_a_hostile_name(hostile: hs.Model, tmp_path: Path) -> None:
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("there is no C compiler `cc`: the header was not compiled")
    (tmp_path / "vehicle.h").write_text(hs.export(hostile, "c-header", inertia=INERTIA).text, encoding="utf-8")
    (tmp_path / "main.c").write_text(
        '#include "vehicle.h"\nint main(void)\n{\n    return (int)hydrosysid_eta_adv[0];\n}\n'
    )
    strict = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-Wno-unused-function"]
    subprocess.run([compiler, *strict, "main.c", "-o", "main", "-lm"], cwd=tmp_path, check=True)
    assert subprocess.run([tmp_path / "main"], check=False).returncode == 0


def test_octave_runs_a_function_of_a_hostile_name(hostile: hs.Model, tmp_path: Path) -> None:
    octave = shutil.which("octave-cli") or shutil.which("octave")
    if octave is None:
        pytest.skip("GNU Octave is not installed: the MATLAB function was not run")
    (tmp_path / "hydrosysid_vehicle.m").write_text(
        hs.export(hostile, "fossen-matlab", inertia=INERTIA).text, encoding="utf-8"
    )
    rate = "vehicle.nu_dot(zeros(6, 1), ones(6, 1), ones(6, 1))"
    script = f"vehicle = hydrosysid_vehicle(); printf('%d', all(isfinite({rate})));"
    run = [octave, "--no-gui", "--norc", "--quiet", "--eval", script]
    done = subprocess.run(
        run,
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
        timeout=300,
        env={**os.environ, "LC_ALL": "C.UTF-8"},
    )
    assert done.stdout == "1"


def test_names_of_channels_are_no_formulas_in_a_log(tmp_path: Path) -> None:
    run = hs.Run(t=[0.0, 1.0], u=[0.1, 0.2], **{"=cmd|' /C calc'!A0": [1.0, -2.0]})
    run.to_csv(tmp_path / "log.csv")
    header = (tmp_path / "log.csv").read_text().splitlines()[0]
    assert header.split(",")[1] == "'=cmd|' /C calc'!A0"
    back = hs.Run.from_csv(tmp_path / "log.csv")
    assert back["=cmd|' /C calc'!A0"][1].tolist() == [1.0, -2.0]
