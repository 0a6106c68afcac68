"""How ROS messages are decoded: by the definition that a log holds, one that the user teaches, or one that is known.

A ``.msg`` file that is taught is named by its path, ``lab_msgs/msg/Depth.msg``; outside such a folder it stands for the
type of its name in any package.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path, PurePosixPath
from typing import Any

from .._errors import DataError, UsageError
from .extras import needed
from .ros_definitions import DEFINITIONS

RELEASES = {"cdr": ("LATEST", "ROS2_HUMBLE", "ROS2_FOXY"), "ros1": ("ROS1_NOETIC",)}
"""Releases of ROS whose own messages are known, by encoding; a layout that changed is found by trying them in turn."""
Decode = Callable[[bytes], Any]


class RosTypes:
    """Definitions of messages: held by the log, taught by the user, known beforehand.

    Args:
        taught: ``.msg`` files, or folders of such.

    Raises:
        UsageError: a file that is not there.
    """

    def __init__(self, taught: Sequence[str | Path] = ()) -> None:
        self._typesys = needed("rosbags.typesys", "ros", "ROS messages")
        self._taught = _taught(taught)

    def decoder(self, name: str, held: str = "", idl: bool = False, encoding: str = "cdr") -> Decode:
        """How messages of a type are decoded; the layout is chosen by the first of them.

        Args:
            name: the type, ``package/msg/Type``.
            held: the definition in the log; empty where it has none.
            idl: whether `held` is IDL.
            encoding: ``cdr``, or ``ros1``.
        """
        chosen: list[Decode] = []

        def decode(raw: bytes) -> Any:
            if chosen:
                try:
                    return chosen[0](raw)
                except Exception as error:
                    raise DataError(f"{name}: {type(error).__name__} {error}") from None
            first: Exception | None = None
            for layout in self._layouts(name, held, idl, encoding):
                try:
                    candidate: Decode = layout()
                    message = candidate(raw)
                except Exception as error:  # the library raises errors of many kinds for bytes of another layout
                    first = first or error
                else:
                    chosen.append(candidate)
                    return message
            if first is None:
                text = f"{name}: the log lacks its definition; provide it with --msg {PurePosixPath(name).name}.msg"
                raise DataError(text)
            raise first if isinstance(first, DataError) else DataError(f"{name}: {type(first).__name__} {first}")

        return decode

    def _layouts(self, name: str, held: str, idl: bool, encoding: str) -> Iterator[Callable[[], Decode]]:
        """The layouts that a type may have, best known first, each made when it is tried."""

        def by(store: Any) -> Decode:
            read = store.deserialize_cdr if encoding == "cdr" else store.deserialize_ros1
            return lambda raw: read(raw, name)

        if held:
            yield lambda: by(self._held(name, held, idl))
        for text in self._texts(name):
            yield lambda text=text: by(self._with_parts(name, text, encoding))  # type: ignore[misc]
        for release in RELEASES[encoding]:
            store = _release(release)
            if name in store.fielddefs:
                yield lambda store=store: by(store)  # type: ignore[misc]

    def _held(self, name: str, definition: str, idl: bool) -> Any:
        store = self._typesys.get_typestore(self._typesys.Stores.EMPTY)
        if idl:
            rule = "=" * 80 + "\n"
            parts = definition.split(rule)[1:] if definition.startswith(f"{rule}IDL: ") else [f"\n{definition}"]
            for part in parts:
                store.register(self._typesys.get_types_from_idl(part.partition("\n")[2]))
        else:
            store.register(self._typesys.get_types_from_msg(definition, name))
        return store

    def _with_parts(self, name: str, text: str, encoding: str) -> Any:
        """A release of ROS with this type and the types that it is made of."""
        release = RELEASES[encoding][0]
        store = self._typesys.get_typestore(getattr(self._typesys.Stores, release))
        types = dict(self._parsed(name, text))
        wanted = [part for fields in types.values() for part in _named(fields)]
        while wanted:
            part = wanted.pop()
            if part in types or part in store.fielddefs:
                continue
            texts = self._texts(part)
            if not texts:
                raise DataError(f"{name} is made of {part}, which is not known: provide it with --msg, too")
            parsed = self._parsed(part, texts[0])
            types |= parsed
            wanted += [deeper for fields in parsed.values() for deeper in _named(fields)]
        for known in [known for known in types if known in store.fielddefs]:
            del store.fielddefs[known]  # what is taught is another layout of a type of this release
        store.register(types)
        return store

    def _texts(self, name: str) -> list[str]:
        """The definitions of a type that are taught, then those that are known."""
        path = PurePosixPath(name)
        return [*(self._taught[key] for key in (name, path.name) if key in self._taught), *DEFINITIONS.get(name, ())]

    def _parsed(self, name: str, text: str) -> dict[str, Any]:
        try:
            return dict(self._typesys.get_types_from_msg(text, name))
        except Exception as error:
            raise DataError(f"the definition of {name} cannot be read: {error}") from None


def full_name(name: str) -> str:
    """``package/msg/Type`` from that, or from the ``package/Type`` of ROS 1, or from ``package.Type``.

    >>> full_name("sensor_msgs/Imu"), full_name("sensor_msgs.Imu"), full_name("a/srv/B_Event")
    ('sensor_msgs/msg/Imu', 'sensor_msgs/msg/Imu', 'a/srv/B_Event')
    """
    if "/" not in name:
        name = name.replace(".", "/", 1)
    package, _, kind = name.rpartition("/")
    return f"{package if '/' in package else package + '/msg'}/{kind}"


@functools.cache
def _release(name: str) -> Any:
    typesys = needed("rosbags.typesys", "ros", "ROS messages")
    return typesys.get_typestore(getattr(typesys.Stores, name))


def _taught(files: Iterable[str | Path]) -> dict[str, str]:
    """Definitions by type, or by the name of the file where its folder names no package."""
    found: dict[str, str] = {}
    for given in map(Path, files):
        if not given.exists():
            raise UsageError(f"{given}: there is no such message definition (.msg)")
        for path in sorted(given.rglob("*.msg")) if given.is_dir() else [given]:
            *_, package, folder, _ = ("", "", *path.resolve().parts)
            try:
                found[f"{package}/msg/{path.stem}" if folder == "msg" else path.stem] = path.read_text(encoding="utf-8")
            except (OSError, UnicodeDecodeError) as error:
                raise UsageError(f"{path}: {error}") from None
    return found


def _named(fields: Any) -> Iterator[str]:
    """Names of the types in a parsed definition."""
    if isinstance(fields, str):
        if fields.count("/") == 2:
            yield fields
    elif isinstance(fields, tuple | list):
        for part in fields:
            yield from _named(part)
