"""The parameters that commands and Python functions share."""

from __future__ import annotations

from pathlib import Path
from typing import Literal, get_args

from graphnav.core.parameters import Parameter, flag, many

TapMode = Literal["thin", "full", "none"]


class Shared:
    """Parameters of graphs and runs, each declared once."""

    GRAPH = Parameter(
        "graph",
        metavar="GRAPH",
        help="a YAML file, or the name of a graph that ships",
        doc="A YAML file, or the name of a graph in the working folder or among those that ship: "
        '``"corridor_ccw"``. A graph that `graphnav.load` returned is taken as it is.',
        offers="graphs",
        example='"corridor_ccw"',
    )
    SET = many(
        "set",
        "--set",
        metavar="KEY=VALUE",
        help="swap a stage (plane=plane.affine), a parameter (plane.rule=otsu), a time (guard.every_ms=20) or a wire "
        "(plane.in.flow=flow.flow), or add a stage (twin+=plane.affine)",
        doc='Overrides, as ``--set`` takes them: ``{"plane": "plane.affine"}`` swaps a stage, '
        '``{"robot.noise_sigma": 3}`` a parameter, ``{"plane.in.flow": "flow.flow"}`` a wire, '
        '``{"run.until_s": 5}`` an option of the run, and ``{"twin+": "plane.affine"}`` adds a stage. Lists, '
        "numpy scalars, paths and None are values too.",
        offers="overrides",
        example='{"plane": "plane.affine", "robot.noise_sigma_gray": 3}',
    )
    PLUGINS = many(
        "plugins",
        "--plugin",
        type=Path,
        metavar="FILE",
        help="a file with stages",
        doc="Files with stages of your own, as ``--plugin`` takes them.",
        example='"my_stage.py"',
    )
    TRUST = flag(
        "trust",
        "--trust",
        "run the plugin files that the graph or the run folder names, without asking (default: only those that "
        "graphnav wrote or whose folder is trusted; at a terminal, ask)",
        doc="Run the plugin files that the graph names; otherwise only those that graphnav wrote or whose folder is "
        "trusted (``graphnav trust``) run, and others are errors. `graphnav.run` and studies run what their graph "
        "names.",
    )
    SEED = Parameter(
        "seed",
        "--seed",
        type=int,
        help="seed of all randomness (default: the graph's)",
        doc="Seed of all randomness, in place of the graph's.",
    )
    UNTIL_S = Parameter(
        "until_s",
        "--until",
        type=float,
        metavar="S",
        help="stop after S seconds: simulated, or live",
        doc="When to stop, in place of the graph's: simulated seconds; live, seconds since the start.",
    )
    RECORD = Parameter(
        "record",
        "--record",
        choices=("all", "replayable", "small"),
        help="what the log keeps: all messages; replayable: those from which 'figure', 'export', 'spy', 'view' and "
        "'replay' make the rest again; small: those below 4 kB (default: the graph's, else replayable; live small)",
        doc='What the log keeps: ``"all"`` messages, ``"replayable"``, those from which `open_log` and other '
        'readers make the rest again, or ``"small"`` ones; None: the graph\'s, else replayable, live small.',
    )
    FOLDER = Parameter(
        "folder",
        "-o",
        type=Path,
        metavar="DIR",
        help="run folder, new or empty (default: runs/…)",
        doc="The folder of the result. None: a temporary one, removed when neither the result nor its log is in use "
        "any more. That of a run is new or empty; that of a study may hold its earlier runs.",
        example='"runs/1"',
    )
    TAP = Parameter(
        "tap",
        "--tap",
        choices=get_args(TapMode),
        default="none",
        help="copies for viewers on this machine: messages thinned to one packet and 32 pictures a second, all "
        "messages in full, or none",
        doc='What is sent to ``graphnav spy`` and other programs that watch: ``"thin"``, ``"full"``, ``"none"``.',
        example='"thin" to watch with graphnav spy',
    )
    PACE = Parameter(
        "pace",
        "--pace",
        type=float,
        metavar="X",
        help="speed relative to wall time; 1 to watch (default: as fast as possible)",
        doc="Simulated seconds per second of wall time; None: as fast as the machine allows.",
        example="1 for wall time",
    )
    LIVE = flag(
        "live",
        "--live",
        "run in wall time, on LCM channels of other programs; implied by a graph with inputs",
        doc="Run by the wall clock and on channels of other programs; a graph with inputs is live by itself.",
    )
    PROCESSES = flag(
        "processes",
        "--processes",
        "give each stage that the graph's 'deploy' does not name a process of its own; in lockstep the log stays the "
        "same, live steps overlap",
        doc="Give each stage that the graph's ``deploy`` does not name a process of its own. In lockstep the log stays "
        "the same; live, steps overlap.",
    )
    LIVE_URL = Parameter(
        "url",
        "--url",
        metavar="URL",
        help="LCM URL of live inputs and outputs (default: the graph's, LCM_DEFAULT_URL, this machine's group)",
        doc="LCM URL of the channels that come in and leave, live.",
        example='"udpm://239.255.76.67:7667?ttl=0"',
    )
    PICTURES = Parameter("pictures", default=True, doc="Draw the panels and the map from the log.")
    CHECK = Parameter("check", default=False, doc="Raise `RunError` if the run fails.")

    LOADED = (GRAPH, SET, PLUGINS, TRUST)
    """A graph, as commands and functions load it that run no plugin that the user has not trusted."""
    RUN_OPTIONS = (SEED, UNTIL_S, RECORD)
    """Options of a run that a graph has too, which says what they may be."""
    OF_RUN = (*LOADED, *RUN_OPTIONS, FOLDER, TAP, PACE, PROCESSES, LIVE, LIVE_URL, PICTURES, CHECK)
    """Those of `graphnav.run`; `graphnav.profile` has some of them."""
