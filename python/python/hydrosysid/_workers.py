"""Work handed out: to a plain loop, to an executor, or to a cluster of Dask."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor, Future, as_completed
from functools import partial
from typing import Any, Protocol, TypeVar

from ._errors import UsageError
from ._progress import Progress, listener

T = TypeVar("T")
R = TypeVar("R")


class Cluster(Protocol):
    """What Dask's ``Client`` has of it that is used here."""

    def get_executor(self, **options: Any) -> Executor:
        """An executor on the workers of the cluster."""
        ...


Workers = Executor | Cluster


def mapped(
    work: Callable[[T], R], items: Sequence[T], workers: Workers | None, what: str, progress: Progress
) -> list[R]:
    """`work` of every item, in their order; `progress` hears of each when it is done. What an item raises ends all.

    Raises:
        UsageError: `workers` can do no work.
    """
    return [_or_raise(found) for found in _outcomes(work, items, workers, what, progress, keep=False)]


def mapped_or_failed(
    work: Callable[[T], R], items: Sequence[T], workers: Workers | None, what: str, progress: Progress
) -> list[R | Exception]:
    """As `mapped`, with what an item raises, or what ended or refused its worker, in its place."""
    return _outcomes(work, items, workers, what, progress, keep=True)


def _or_raise(found: R | Exception) -> R:
    if isinstance(found, Exception):
        raise found
    return found


def _outcomes(
    work: Callable[[T], R], items: Sequence[T], workers: Workers | None, what: str, progress: Progress, keep: bool
) -> list[R | Exception]:
    with listener(progress) as tell:

        def count(done: int) -> None:
            if tell is not None:
                tell(what, done, len(items))

        count(0)
        outcomes: list[R | Exception] = []
        if workers is None:
            for item in items:
                outcomes.append(_outcome(partial(work, item), keep))
                count(len(outcomes))
            return outcomes
        executor = _executor(workers)
        submitted: list[Future[R] | Exception] = []
        try:
            for item in items:
                # a pool of which a worker ended takes no more work
                submitted.append(_outcome(partial(executor.submit, work, item), keep))
            futures = [future for future in submitted if not isinstance(future, Exception)]
            refused = len(items) - len(futures)
            if refused:
                count(refused)
            for k, future in enumerate(as_completed(futures)):
                _outcome(future.result, keep)
                count(refused + k + 1)
            return [f if isinstance(f, Exception) else _outcome(f.result, keep) for f in submitted]
        except BaseException:
            for taken in submitted:
                if not isinstance(taken, Exception):
                    taken.cancel()
            raise


def _outcome(made: Callable[[], R], keep: bool) -> R | Exception:
    try:
        return made()
    except Exception as error:
        if not keep:
            raise
        return error


def _executor(workers: Any) -> Executor:
    if hasattr(workers, "get_executor"):
        # equal campaigns are different work
        executor: Executor = workers.get_executor(pure=False)
        return executor
    if not hasattr(workers, "submit"):
        text = "a concurrent.futures.Executor or a Dask Client is expected"
        raise UsageError(f"executor = {type(workers).__name__}: {text}")
    found: Executor = workers
    return found
