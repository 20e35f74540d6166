"""Where a drive is lost: each stage swapped for its oracle."""

from __future__ import annotations

import base64

from markupsafe import Markup

from graphnav.studies.ablation.report.decomposition_chart import decomposition_picture
from graphnav.studies.ablation.report.decomposition_text import HEADER, heading, notes, rows, sentences
from graphnav.studies.ablation.report.html.render import rendered
from graphnav.studies.ablation.report.html.study_results import StudyResults
from graphnav.studies.ablation.results import losses


def decomposition(study: StudyResults) -> Markup:
    """Return the chart and the tables of a decomposed study; nothing for other studies."""
    found = losses(study.plan, study.records)
    if not found:
        return Markup("")
    told = [of for of in found if not of.is_cut_off]
    return rendered(
        "decomposition.html",
        chart=base64.b64encode(decomposition_picture(told, "svg")).decode("ascii") if told else "",
        answers=[" ".join(sentences(study.plan, of)) for of in found],
        notes=list(notes(study.plan, found)),
        header=HEADER,
        tables=[(heading(of), list(rows(of))) for of in told],
    )
