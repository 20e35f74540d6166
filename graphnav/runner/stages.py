"""Make the stages of a graph and let them look at what their parameters name."""

from __future__ import annotations

from graphnav.errors import ParamError, UserError
from graphnav.graph import Graph
from graphnav.stage import Stage


def make_stages(graph: Graph) -> dict[str, Stage]:
    """Return a new, checked stage for every node, by name.

    Raises
    ------
    UserError
        Everything that constructors and ``check`` refuse, each at the parameter's place.
    """
    stages, problems = {}, []
    for node in graph.nodes:
        try:
            stage = node.make()
            stage.check()
        except UserError as error:
            problems += error.problems
        except ParamError as error:
            problems.append(node.problem(error))
        else:
            stages[node.name] = stage
    if problems:
        raise UserError(problems)
    return stages
