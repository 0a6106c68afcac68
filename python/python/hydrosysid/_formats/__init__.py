"""Logs in other formats, one file a format, each by the library that is kept for it.

A format becomes a `Source`: streams of samples, each stream with its own time stamps. A `ColumnMap` says which field of
which stream is which channel, and what unit, sign and axes it is written in; `run_of` puts the two together.
"""

from .column_map import ColumnMap
from .make import run_of
from .open import format_of, is_known, open_source
from .source import Source, Stream

__all__ = ["ColumnMap", "Source", "Stream", "format_of", "is_known", "open_source", "run_of"]
