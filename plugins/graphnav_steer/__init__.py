"""Stages of the family ``steer``: from the dominant plane, a map or a scan to where to drive."""

from graphnav import Stage, hookimpl


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    """Return the stages of the family."""
    from graphnav_steer.balance import Balance
    from graphnav_steer.dwa import Dwa
    from graphnav_steer.follow_the_gap import FollowTheGap
    from graphnav_steer.forward import Forward
    from graphnav_steer.frontier import Frontier
    from graphnav_steer.gap import Gap
    from graphnav_steer.mean_gradient import MeanGradient
    from graphnav_steer.oracle import Oracle
    from graphnav_steer.pca import Pca
    from graphnav_steer.picture_gap import PictureGap
    from graphnav_steer.random import Random
    from graphnav_steer.recovery import Recovery
    from graphnav_steer.rollout import Rollout
    from graphnav_steer.time_to_contact import TimeToContact
    from graphnav_steer.vfh import Vfh

    return [
        Balance,
        Dwa,
        FollowTheGap,
        Forward,
        Frontier,
        Gap,
        MeanGradient,
        Oracle,
        Pca,
        PictureGap,
        Random,
        Recovery,
        Rollout,
        TimeToContact,
        Vfh,
    ]
