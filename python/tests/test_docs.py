"""Examples in docstrings run, and every public name has one."""

import doctest
import importlib
import importlib.util
import pkgutil
from pathlib import Path

import hydrosysid as hs
import pytest

MODULES = [m.name for m in pkgutil.iter_modules(hs.__path__) if m.name not in ("__main__", "_native")]


@pytest.mark.parametrize("name", MODULES)
def test_examples(name: str) -> None:
    assert doctest.testmod(importlib.import_module(f"hydrosysid.{name}")).failed == 0


def test_public_names_are_documented() -> None:
    assert [name for name in hs.__all__ if not name.startswith("__") and not getattr(hs, name).__doc__] == []


def test_the_reference_is_that_of_the_package() -> None:
    root = Path(__file__).resolve().parents[1]
    spec = importlib.util.spec_from_file_location("reference", root / "reference.py")
    assert spec is not None
    assert spec.loader is not None
    reference = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(reference)
    there = (root.parent / "docs" / "python.md").read_text(encoding="utf-8")
    assert there == reference.page(), "out of step: python reference.py ../docs/python.md"
    for name in hs.__all__:
        assert name.startswith("__") or f"### `{name}`" in there
