"""PX4 ULog files, by `pyulog`.

A stream is a topic with its instance, ``vehicle_local_position[0]``; where there is one instance its number may be left
out. Time is that since the autopilot began.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from .._errors import DataError, UsageError
from .extras import needed
from .source import Source, Stream


def open_ulog(path: Path) -> Source:
    """A ULog file as a source.

    Raises:
        DataError: it is no ULog file.
    """
    library = needed("pyulog", "px4", "ULog files")
    if not path.exists():
        raise UsageError(f"{path}: there is no such log")
    try:
        with path.open("rb") as file:
            log = library.ULog(file)
    except Exception as error:  # the library raises errors of many kinds for files that are none of its own
        raise DataError(f"{path}: this ULog file cannot be read: {error}") from None
    topics = {f"{topic.name}[{topic.multi_id}]": topic.data for topic in log.data_list}
    for topic in log.data_list:
        if sum(other.name == topic.name for other in log.data_list) == 1:
            topics[topic.name] = topic.data

    def read(wanted: Mapping[str, frozenset[str]]) -> Mapping[str, Stream]:
        return {
            name: Stream(
                topics[name]["timestamp"].astype(np.int64),
                1e6,
                {field: topics[name][field].astype(np.float64) for field in fields},
                "time since the autopilot began",
            )
            for name, fields in wanted.items()
        }

    contents = {name: tuple(f for f in data if f != "timestamp") for name, data in topics.items()}
    return Source(str(path), contents, read)
