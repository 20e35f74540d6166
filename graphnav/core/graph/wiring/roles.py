"""Roles: true data is for scores and oracles, and what a score publishes is for no stage."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from graphnav.core.graph.node import Channel
from graphnav.core.spec import StageSpec
from graphnav.core.stage import MAY_READ_TRUTH, Stage


class Refusal(NamedTuple):
    """Why a stage may not read a channel, and what to do."""

    what: str
    hint: str


def refusal(
    stage: StageSpec, port: str, channel: Channel, writer: str, classes: Mapping[str, type[Stage]]
) -> Refusal | None:
    """Return why an input port may not read a channel, None if it may.

    ``writer``: what writes the channel, as errors name it. ``classes``: of the known stages, by name.
    """
    cls = classes[stage.name]
    reader, kind = f"'{port}' of stage '{stage.name}' ({stage.use})", channel.message.__name__
    if is_of_score(channel, classes):
        return Refusal(
            f"{reader} reads {writer}, whose role is score: no stage may read a score",
            f'wire it to a stage that is not a score, or remove role = "score" from {classes[channel.stage].__name__}',
        )
    if channel.message.is_truth and cls.role not in MAY_READ_TRUTH:
        return Refusal(
            f"{reader} reads true data, but its role is {cls.role}: {writer} is {kind}",
            f'only scores and oracles may read it: write role = "score" in {cls.__name__} if it only measures, '
            'role = "oracle" if its outputs use the truth',
        )
    return None


def is_of_score(channel: Channel, classes: Mapping[str, type[Stage]]) -> bool:
    """Return whether a score publishes a channel."""
    return channel.stage in classes and classes[channel.stage].role == "score"
