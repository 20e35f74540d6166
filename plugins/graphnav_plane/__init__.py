"""Dominant plane: what is ground and what is not; the family ``plane``."""

from graphnav import Stage, hookimpl


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    """Return the stages of the family."""
    from graphnav_plane.affine import Affine  # noqa: PLC0415  # only graphs that use the family pay for it
    from graphnav_plane.all_ground import AllGround  # noqa: PLC0415
    from graphnav_plane.homography import Homography  # noqa: PLC0415
    from graphnav_plane.ica import Ica  # noqa: PLC0415
    from graphnav_plane.residual import Residual  # noqa: PLC0415
    from graphnav_plane.row_prior import RowPrior  # noqa: PLC0415
    from graphnav_plane.truth import Truth  # noqa: PLC0415

    return [Affine, AllGround, Homography, Ica, Residual, RowPrior, Truth]
