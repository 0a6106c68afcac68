"""Two works done in turn, so that what disturbs the machine disturbs both."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from statistics import median

from partner import Partner


@dataclass(frozen=True)
class Row:
    """A line of the table: medians of process CPU in seconds, and the median of the ratios of each pair."""

    work: str
    peer: str
    ours: float
    theirs: float
    ratio: float
    pairs: int
    goal: str
    note: str


def paired(
    partner: Partner, work: str, asked: str, peer: str, theirs: Callable[[], str], *, goal: str, pairs: int = 9
) -> Row:
    """Does our work `asked` and the peer's in turn; the first pair warms up and does not count."""
    ours_s, theirs_s, notes = [], [], ("", "")
    for _ in range(pairs + 1):
        answer = partner.ask(asked)
        begin = time.process_time()
        said = theirs()
        theirs_s.append(time.process_time() - begin)
        ours_s.append(answer["cpu"])
        notes = (answer["note"], said)
    ours_s, theirs_s = ours_s[1:], theirs_s[1:]
    ratio = median(b / a for a, b in zip(ours_s, theirs_s, strict=True))
    note = f"ours: {notes[0]}; theirs: {notes[1]}" if notes[1] else ""
    return Row(work, peer, median(ours_s), median(theirs_s), ratio, pairs, goal, note)
