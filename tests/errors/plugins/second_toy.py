"""A plugin with a stage that another file has."""

from graphnav import Source, Stage, Twist, hookimpl

FAMILY = "toy"


class Robot(Source):
    """Another one of this name."""

    def step(self) -> Twist:
        return Twist(v_mps=0.0, omega_radps=0.0)


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    return [Robot]
