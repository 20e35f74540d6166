"""Planar flow: what an obstacle-free ground would flow like, taught beforehand; the family ``planar``."""

from graphnav import Stage, hookimpl


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    """Return the stages of the family."""
    from graphnav_planar.gain import Gain  # noqa: PLC0415  # only graphs that use the family pay for it
    from graphnav_planar.mean import Mean  # noqa: PLC0415
    from graphnav_planar.motion import Motion  # noqa: PLC0415
    from graphnav_planar.subspace import Subspace  # noqa: PLC0415
    from graphnav_planar.teach import Teach  # noqa: PLC0415
    from graphnav_planar.truth import Truth  # noqa: PLC0415

    return [Gain, Mean, Motion, Subspace, Teach, Truth]
