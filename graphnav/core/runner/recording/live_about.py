"""The `About` message of a live run."""

from __future__ import annotations

from dataclasses import replace

import graphnav_lcm

from graphnav.core.codec import lcm_name, lcm_text_of
from graphnav.core.graph import Graph
from graphnav.core.messages import About, Fired, Gap, Status
from graphnav.core.runner.recording.run_recorded import about_of


def live_about(graph: Graph, *, by_outside_names: bool) -> About:
    """Return the `About` message for the log or the tap of a live run.

    ``by_outside_names``: list inputs and outputs under their LCM channels and types, for viewers on the group on which
    other programs write and read them.
    """
    about = about_of(graph)
    channels = dict(zip(about.channels, about.types, strict=True))
    classes = [channel.message.lcm_class for channel in graph.channels.values()]
    if by_outside_names:
        for ref, target in graph.outputs.items():
            channels.pop(graph.channels[ref].name)
            channels[target.name] = target.type_name
            classes.append(target.lcm_class)
        for ref, source in graph.inputs.items():
            channels.pop(graph.channels[ref].name)
            if source.log is None:
                channels[source.name] = source.type_name
                classes.append(source.lcm_class)
    channels[Status.CHANNEL] = lcm_name(graphnav_lcm.status_t)
    classes.append(graphnav_lcm.status_t)
    if not by_outside_names:
        channels |= {Fired.CHANNEL: lcm_name(graphnav_lcm.fired_t), Gap.CHANNEL: lcm_name(graphnav_lcm.gap_t)}
        classes += [graphnav_lcm.fired_t, graphnav_lcm.gap_t]
    ordered = sorted(channels.items())
    return replace(
        about,
        lcm_text=lcm_text_of(classes),
        channels=tuple(name for name, _ in ordered),
        types=tuple(kind for _, kind in ordered),
    )
