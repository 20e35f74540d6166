"""The parameters of the Python door, each documented once; `documented` puts them into the docstrings."""

from __future__ import annotations

import inspect
import textwrap
from collections.abc import Callable
from typing import TypeVar

F = TypeVar("F", bound=Callable[..., object])

PARAMETERS = {
    "graph": "A YAML file, or the name of a graph in the working folder or among those that ship: "
    '``"corridor_ccw"``. A graph that `graphnav.load` returned is taken as it is.',
    "study": "A study (a YAML file, or the name of one that ships), or graphs: "
    '``"corridor_ccw"``, ``["corridor_ccw", "pillars"]``.',
    "vary": "What varies, by what ``set`` takes, the base's value first: "
    '``{"plane": ["plane.ica", "plane.affine"]}``. Axes cross. ``{"plane+": ["plane.mine"]}`` adds to an axis of a '
    "study.",
    "set": 'Overrides, as ``--set`` takes them: ``{"plane": "plane.affine"}`` swaps a stage, '
    '``{"robot.noise_sigma": 3}`` a parameter, ``{"plane.in.flow": "flow.flow"}`` a wire, ``{"run.until_s": 5}`` an '
    'option of the run, and ``{"twin+": "plane.affine"}`` adds a stage. Lists, numpy scalars, paths and None are '
    "values too.",
    "plugins": "Files with stages of your own, as ``--plugin`` takes them.",
    "trust": "Run the plugin files that the graph names; otherwise only those that graphnav wrote or whose folder is "
    "trusted (``graphnav trust``) run, and others are errors. `graphnav.run` and studies run what their graph names.",
    "seed": "Seed of all randomness, in place of the graph's.",
    "seeds": "The worlds, ``range(1000, 1010)``; None: those of the study.",
    "until_s": "When to stop, in place of the graph's: simulated seconds; live, seconds since the start.",
    "folder": "The folder of the result. None: a temporary one, removed when neither the result nor its log is in use "
    "any more. That of a run is new or empty; that of a study may hold its earlier runs.",
    "pace": "Simulated seconds per second of wall time; None: as fast as the machine allows.",
    "tap": 'What is sent to ``graphnav spy`` and other programs that watch: ``"thin"``, ``"full"``, ``"none"``.',
    "live": "Run by the wall clock and on channels of other programs; a graph with inputs is live by itself.",
    "url": "LCM URL of the channels that come in and leave, live.",
    "record": 'What the log keeps: ``"all"`` messages, ``"replayable"``, those from which `open_log` and other '
    'readers make the rest again, or ``"small"`` ones; None: the graph\'s, else replayable, live small.',
    "pictures": "Draw the panels and the map from the log.",
    "check": "Raise `RunError` if the run fails.",
    "clock": 'What measures: ``"wall"``, or ``"cpu"`` for the processor time of the run, which other work on the '
    "machine hardly changes.",
    "functions": "Also sample the functions inside of the steps, for the flame graph; needs pyinstrument.",
    "metrics": 'Columns of the tables, ``"drive.success"``, the one that decides first; none: all of them.',
    "trials": "Trials of each rival, the first of which is the rival as it is.",
    "search": 'Ranges of parameters, as ``--search`` takes them: ``"plane.threshold_px=0.05:2:log"``, '
    '``"plane.rule=mad,otsu"``; others follow from what the stages declare.',
    "sampler_seed": "Seed of the proposals; worlds do not depend on it.",
    "within": "Axes that are conditions: variants are compared with the base under the same one.",
    "reference": "The variant, by its name in tables, whose runs relative metrics compare with; None: that of the "
    "study.",
    "worlds": 'Graphs that have only the first so many seeds: ``{"suite/laps": 10}``; None: those of the study.',
    "until_clear": "Use the seeds, in their order, only until the metric that decides tells every variant from "
    "the base.",
    "fail_fast": "Raise `GraphnavError` at the first run in which a stage fails or whose process dies.",
    "one_at_a_time": "Change one axis of the base at a time, in place of crossing them.",
    "decompose": "Swap the stages of a graph's drive for their oracles, one at a time and cumulatively, and show where "
    "is lost what these reach; in place of ``vary``.",
    "jobs": "Runs at once; None: one a core.",
    "cluster": 'The scheduler of a Dask cluster, ``"tcp://host:8786"``, that makes the runs.',
    "gallery": "How many failures of each variant are run again and drawn for the report.",
    "keep_logs": "Keep the full logs of those.",
}
"""By name; a parameter means the same wherever it is taken."""

_WIDTH = 120


def documented(function: F) -> F:
    """Return a function whose docstring says what its parameters mean, in front of what it raises."""
    if function.__doc__ is None:  # python -OO
        return function
    text, raises, errors = inspect.cleandoc(function.__doc__).partition("Raises\n------")
    entries = [f"{name}\n{_indented(PARAMETERS[name])}" for name in inspect.signature(function).parameters]
    section = "\n".join(["Parameters", "----------", *entries])
    function.__doc__ = f"{text.rstrip()}\n\n{section}\n\n{raises}{errors}".rstrip()
    return function


def _indented(text: str) -> str:
    return textwrap.fill(text, _WIDTH, initial_indent="    ", subsequent_indent="    ", break_on_hyphens=False)
