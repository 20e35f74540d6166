"""Stages of the family ``policy``: networks that were trained elsewhere."""

from __future__ import annotations

from graphnav import Stage, hookimpl


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    """Return the stages of the family ``policy``."""
    from graphnav_policy.onnx_policy import Onnx

    return [Onnx]
