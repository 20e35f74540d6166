"""The flow among the outputs of an estimator."""

from __future__ import annotations

from typing import Any

from graphnav import Image, Stamp


def flow_from(stage: Any, image: Image, stamp: Stamp) -> Any:
    """Return the flow that ``stage`` makes of an image, None if it makes none."""
    made = stage.step(image, stamp)
    return getattr(made, "flow", made)
