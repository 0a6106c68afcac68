"""The first bytes of a file, by which its format is known."""

from pathlib import Path


def first_bytes(path: Path, length: int) -> bytes:
    """At most this many bytes; none of what is no file."""
    if not path.is_file():
        return b""
    with path.open("rb") as file:
        return file.read(length)
