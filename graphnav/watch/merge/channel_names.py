"""The channels of several logs in one: which get another name, and what the descriptions of their runs then say."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace

from graphnav import About, UserError
from graphnav.core.codec import DecodeError, decode, encode
from graphnav.core.graph import RESERVED
from graphnav.core.spec import outline_of
from graphnav.watch.merge.shared_messages import LogMessages


def taken_names(log: LogMessages, names: Mapping[str, str]) -> Iterator[str]:
    """Yield the channels that a log and its runs have in the merged log, those without a message as well."""
    yield from (names.get(channel, channel) for channel in log.channels)
    for about in log.abouts():
        yield from (names.get(channel, channel) for channel in about.channels)


def renamed_channels(
    log: LogMessages, prefix: str, taken: Collection[str], same: Collection[str] = ()
) -> dict[str, str]:
    """Return the new names of a later log's channels whose names are taken, and of what runs say of themselves.

    ``same``: channels whose messages go on the channel of that name.
    """
    found: dict[str, str] = {}
    for channel in dict.fromkeys((*log.channels, *(name for about in log.abouts() for name in about.channels))):
        if channel == About.CHANNEL or channel in same:
            continue
        name = channel
        if name.startswith(RESERVED) or name in taken:
            name = f"{prefix}.{channel}"
            while name in taken:
                name = f"{prefix}.{name}"
        if name != channel:
            found[channel] = name
    return found


def described(data: bytes, run_id: str, names: Mapping[str, str]) -> bytes:
    """Return a description of a run with its id, where it has none, and with the new names of its channels.

    Viewers find the channels of its graph by ``channels`` there; a graph that cannot say it is left out.
    """
    try:
        utime, seq, about = decode(About, data)
    except DecodeError:
        return data
    if not about.channels and not about.graph_yaml:
        return data  # definitions of types only
    channels = tuple(names.get(channel, channel) for channel in about.channels)
    graph_yaml = _renamed_graph(about.graph_yaml, {old: new for old, new in names.items() if old in about.channels})
    return encode(replace(about, run_id=about.run_id or run_id, channels=channels, graph_yaml=graph_yaml), utime, seq)


def run_of(data: bytes) -> str:
    """Return the run that a description tells of, an empty string for none."""
    try:
        return decode(About, data)[2].run_id
    except DecodeError:
        return ""


def _renamed_graph(graph_yaml: str, names: Mapping[str, str]) -> str:
    """Return a graph whose channels have new names, an empty string if it cannot be written so."""
    names = {old: new for old, new in names.items() if not old.startswith(RESERVED)}
    if not names:
        return graph_yaml
    lines = "".join(f'\n  "{old}": "{new}"' for old, new in names.items() if (old + new).isascii())
    written = f"{graph_yaml}\nchannels:{lines}\n"
    try:
        spec = outline_of(written.encode(), About.CHANNEL)
    except UserError:
        return ""
    is_told = all(old in spec.channels and spec.channels[old].value.data == new for old, new in names.items())
    return written if is_told else ""
