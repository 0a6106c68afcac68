"""Series for plotting tools: MCAP with JSON messages, as Foxglove and PlotJuggler read it."""

from __future__ import annotations

import io
import json
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from ._formats.extras import needed
from ._run import Run

Array = NDArray[np.float64]
KINDS = ("measured", "simulated", "residual", "std")


def mcap_of(series: Run) -> bytes:
    """An MCAP log of channels ``RUN/CHANNEL/KIND``.

    A topic ``/RUN/CHANNEL`` has the fields ``measured``, ``simulated``, ``residual`` and ``std``, SI; a field is absent
    where it is not known. Log time is the time of the run; where a run begins before 0 s, all are shifted by whole
    seconds, and the metadata record ``hydrosysid`` says by how many.
    """
    writing = needed("mcap.writer", "mcap", "MCAP files")
    topics: dict[str, dict[float, dict[str, float]]] = {}
    for name, (time, values) in series.signals.items():
        topic, _, kind = name.rpartition("/")
        rows = topics.setdefault(f"/{topic}", {})
        for t, x in zip(time.tolist(), values.tolist(), strict=True):
            rows.setdefault(t, {})[kind] = x
    begin = min((min(rows) for rows in topics.values()), default=0.0)
    shift = max(0, int(np.ceil(-begin)))
    sink = io.BytesIO()
    writer = writing.Writer(sink, compression=writing.CompressionType.NONE)
    writer.start(profile="", library="hydrosysid")
    writer.add_metadata("hydrosysid", {"time_shift_s": str(shift), "units": "SI"})
    numbers = {kind: {"type": "number"} for kind in KINDS}
    schema = json.dumps({"type": "object", "properties": {"t": {"type": "number"}} | numbers})
    of = writer.register_schema("hydrosysid.Series", "jsonschema", schema.encode())
    channels = {topic: writer.register_channel(topic, "json", of) for topic in topics}
    # in the order of time, as readers like it
    messages = [(t, topic, row) for topic, rows in topics.items() for t, row in rows.items()]
    for t, topic, row in sorted(messages, key=lambda m: (m[0], m[1])):
        at = round((t + shift) * 1e9)
        writer.add_message(channels[topic], at, json.dumps({"t": t} | row).encode(), at)
    writer.finish()
    return sink.getvalue()


def side_by_side(
    runs: Mapping[str, tuple[Array, Mapping[str, Array], Mapping[str, Array], Mapping[str, Array]]],
) -> Run:
    """Channels ``RUN/CHANNEL/KIND``, as ``--series`` writes them, from time, simulated, measured and std."""
    signals = {}
    for run, (time, simulated, measured, std) in runs.items():
        for channel, values in simulated.items():
            there = measured[channel]
            expected = std.get(channel, np.full_like(values, np.nan))
            for kind, series in zip(KINDS, (there, values, there - values, expected), strict=True):
                known = np.isfinite(series)
                if known.any():
                    signals[f"{run}/{channel}/{kind}"] = (time[known], series[known])
    return Run(signals, name="series")
