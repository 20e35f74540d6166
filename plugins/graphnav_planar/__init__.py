"""Stages of the family ``planar``: the taught flow of an obstacle-free ground."""

from graphnav import Stage, hookimpl


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    """Return the stages of the family."""
    from graphnav_planar.gain import Gain
    from graphnav_planar.mean import Mean
    from graphnav_planar.motion import Motion
    from graphnav_planar.subspace import Subspace
    from graphnav_planar.teach import Teach
    from graphnav_planar.truth import Truth

    return [Gain, Mean, Motion, Subspace, Teach, Truth]
