"""Summarise the fields of a message: arrays by shape, range and mean."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np

from graphnav.core.codec import fields_of
from graphnav.core.errors import printable

_LONGEST_TEXT = 60
_FEW = 4
"""Arrays up to this length, such as forces and poses, are shown in full."""


def summarised(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return a summary of a message's fields.

    An array becomes its type, shape, minimum, mean and maximum, and its values if they are few; masks of valid cells
    also their ratio of ones, floats that are not all finite their ratio of finite values. Long strings are cut. NaN and
    infinities are kept: `plain` converts the summary to JSON-compatible values.
    """
    return {name: _summary(name, value) for name, value in values.items()}


def declared(lcm_class: type) -> dict[str, Any]:
    """Return the declared types of the fields of a message that was not received yet."""
    return {
        field.name: {"type": field.primitive + "".join(f"[{dim}]" for dim in field.dims)}
        for field in fields_of(lcm_class)
    }


def described(summary: Mapping[str, Any], indent: str = "    ") -> list[str]:
    """Return `summarised` fields as lines of text."""
    width = max((len(name) for name in summary), default=0)
    lines = []
    for name, value in summary.items():
        if isinstance(value, dict) and not {"shape", "type"} & value.keys():
            lines += [f"{indent}{name}", *described(value, indent + "    ")]
        else:
            lines.append(f"{indent}{name:<{width}}  {_text(value)}")
    return lines


def value_text(name: str, value: Any) -> str:
    """Return one field as text: an array by shape, range and mean, a long string cut."""
    return _text(_summary(name, value))


def _summary(name: str, value: Any) -> Any:
    if isinstance(value, np.ndarray) and value.dtype != object:
        return _array(name, value)
    if isinstance(value, np.ndarray | tuple):
        shape = list(value.shape) if isinstance(value, np.ndarray) else [len(value)]
        texts = len(value) > 0 and isinstance(np.asarray(value, object).flat[0], str)
        return {"dtype": "string" if texts else "struct", "shape": shape}
    if isinstance(value, dict):
        return summarised(value)
    if isinstance(value, str) and len(value) > _LONGEST_TEXT:
        return f"{value[:_LONGEST_TEXT]}... ({len(value)} characters)"
    return value


def _array(name: str, value: np.ndarray[Any, Any]) -> dict[str, Any]:
    summary: dict[str, Any] = {"dtype": str(value.dtype), "shape": list(value.shape)}
    if not value.size:
        return summary
    if value.ndim == 1 and value.size <= _FEW:
        summary["values"] = [float(number) for number in value]
    finite = np.isfinite(value)
    share = float(finite.mean())
    if share < 1:
        summary["finite_ratio"] = share
        value = value[finite]
    if value.size:
        smallest, largest = value.min().item(), value.max().item()
        summary |= {"min": smallest, "mean": float(value.mean(dtype=np.float64)), "max": largest}
    if name == "valid" or name.endswith("_valid"):
        summary["valid_ratio"] = float(np.count_nonzero(value)) / value.size
    return summary


def _text(value: Any) -> str:
    if isinstance(value, str):
        return printable(json.dumps(value, ensure_ascii=False))
    if isinstance(value, float):
        return f"{value:.6g}"
    if not isinstance(value, dict):
        return str(value)
    if "type" in value:
        return str(value["type"])
    shape = ", ".join(map(str, value["shape"]))
    parts = [f"{value['dtype']} ({shape})"]
    if "values" in value:
        return "[" + ", ".join(f"{number:.6g}" for number in value["values"]) + "]"
    if "min" in value and "valid_ratio" not in value:
        parts.append(f"{value['min']:.4g} to {value['max']:.4g}, mean {value['mean']:.4g}")
    if "valid_ratio" in value:
        parts.append(f"{100 * value['valid_ratio']:.1f} % valid")
    if "finite_ratio" in value:
        parts.append(f"{100 * value['finite_ratio']:.1f} % finite")
    return "  ".join(parts)
