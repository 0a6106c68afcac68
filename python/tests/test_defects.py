"""A defect of the library is an ordinary exception, whichever door it comes through."""

import os

import pytest
from hydrosysid import _native

# a stub that tells of it would tell users
fail = getattr(_native, "fail", None)


@pytest.mark.parametrize("door", ["attended", "detached", "interruptible"])
def test_a_panic_is_an_ordinary_exception(door: str) -> None:
    if fail is None and not os.environ.get("CI"):
        pytest.skip("this wheel has no panic on demand: `make test-python` builds one with the feature `panics`")
    assert fail is not None
    with pytest.raises(Exception, match=r"internal error of hydrosysid, please report it: asked for") as caught:
        fail(door)
    assert type(caught.value) is RuntimeError
    # and the package goes on working
    assert _native.effects("").startswith("[")
