"""Stages of the family ``plane``: detectors of the dominant plane."""

from graphnav import Stage, hookimpl


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    """Return the stages of the family."""
    from graphnav_plane.affine import Affine
    from graphnav_plane.all_ground import AllGround
    from graphnav_plane.appearance import Appearance
    from graphnav_plane.guided_homography import GuidedHomography
    from graphnav_plane.homography import Homography
    from graphnav_plane.ica import Ica
    from graphnav_plane.learned import Learned
    from graphnav_plane.one_gain import OneGain
    from graphnav_plane.prior import Prior
    from graphnav_plane.residual import Residual
    from graphnav_plane.row_line import RowLine
    from graphnav_plane.row_median import RowMedian
    from graphnav_plane.row_prior import RowPrior
    from graphnav_plane.truth import Truth

    return [
        Affine,
        AllGround,
        Appearance,
        GuidedHomography,
        Homography,
        Ica,
        Learned,
        OneGain,
        Prior,
        Residual,
        RowLine,
        RowMedian,
        RowPrior,
        Truth,
    ]
