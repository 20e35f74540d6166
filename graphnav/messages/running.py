"""What a run says of itself, on the reserved channel ``graphnav.about``."""

from __future__ import annotations

import graphnav_lcm

from graphnav.messages.message import Message


class About(Message, lcm=graphnav_lcm.about_t):
    """What a log or a live run holds: the resolved graph, the types' text, the type of each channel.

    ``types``: ``package.type_t`` for each of ``channels``. ``run_id`` is empty in a log.
    """

    graph_yaml: str
    lcm_text: str
    run_id: str
    seed: int
    channels: tuple[str, ...]
    types: tuple[str, ...]
