"""The parameters that studies and tunings, their commands and their Python functions share."""

from __future__ import annotations

from graphnav.core.api import Shared
from graphnav.core.parameters import COUNT, SEED_NUMBER, Integer, Parameter, flag, many, seconds

STUDY = Parameter(
    "study",
    nargs="*",
    metavar="STUDY",
    help="a study, or graphs: files or names of shipped ones",
    doc="A study (a YAML file, or the name of one that ships), or graphs: "
    '``"corridor_ccw"``, ``["corridor_ccw", "pillars"]``.',
    offers="studies",
    example='"corridor_ccw"',
)
VARY = many(
    "vary",
    "--vary",
    metavar="AXIS=A,B,...",
    help="an axis, the base's value first (plane=plane.ica,plane.affine); AXIS+=C adds a value to the study's",
    doc="What varies, by what ``set`` takes, the base's value first: "
    '``{"plane": ["plane.ica", "plane.affine"]}``. Axes cross. ``{"plane+": ["plane.mine"]}`` adds to an axis of a '
    "study.",
    offers="axes",
    example='{"plane": ["plane.ica", "plane.affine"]}',
)
SEEDS = Parameter(
    "seeds",
    "--seeds",
    metavar="FIRST:END",
    help="seeds of the worlds, END excluded, or 1,2,5",
    doc="The worlds, ``range(1000, 1010)``; None: those of the study.",
    example="range(1000, 1010), or [1, 5, 7]",
)
METRICS = many(
    "metrics",
    "--metrics",
    metavar="STAGE.METRIC,...",
    help="columns of the table, deciding first",
    doc='Columns of the tables, ``"drive.success"``, the one that decides first; none: all of them.',
    example='"drive.success"',
)
WITHIN = many(
    "within",
    "--within",
    metavar="AXIS,...",
    help="axes that are conditions: variants are compared with the base under the same one",
    example='"control.max_speed_mps"',
)
ONE_AT_A_TIME = flag("one_at_a_time", "--one-at-a-time", "change one axis of the base at a time instead of crossing")
DECOMPOSE = flag(
    "decompose",
    "--decompose",
    "swap the stages of a graph's drive for their oracles, one at a time and cumulatively, and show where is "
    "lost what these reach",
    doc="Swap the stages of a graph's drive for their oracles, one at a time and cumulatively, and show where "
    "is lost what these reach; in place of ``vary``.",
)
REFERENCE = Parameter(
    "reference",
    "--reference",
    metavar="VARIANT",
    help="the variant, by its name in tables, whose runs relative metrics compare with (drive.oracle_spl)",
    doc="The variant, by its name in tables, whose runs relative metrics compare with; None: that of the study.",
    example='"steer.oracle"',
)
WORLDS = many(
    "worlds",
    "--worlds",
    metavar="GRAPH=N,...",
    help="graphs that have only the first N seeds",
    doc='Graphs that have only the first so many seeds: ``{"suite/laps": 10}``; None: those of the study.',
    example='{"suite/laps": 10}',
)
UNTIL_CLEAR = flag(
    "until_clear",
    "--until-clear",
    "add seeds, in their order, only until the metric that decides tells every variant from the base",
)
FOLDER = Shared.FOLDER.but(
    help="the study's folder (default: ablations/STUDY); with --compare the file to write", example='"ablations/1"'
)
JOBS = Parameter(
    "jobs",
    "-j",
    type=COUNT,
    metavar="N",
    help="runs at once (default: one per core)",
    doc="Runs at once; None: one a core.",
    example="2",
)
CLUSTER = Parameter(
    "cluster",
    "--cluster",
    metavar="URL",
    help="run on the Dask cluster whose scheduler is at tcp://host:8786; its workers need graphnav, and "
    "your maps and plugins at the same paths, but not this folder",
    doc='The scheduler of a Dask cluster, ``"tcp://host:8786"``, that makes the runs.',
    example='"tcp://host:8786"',
)
GALLERY = Parameter(
    "gallery",
    "--gallery",
    type=Integer(0),
    default=2,
    metavar="N",
    help="failures of each variant that are run again and drawn (default %(default)s; baselines 1)",
    doc="How many failures of each variant are run again and drawn for the report.",
    example="2",
)
KEEP_LOGS = flag("keep_logs", "--keep-logs", "keep the full logs of the drawn failures")
FAIL_FAST = flag(
    "fail_fast",
    "--fail-fast",
    "stop at the first run in which a stage fails or whose process dies, with exit status 1",
    doc="Raise `GraphnavError` at the first run in which a stage fails or whose process dies.",
)
STALL_S = Parameter(
    "stall_s",
    "--stall-s",
    type=seconds,
    default=300.0,
    metavar="S",
    help="end a run, which then counts as failed, if one call into a stage takes longer than S seconds of wall "
    "time (default: %(default)g)",
)
YES = flag("yes", "--yes", "do not ask for confirmation before more than 1000 runs")
TRIALS = Parameter(
    "trials",
    "--trials",
    type=COUNT,
    default=100,
    metavar="N",
    help="trials of each rival (default %(default)s)",
    doc="Trials of each rival, the first of which is the rival as it is.",
    example="10",
)
SEARCH = many(
    "search",
    "--search",
    metavar="KEY=LOW:HIGH[:log]",
    help="the range of a parameter, or its choices (plane.rule=mad,otsu), in place of the default: a quarter to "
    "four times its value, within its bounds",
    doc='Ranges of parameters, as ``--search`` takes them: ``"plane.threshold_px=0.05:2:log"``, '
    '``"plane.rule=mad,otsu"``; others follow from what the stages declare.',
    example='"plane.threshold_px=0.05:2"',
)
SAMPLER_SEED = Parameter(
    "sampler_seed",
    "--sampler-seed",
    type=SEED_NUMBER,
    default=0,
    metavar="N",
    help="seed of the proposals (default %(default)s); worlds ignore it",
    doc="Seed of the proposals; worlds do not depend on it.",
    example="10",
)

OF_FUNCTIONS = (
    *(STUDY, VARY, SEEDS, METRICS, WITHIN, ONE_AT_A_TIME, DECOMPOSE, REFERENCE, WORLDS, UNTIL_CLEAR),
    *(FOLDER, JOBS, CLUSTER, GALLERY, KEEP_LOGS, FAIL_FAST, TRIALS, SEARCH, SAMPLER_SEED),
)
"""Those of `graphnav.ablate` and `graphnav.tune`, beside those of every graph."""
