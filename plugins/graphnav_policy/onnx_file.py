"""Read the header of an ONNX file, without running anything: versions, and whether weights are in other files.

ONNX is a message of protobuf [https://onnx.ai/onnx/repo-docs/IR.html]; only the fields that are asked for are read.
"""

from __future__ import annotations

from typing import NamedTuple

_INNER = {
    "model": {7: "graph", 20: "training", 25: "function"},
    "graph": {1: "node", 5: "tensor", 15: "sparse"},
    "node": {5: "attribute"},
    "attribute": {5: "tensor", 6: "graph", 10: "tensor", 11: "graph", 22: "sparse", 23: "sparse"},
    "sparse": {1: "tensor", 2: "tensor"},
    "function": {7: "node", 11: "attribute"},
    "training": {1: "graph", 2: "graph"},
}
"""The messages in which tensors may be, by the number of their field."""
_VARINT, _FIXED_64, _BYTES, _FIXED_32 = 0, 1, 2, 5
_FIXED = {_FIXED_64: 8, _FIXED_32: 4}
_MAX_FIELDS = 2_000_000


class OnnxHeader(NamedTuple):
    """Version of the format, version of the set of operators, and whether tensors are kept in other files."""

    ir_version: int
    opset: int
    has_external_data: bool


def read_header(data: bytes) -> OnnxHeader:
    """Return the header of the file with these bytes.

    Raises
    ------
    ValueError
        They are not protobuf, or more than two million fields.
    """
    ir_version = opset = n_fields = 0
    is_external = False
    waiting = [("model", 0, len(data))]
    while waiting:
        kind, at, end = waiting.pop()
        while at < end:
            n_fields += 1
            if n_fields > _MAX_FIELDS:
                raise ValueError("too many fields")
            number, wire, value, begin, at = _field(data, at, end)
            if kind == "tensor":
                is_external |= number == 13 or (number == 14 and value != 0)
            elif wire == _BYTES and number in _INNER.get(kind, {}):
                waiting.append((_INNER[kind][number], begin, at))
            elif kind == "model" and number == 1:
                ir_version = value
            elif kind == "model" and number == 8 and wire == _BYTES:
                opset = opset or _opset(data, begin, at)
    return OnnxHeader(ir_version, opset, is_external)


def _opset(data: bytes, at: int, end: int) -> int:
    """Return the version of an ``OperatorSetIdProto`` of ONNX's own operators, 0 for those of another domain."""
    version, is_own = 0, True
    while at < end:
        number, _, value, begin, at = _field(data, at, end)
        if number == 1:
            is_own = data[begin:at] in (b"", b"ai.onnx")
        elif number == 2:
            version = value
    return version if is_own else 0


def _field(data: bytes, at: int, end: int) -> tuple[int, int, int, int, int]:
    """Return a field's number, kind of encoding and integer, and where its content begins and ends."""
    key, at = _varint(data, at, end)
    number, wire = key >> 3, key & 7
    value, begin = 0, at
    if wire == _VARINT:
        value, at = _varint(data, at, end)
    elif wire == _BYTES:
        length, begin = _varint(data, at, end)
        at = begin + length
    elif wire in _FIXED:
        at += _FIXED[wire]
    else:
        raise ValueError("an unknown kind of field")
    if at > end or number == 0:
        raise ValueError("a truncated field")
    return number, wire, value, begin, at


def _varint(data: bytes, at: int, end: int) -> tuple[int, int]:
    value = 0
    for shift in range(0, 70, 7):
        if at >= end:
            break
        byte = data[at]
        at += 1
        value |= (byte & 0x7F) << shift
        if byte < 0x80:
            return value, at
    raise ValueError("a truncated integer")
