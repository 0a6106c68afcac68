"""Progress of long verbs: handed to a function, or shown as a bar."""

from __future__ import annotations

import importlib
import importlib.util
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

Listener = Callable[[str, int, int], object]
"""Called as ``progress(what, done, of)``: the task, how many parts of it are done, and of how many; 0 parts if
unknown. An exception in it ends the work, and propagates."""
Progress = Listener | bool | None


@contextmanager
def listener(progress: Progress) -> Iterator[Listener | None]:
    """The function that hears of progress: the one given; for `True` a bar of tqdm, a line where there is no tqdm."""
    if progress is None or progress is False:
        yield None
        return
    if progress is not True:
        yield progress
        return
    with _bar() if importlib.util.find_spec("tqdm") is not None else _line() as show:
        yield show


@contextmanager
def _bar() -> Iterator[Listener]:
    tqdm: Any = importlib.import_module("tqdm.auto").tqdm
    with tqdm(total=0, leave=False) as bar:

        def show(what: str, done: int, of: int) -> None:
            if bar.desc != what or bar.total != of:
                bar.reset(total=of)
                bar.set_description_str(what)
            bar.update(max(0, done - bar.n))
            bar.refresh()

        yield show


REFRESH = 0.1
"""Seconds between two states of the line."""


@contextmanager
def _line() -> Iterator[Listener]:
    """One line on standard error, written anew in its place: ``fitting campaigns 12 of 200 (6 %)``."""
    shown, width, at = "", 0, -REFRESH

    def show(what: str, done: int, of: int) -> None:
        nonlocal shown, width, at
        now = time.monotonic()
        # what begins and what is done is always told
        if what == shown and done < of and now - at < REFRESH:
            return
        shown, at = what, now
        count = f" {done} of {of} ({100 * done // of} %)" if of else f" {done}" if done else ""
        text = f"{what}{count}"
        print(f"\r{text.ljust(width)}", end="", file=sys.stderr, flush=True)
        width = len(text)

    try:
        yield show
    finally:
        print(f"\r{' ' * width}\r", end="", file=sys.stderr, flush=True)
