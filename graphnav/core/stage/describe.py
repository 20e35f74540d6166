"""Describe a stage as plain data, derived from its declaration."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from graphnav.core.stage.metric import Metric, metrics_of
from graphnav.core.stage.param import Param, params_of
from graphnav.core.stage.port import Port, ports_of
from graphnav.core.stage.stage import Source, Stage
from graphnav.core.stage.units import unit_of


def describe(use: str, cls: type[Stage], origin: str) -> dict[str, Any]:
    """Return the ports, parameters and documentation of a stage as JSON data."""
    ports = ports_of(cls)
    return {
        "name": use,
        "kind": "source" if issubclass(cls, Source) else "stage",
        "origin": origin,
        "doc": inspect.getdoc(cls) or "",
        "inputs": [_port(port) for port in ports.inputs],
        "outputs": [_port(port) for port in ports.outputs],
        "ports_from": list(cls.ports_from),
        "parameters": [_param(param) for param in params_of(cls).values()],
        "metrics": [_metric(metric) for metric in metrics_of(cls).values()],
    }


def summary_of(cls: type[Stage]) -> str:
    """Return the first line of a stage's docstring."""
    return (inspect.getdoc(cls) or "").partition("\n")[0]


def plain_data(value: Any) -> Any:
    """Return a parameter's value as YAML and JSON data."""
    if isinstance(value, tuple):
        return [plain_data(item) for item in value]
    if isinstance(value, Mapping):
        return {key: plain_data(item) for key, item in value.items()}
    return str(value) if isinstance(value, Path) else value


def _port(port: Port) -> dict[str, Any]:
    return {
        "name": port.name,
        "type": port.message.__name__,
        "latest": port.latest,
        "since": port.since,
        "open": port.may_be_open,
    }


def _param(param: Param) -> dict[str, Any]:
    described: dict[str, Any] = {
        "name": param.name,
        "type": param.type_text,
        "unit": unit_of(param.name).words,
        "bounds": param.bounds_text,
        "required": param.required,
        "doc": param.doc,
    }
    if not param.required:
        described["default"] = plain_data(param.default)
    return described


def _metric(metric: Metric) -> dict[str, Any]:
    return {
        "name": metric.name,
        "unit": metric.unit,
        "better": metric.better,
        "if_failed": metric.if_failed,
        "outcome": metric.is_outcome,
        "min_difference": metric.min_difference,
        "doc": metric.help,
    }
