"""Messages about a run, each on a reserved channel."""

from __future__ import annotations

from typing import Any, ClassVar

import graphnav_lcm

from graphnav.arrays import Doubles, Longs
from graphnav.core.messages.message import Message


class About(Message, lcm=graphnav_lcm.about_t):
    """The description of a log or live run: the resolved graph, the type definitions, the type of each channel.

    ``types``: ``package.type_t`` for each of ``channels``. ``run_id`` is empty in a log.
    """

    CHANNEL: ClassVar[str] = "graphnav.about"
    graph_yaml: str
    lcm_text: str
    run_id: str
    seed: int
    channels: tuple[str, ...]
    types: tuple[str, ...]


class Status(Message, lcm=graphnav_lcm.status_t):
    """The health of a run, once a second.

    ``behind_s``: how far the run is behind the wall clock. ``log_fault``: why messages are not recorded at present,
    empty if they are. ``stages``, ``inputs``, ``outputs``, ``edges``, ``processes``: one mapping each, with the fields
    of ``stage_status_t``, ``input_status_t``, ``output_status_t``, ``edge_status_t`` and ``process_status_t``.
    ``edges``: those on which messages were overtaken, of a run over several processes all; ``processes``: of such a
    run, its own first.
    """

    CHANNEL: ClassVar[str] = "graphnav.status"
    run_id: str
    graph: str
    live: bool
    wall_s: float
    run_s: float
    behind_s: float
    memory_mb: float
    tap_dropped: int
    log_dropped: int
    log_fault: str
    stages: tuple[dict[str, Any], ...]
    inputs: tuple[dict[str, Any], ...]
    outputs: tuple[dict[str, Any], ...]
    edges: tuple[dict[str, Any], ...]
    processes: tuple[dict[str, Any], ...] = ()


class Gap(Message, lcm=graphnav_lcm.gap_t):
    """A gap of a log, which begins at ``from_us`` and ends where this message is: the disk was full, or failed.

    ``n_messages`` are missing; ``reason``: why they could not be written.
    """

    CHANNEL: ClassVar[str] = "graphnav.gap"
    from_us: int
    n_messages: int
    reason: str


class Fired(Message, lcm=graphnav_lcm.fired_t):
    """A firing of a stage in a live run, recorded so that the log can be replayed.

    ``fired_us``: the time of the firing by the run's clock. ``age_s``: the age of the plain inputs. ``ports``,
    ``numbers``, ``stamps_us``, ``ages_s``, ``faults``: one entry for each message of the step and for every sampled
    input: the port, the index of the message on its channel (from 0; -1 for none yet), its timestamp, and for a
    sampled input its age and fault.
    """

    CHANNEL: ClassVar[str] = "graphnav.fired"
    fired_us: int
    stage: str
    age_s: float
    ports: tuple[str, ...]
    numbers: Longs
    stamps_us: Longs
    ages_s: Doubles
    faults: tuple[str, ...]


class Changed(Message, lcm=graphnav_lcm.changed_t):
    """A stage that was rebuilt while the run went on, with other parameters or as another ``use``.

    ``words``: what was asked for, as ``--set`` takes it. ``stage_yaml``: the stage with all parameters and wires, as a
    graph with this stage alone; its paths are absolute, unless they ship with graphnav. It counts from the message's
    timestamp on: of the first tick in lockstep, live the time by the run's clock.
    """

    CHANNEL: ClassVar[str] = "graphnav.changed"
    stage: str
    use: str
    words: tuple[str, ...]
    stage_yaml: str
