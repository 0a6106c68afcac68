"""A defect of the library is an ordinary exception, whichever door it comes through."""

import pytest
from hydrosysid import _native


@pytest.mark.parametrize("door", ["attended", "detached", "interruptible"])
def test_a_panic_is_an_ordinary_exception(door: str) -> None:
    with pytest.raises(Exception, match=r"defect of hydrosysid, please report it: asked for") as caught:
        _native.fail(door)
    assert type(caught.value) is RuntimeError
    # and the package goes on working
    assert _native.effects("").startswith("[")
