# What the rest of graphnav takes of this folder, each imported on first use.

from .child import PACKET_BYTES

__all__ = ["PACKET_BYTES"]
