"""What the tests of the pages share: the browser, and programs built of the objects that the other tests have built."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest
from chromium import Page, find

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="session")
def built():
    """Builds a program, ``("bin", "hydrosysid")`` or an example, and says where it is.

    Of the whole workspace, as `make test` does: alone the package has other features, and builds everything anew.
    """

    def build(kind: str, name: str) -> Path:
        if shutil.which("cargo") is None:
            pytest.skip(f"no cargo to build {name}")
        subprocess.run(["cargo", "build", "--quiet", "--workspace", f"--{kind}", name], cwd=ROOT, check=True)
        folder = ROOT / "target" / "debug"
        return (folder / "examples" if kind == "example" else folder) / name

    return build


@pytest.fixture(scope="session")
def browser():
    program = find()
    if program is None:
        # a page that nobody has looked at is not tested
        assert os.environ.get("CI") != "true", "no Chromium on the path, and CI is set: install one (apt-get install chromium)"
        pytest.skip("no Chromium on the path")
    page = Page(program)
    yield page
    page.close()
