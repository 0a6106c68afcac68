"""Progress of long verbs: handed to a function, or shown as a bar."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from ._formats.extras import needed

Listener = Callable[[str, int, int], object]
"""Is called as ``progress(what, done, of)``: what begins, how many parts of it are done, and of how many; 0 parts where
nobody can know. What it raises ends the work, and passes through."""
Progress = Listener | bool | None


@contextmanager
def listener(progress: Progress) -> Iterator[Listener | None]:
    """The function that hears of progress: the one given; for `True` a bar of tqdm, in notebooks too."""
    if progress is None or progress is False:
        yield None
        return
    if progress is not True:
        yield progress
        return
    tqdm: Any = needed("tqdm.auto", "progress", "progress bars").tqdm
    with tqdm(total=0, leave=False) as bar:

        def show(what: str, done: int, of: int) -> None:
            if bar.desc != f"{what}: " or bar.total != of:
                bar.reset(total=of)
                bar.set_description(what)
            bar.update(max(0, done - bar.n))
            bar.refresh()

        yield show
