"""Turn a graph into the study of what each stage of its drive costs."""

from graphnav.studies.ablation.decompose.build_study import decomposed_study

__all__ = ["decomposed_study"]
