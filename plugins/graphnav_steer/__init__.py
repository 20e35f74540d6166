"""From the dominant plane to the direction to drive in; the family ``steer``."""

from graphnav import Stage, hookimpl


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    """Return the stages of the family."""
    from graphnav_steer.balance import Balance  # noqa: PLC0415  # only graphs that use the family pay for it
    from graphnav_steer.forward import Forward  # noqa: PLC0415
    from graphnav_steer.mean_gradient import MeanGradient  # noqa: PLC0415
    from graphnav_steer.oracle import Oracle  # noqa: PLC0415
    from graphnav_steer.pca import Pca  # noqa: PLC0415
    from graphnav_steer.random import Random  # noqa: PLC0415
    from graphnav_steer.time_to_contact import TimeToContact  # noqa: PLC0415

    return [Balance, Forward, MeanGradient, Oracle, Pca, Random, TimeToContact]
