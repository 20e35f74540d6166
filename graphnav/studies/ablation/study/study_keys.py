"""Declared keys of a study's file."""

from __future__ import annotations

from collections.abc import Mapping

from graphnav import FileFormat, Record, Value, key
from graphnav.core.stage import FormerNames
from graphnav.studies.ablation.study.worlds import HINT, MAX_SEED

Names = str | tuple[str, ...]
Settings = Mapping[str, Value]
"""Values by what they set: a stage, a parameter ``stage.key``, an input ``stage.in.port``, ``run.key``."""
Choices = tuple[Value, ...] | Mapping[str, Settings | None] | None
"""Of one axis: values of what it is called by, or labels with the settings of each."""

_GRAPHS = "graphs: files beside the study, or names of graphs that ship"


class StudyKeys(Record):
    """A study runs every graph with every variant in every world, and compares the variants in the same worlds."""

    noun = "a study"
    one_of = ("graph", "graphs")
    renamed = dict(FormerNames.STUDY_KEYS)  # noqa: RUF012

    about: str = key("", doc="the question that the study answers; not evaluated")
    graph: Names | None = key(
        None,
        min_items=1,
        doc="one graph: a file beside the study, or the name of one that ships",
        hint="write graph: corridor_ccw",
    )
    graphs: Names | None = key(None, min_items=1, doc=_GRAPHS, hint="write [corridor_ccw, pillars]")
    seeds: str | tuple[int, ...] | None = key(
        None,
        min_items=1,
        ge=0,
        le=MAX_SEED,
        doc="the worlds: `FIRST:END`, the end not included, or a list; `--seeds` replaces it",
        hint=HINT,
    )
    worlds: Mapping[str, int] | None = key(
        None,
        ge=1,
        doc="by graph, as `graph` or `graphs` names it: its number of worlds, the first of the seeds; a graph that is "
        "not named has all; `--worlds` replaces it",
        hint="write worlds: {suite/laps: 10}",
    )
    one_at_a_time: bool = key(
        default=False, doc="whether each variant changes one axis of the base; else the axes cross"
    )
    set: Names | Settings | None = key(
        None,
        min_items=1,
        doc="what every run sets, as `--set` does: a mapping of what is set to its value, or a list of `target=value`",
        hint="write {run.until_s: 60}",
    )
    vary: Mapping[str, Choices] = key(
        doc="the axes: what varies, by name; the first choice of each is the base's",
        hint="write vary: {plane: [plane.ica, plane.affine]}",
    )
    within: Names = key(
        (),
        min_items=1,
        doc="axes that are conditions: variants are compared with the base under the same choices of these",
        hint="write [speed], or leave the key out",
    )
    reference: str = key(
        "",
        doc="a variant, by its name in tables: metrics that a stage declares as relative compare each run with this "
        "variant's in the same world",
        hint="write reference: oracle, or leave the key out",
    )
    metrics: Names = key(
        (),
        min_items=1,
        doc="columns of the table, the one that decides first: `stage.metric`, or two with ` - ` or ` / ` between; "
        "without it all metrics",
        hint="write [drive.success, drive.spl], or leave the key out",
    )


EXAMPLE = """\
about: Which detector of the dominant plane drives best, and how fast?

graph: pillars
seeds: 1000:1010
set: {run.until_s: 120}

vary:
  plane: [plane.ica, plane.affine, plane.homography]
  speed:
    as it is: {}
    fast: {control.max_speed_mps: 0.6, robot.max_speed_mps: 1}

within: [speed]
metrics: [drive.success, drive.spl, sight.auroc, sight.auroc - sight.balanced_accuracy_ratio]
"""

STUDY = FileFormat(
    "study",
    StudyKeys,
    title="Studies",
    doc=f"""
A study is a YAML file that says what `graphnav ablate` runs and compares. Everything in it may also be given on the
command line, which replaces what the file says.

```yaml
{EXAMPLE}```

Saved as `my_study.yaml` it runs by `graphnav ablate my_study.yaml`. `graphnav schema --of study` prints the JSON
Schema, for completion and checks in editors.

## Axes

An axis under `vary` is one of:

- a list of values. Its name is what they set, as in `--set`: a stage (`plane: [plane.ica, plane.affine]`), a parameter
  (`steer.sigma_ratio: [0.3, 0.5]`), an input (`plane.in.flow: [flow.flow, twin.flow]`), an option
  (`run.until_s: [60, 120]`), several stages at once (`plane,twin.rule: [mad, otsu]`).
- labels, each with all that it sets: `fast: {{control.max_speed_mps: 0.6, robot.max_speed_mps: 1}}`. A label with
  nothing, `as it is: {{}}`, is the graph as it is. The axis may then have any name but those of columns of the results.

Paths in values are looked for beside the study first.
""",
)
