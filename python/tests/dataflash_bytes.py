"""DataFlash logs written byte by byte: messages A3 95, type, payload; FMT first, instances by FMTU."""

import struct
from collections.abc import Mapping, Sequence

HEAD = b"\xa3\x95"
CODES = {"B": "B", "b": "b", "H": "H", "Q": "Q", "f": "f", "M": "B", "n": "4s", "N": "16s", "Z": "64s"}
OWN = {
    "FMT": (128, "BBnNZ", "Type,Length,Name,Format,Columns"),
    "UNIT": (129, "QbZ", "TimeUS,Id,Label"),
    "FMTU": (130, "QBNN", "TimeUS,FmtType,UnitIds,MultIds"),
    "PARM": (131, "QNff", "TimeUS,Name,Value,Default"),
    "MODE": (132, "QMBB", "TimeUS,Mode,ModeNum,Rsn"),
}


class Dataflash:
    """A log with these messages: name to format and columns; a column ``I`` is the instance.

    Args:
        messages: beside parameters and modes.
        parameters: of the vehicle.
    """

    def __init__(self, messages: Mapping[str, tuple[str, str]], parameters: Mapping[str, float]) -> None:
        numbered = {name: (140 + k, *about) for k, (name, about) in enumerate(messages.items())}
        self.formats = OWN | numbered
        self.data = b""
        for name, (number, form, columns) in self.formats.items():
            size = 3 + struct.calcsize("<" + "".join(CODES[c] for c in form))
            self.add("FMT", number, size, name, form, columns)
        self.add("UNIT", 0, ord("#"), "instance")
        for number, _, columns in numbered.values():
            names = columns.split(",")
            if "I" in names:
                units = "".join("#" if name == "I" else "-" for name in names)
                self.add("FMTU", 0, number, units, "-" * len(names))
        for key, value in parameters.items():
            self.add("PARM", 1_000_000, key, float(value), 0.0)

    def add(self, name: str, *values: object) -> None:
        """Writes a message."""
        number, form, _ = self.formats[name]
        raw = [v.encode() if isinstance(v, str) else v for v in values]
        self.data += HEAD + bytes([number]) + struct.pack("<" + "".join(CODES[c] for c in form), *raw)


def motors(outputs: Sequence[int], directions: Sequence[int], frame: int) -> dict[str, float]:
    """Parameters of ArduSub: motor k at output ``outputs[k]``, turning as ``directions[k]`` says."""
    found: dict[str, float] = {"FRAME_CONFIG": frame, "MOT_PWM_MIN": 1100, "MOT_PWM_MAX": 1900}
    for k, (output, direction) in enumerate(zip(outputs, directions, strict=True)):
        found[f"MOT_{k + 1}_DIRECTION"] = direction
        found[f"SERVO{output}_FUNCTION"] = 33 + k
        found[f"SERVO{output}_TRIM"] = 1500
    return found
