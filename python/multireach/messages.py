"""The LCM messages of multireach, one class for each .lcm file: `messages.target_t(position_m=[0.1, -0.1, 0.1], name="ball")`.

Fields that are not given are zero, empty or false. Numbers in arrays are NumPy arrays in messages that were received, and
anything that NumPy converts in messages that are sent. Constants are attributes of the class: `target_t.STATUS_TRACKED`.
"""
import re as _re

import numpy as _numpy

from . import _core

_NUMBERS = {"boolean": bool, "byte": _numpy.uint8, "int8_t": _numpy.int8, "int16_t": _numpy.int16, "int32_t": _numpy.int32,
            "int64_t": _numpy.int64, "float": _numpy.float32, "double": _numpy.float64}


class Message:
    """A message; `fields` names its fields in order."""

    __slots__ = ()
    fields = ()

    def __init__(self, **values):
        for name, kind, dimensions in type(self)._definition:
            setattr(self, name, values.pop(name) if name in values else _default(kind, dimensions))
        for name in values:
            raise TypeError(f"{type(self).__name__} has no field '{name}'; expected one of {', '.join(self.fields)}")

    def __repr__(self):
        return f"{type(self).__name__}({', '.join(f'{name}={getattr(self, name)!r}' for name in self.fields)})"

    def __eq__(self, other):
        return type(self) is type(other) and _core.encode(self) == _core.encode(other)

    __hash__ = None


def _default(kind, dimensions):
    sizes = [int(size) if size.isdigit() else 0 for size in dimensions]
    if kind in _NUMBERS:
        return _numpy.zeros(sizes, _NUMBERS[kind]) if sizes else _NUMBERS[kind](0).item() if kind != "boolean" else False
    if not sizes:
        return "" if kind == "string" else globals()[kind]()
    return [_default(kind, dimensions[1:]) for _ in range(sizes[0])]


def _define(text):
    """The class of the struct that an .lcm text defines: its fields, its constants, and its first comment as docstring."""
    name = _re.search(r"\bstruct\s+(\w+)", text)[1]
    definition = _core.message_fields(name)
    comment = _re.search(r"((?:^//.*\n)+)struct", text, _re.MULTILINE)
    attributes = {"__slots__": [field for field, _, _ in definition], "_definition": definition,
                  "fields": tuple(field for field, _, _ in definition), "__module__": __name__,
                  "__doc__": _re.sub(r"^// ?", "", comment[1], flags=_re.MULTILINE) if comment else None}
    for kind, constants in _re.findall(r"^\s*const\s+(\w+)\s+([^;]*);", text, _re.MULTILINE):
        for constant in constants.split(","):
            key, _, value = constant.partition("=")
            attributes[key.strip()] = float(value) if kind in ("float", "double") else int(value, 0)
    _core.message_classes[name] = globals()[name] = type(name, (Message,), attributes)


for _text in _core.message_texts:
    _define(_text)

__all__ = ["Message", *sorted(_core.message_classes)]
