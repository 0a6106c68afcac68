"""Examples in docstrings run, and every public name has one."""

import doctest
import importlib
import pkgutil

import hydrosysid as hs
import pytest

MODULES = [m.name for m in pkgutil.iter_modules(hs.__path__) if m.name not in ("__main__", "_native")]


@pytest.mark.parametrize("name", MODULES)
def test_examples(name: str) -> None:
    assert doctest.testmod(importlib.import_module(f"hydrosysid.{name}")).failed == 0


def test_public_names_are_documented() -> None:
    assert [name for name in hs.__all__ if not name.startswith("__") and not getattr(hs, name).__doc__] == []
