"""The patterns that all of the JSON Schema of graphs uses."""

from __future__ import annotations

from graphnav.core.spec.spec import STAGE_NAME

PORT = rf"^{STAGE_NAME.pattern}\.{STAGE_NAME.pattern}$"
"""``stage.port``"""
CHANNEL = r"^(?!graphnav\.)[!-~]{1,63}$"
"""An LCM channel."""
