"""Why there is nothing to see of a channel, or of a whole feed."""

from __future__ import annotations

from graphnav.bus import RECEIVE_BUFFER_BYTES
from graphnav.spy.traffic import ChannelTraffic
from graphnav.spy.traffic_report import size_of
from graphnav.tap import PACKET_BYTES

_DOCTOR = "'graphnav doctor' says what this machine grants"


def nothing_received(feed: str, for_s: float) -> str:
    """Return why a live feed without any message is empty."""
    return (
        f"no publisher: nothing was received on {feed} for {for_s:.0f} s\n"
        "start a run that can be watched: graphnav run GRAPH --pace 1"
    )


def why_empty(channel: ChannelTraffic, for_s: float) -> str:
    """Return why a channel that was announced or received shows nothing new; empty where its newest message can be seen.

    ``for_s``: how long the feed has been listened to.
    """
    if not channel.count:
        return (
            f"announced, and not received for {for_s:.0f} s: nothing was published yet, or fragments were lost\n"
            f"messages above one packet need a receive buffer of {RECEIVE_BUFFER_BYTES} bytes: {_DOCTOR}"
        )
    if not channel.decodes:
        if channel.is_unknown:
            return (
                f"unknown fingerprint {channel.fingerprint.hex()}: no installed type has it\n"
                "install the package that lcm-gen made of it, or name it: --types PACKAGE_OR_DIR"
            )
        return f"the newest message of {size_of(channel.last_bytes)} is not a complete {channel.type_name}"
    if channel.is_silent:
        return f"stale for {channel.silent_s or 0.0:.0f} s: this is the last message"
    return ""


def losses(channel: ChannelTraffic) -> str:
    """Return what is missing of a channel and why, in a line; empty where nothing is."""
    said = []
    if channel.lost:
        cause = f"fragments lost, {_DOCTOR}" if channel.last_bytes > PACKET_BYTES else "gaps in seq"
        said.append(f"{channel.lost} lost ({cause})")
    if channel.undecodable:
        said.append(f"{channel.undecodable} undecodable")
    return ", ".join(said)
