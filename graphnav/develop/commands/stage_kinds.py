"""Starting points of stages by family: small and working, with one parameter and one test."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Kind:
    """The parts of a template that differ between families; ``$`` names are filled in."""

    doc: str
    imports: str
    params: str
    body: str
    test_imports: str
    example: str
    steps: str
    test: str
    base: str = "Stage"
    graph: str = "corridor_ccw"
    """The shipped graph in which to try the stage."""
    swaps: str = ""
    """The stage of that graph to replace; empty to add the stage."""


_FLOW_EXAMPLE = '''
def flow_of(u_px: float) -> Flow:
    """Return a flow to the right of 12 x 16 vectors, all valid."""
    uv_px = np.full((12, 16, 2), (u_px, 0.0), np.float32)
    return Flow(uv_px=uv_px, valid=np.ones((12, 16), np.uint8), interval_us=100_000)
'''

_PLANE_EXAMPLE = '''
def plane_of(*, left: int, right: int) -> Plane:
    """Return a plane whose left and right halves are ground (0) or obstacle (1)."""
    obstacle = np.repeat(np.array([[left, right]], np.uint8), (8, 8), axis=1).repeat(12, axis=0)
    return Plane(
        obstacle=obstacle,
        score=obstacle.astype(np.float32),
        valid=np.ones_like(obstacle),
        step_px=1,
        obstacle_ratio=float(obstacle.mean()),
    )
'''

KINDS = {
    "source": Kind(
        doc="Pictures of noise.",
        base="Source",
        graph="video_plane",
        swaps="camera",
        imports="import numpy as np\nfrom graphnav import Image, Source, Stage, hookimpl, param",
        params='    width_px: int = param(160, ge=1, doc="columns of a picture")\n'
        '    height_px: int = param(120, ge=1, doc="rows of a picture")\n',
        body="""    def reset(self, seed: int) -> None:
        self._random = np.random.default_rng(seed)

    def step(self) -> Image:
        return Image(pixels=self._random.integers(0, 256, (self.height_px, self.width_px), dtype=np.uint8))
""",
        test_imports="",
        example="",
        steps="{}, {}",
        test="""def test_pictures_have_the_requested_size() -> None:
    stage = $cls(width_px=5, height_px=3)
    stage.reset(seed=0)
    assert stage.step().pixels.shape == (3, 5)
""",
    ),
    "flow": Kind(
        doc="Optical flow of a static scene.",
        swaps="flow",
        imports="import numpy as np\nfrom graphnav import Flow, Image, Stage, hookimpl, param",
        params='    step_px: int = param(1, ge=1, doc="grid step; more is coarser")\n',
        body="""    def reset(self, seed: int) -> None:
        self._last: Image | None = None

    def step(self, image: Image) -> Flow | None:
        last, self._last = self._last, image
        if last is None:
            return None  # the first picture has no flow
        shape = image.pixels[:: self.step_px, :: self.step_px].shape[:2]
        return Flow(
            uv_px=np.zeros((*shape, 2), np.float32),
            valid=np.ones(shape, np.uint8),
            interval_us=100_000,
            step_px=self.step_px,
        )
""",
        test_imports="import numpy as np\nfrom graphnav import Image",
        example='''
def picture() -> Image:
    """Return a gray picture of 12 x 16 pixels."""
    return Image(pixels=np.full((12, 16), 128, np.uint8))
''',
        steps='{"image": picture()}, {"image": picture()}',
        test="""def test_a_static_scene_has_no_flow() -> None:
    stage = $cls()
    stage.reset(seed=0)
    assert stage.step(picture()) is None
    assert not stage.step(picture()).uv_px.any()
""",
    ),
    "planar": Kind(
        doc="Planar flow: the mean of the flow, everywhere the same.",
        swaps="planar",
        imports="import numpy as np\nfrom graphnav import Flow, Planar, Stage, hookimpl, param",
        params='    gain: float = param(1.0, gt=0.0, doc="what the mean is multiplied by, dimensionless")\n',
        body="""    def step(self, flow: Flow) -> Planar:
        valid = flow.valid.astype(bool)
        mean_px = flow.uv_px[valid].mean(axis=0) if valid.any() else np.zeros(2)
        return Planar(
            planar_uv_px=np.broadcast_to(self.gain * mean_px, flow.uv_px.shape).astype(np.float32),
            planar_valid=np.ones_like(flow.valid),
            residual_px=np.zeros(flow.valid.shape, np.float32),
            interval_us=flow.interval_us,
            step_px=flow.step_px,
        )
""",
        test_imports="import numpy as np\nfrom graphnav import Flow",
        example=_FLOW_EXAMPLE,
        steps='{"flow": flow_of(1.0)}, {"flow": flow_of(2.0)}',
        test="""def test_an_even_flow_is_its_own_mean() -> None:
    stage = $cls()
    stage.reset(seed=0)
    assert np.array_equal(stage.step(flow_of(3.0)).planar_uv_px, flow_of(3.0).uv_px)
""",
    ),
    "plane": Kind(
        doc="Obstacle is where the flow is longer than its median.",
        swaps="plane",
        imports="import numpy as np\nfrom graphnav import Flow, Plane, Stage, hookimpl, param",
        params='    threshold_px: float = param(0.5, gt=0.0, doc="excess over the median that makes an obstacle")\n',
        body="""    def step(self, flow: Flow) -> Plane:
        valid = flow.valid.astype(bool)
        length_px = np.linalg.norm(flow.uv_px, axis=2)
        score = length_px - np.median(length_px[valid]) if valid.any() else np.zeros_like(length_px)
        obstacle = valid & (score > self.threshold_px)
        return Plane(
            obstacle=obstacle.astype(np.uint8),
            score=score.astype(np.float32),
            valid=flow.valid.copy(),
            step_px=flow.step_px,
            obstacle_ratio=float(obstacle.sum() / max(valid.sum(), 1)),
            threshold=self.threshold_px,
        )
""",
        test_imports="import numpy as np\nfrom graphnav import Flow",
        example=_FLOW_EXAMPLE,
        steps='{"flow": flow_of(1.0)}, {"flow": flow_of(2.0)}',
        test="""def test_what_moves_faster_than_the_rest_is_obstacle() -> None:
    flow = flow_of(1.0)
    flow.uv_px[4:8, 2:5] = (3.0, 0.0)
    stage = $cls()
    stage.reset(seed=0)
    found = stage.step(flow).obstacle
    assert found[4:8, 2:5].all()
    assert found.sum() == 12
""",
    ),
    "steer": Kind(
        doc="Steer away from the side that has more obstacle.",
        swaps="steer",
        imports="import math\n\nimport numpy as np\nfrom graphnav import Plane, Stage, Steering, hookimpl, param",
        params='    gain: float = param(1.0, ge=0.0, doc="more turns away earlier, dimensionless")\n',
        body="""    def step(self, plane: Plane) -> Steering:
        middle = plane.obstacle.shape[1] // 2
        left, right = plane.obstacle[:, :middle].mean(), plane.obstacle[:, middle:].mean()
        repulsive = np.array([self.gain * (left - right), 0.0])  # to the right if the left is fuller
        guiding = np.array([0.0, 1.0])
        control = repulsive + guiding
        return Steering(
            repulsive=repulsive,
            guiding=guiding,
            control=control,
            theta_rad=math.atan2(-control[0], control[1]),
            eigenvalues=np.zeros(2),
        )
""",
        test_imports="import numpy as np\nfrom graphnav import Plane",
        example=_PLANE_EXAMPLE,
        steps='{"plane": plane_of(left=0, right=1)}, {"plane": plane_of(left=0, right=0)}',
        test="""def test_an_obstacle_on_the_right_turns_left() -> None:
    stage = $cls()
    stage.reset(seed=0)
    assert stage.step(plane_of(left=0, right=1)).theta_rad > 0
    assert stage.step(plane_of(left=1, right=0)).theta_rad < 0
    assert stage.step(plane_of(left=0, right=0)).theta_rad == 0
""",
    ),
    "control": Kind(
        doc="Turn toward the steering angle, and slow down in turns.",
        swaps="control",
        imports="import math\n\nfrom graphnav import Stage, Steering, Twist, hookimpl, param",
        params='    max_speed_mps: float = param(0.3, gt=0.0, doc="speed straight ahead")\n'
        '    max_turn_radps: float = param(1.0, gt=0.0, doc="turning rate at a right angle")\n',
        body="""    def step(self, steering: Steering) -> Twist:
        return Twist(
            v_mps=max(0.0, self.max_speed_mps * math.cos(steering.theta_rad)),
            omega_radps=self.max_turn_radps * math.sin(steering.theta_rad),
        )
""",
        test_imports="import numpy as np\nimport pytest\nfrom graphnav import Steering",
        example='''
def steering_to(theta_rad: float) -> Steering:
    """Return a steering with no forces, only an angle (left positive)."""
    none = np.zeros(2)
    return Steering(repulsive=none, guiding=none, control=none, theta_rad=theta_rad, eigenvalues=none)
''',
        steps='{"steering": steering_to(0.0)}, {"steering": steering_to(0.5)}',
        test="""def test_straight_ahead_is_full_speed_and_left_turns_left() -> None:
    stage = $cls()
    stage.reset(seed=0)
    ahead, left = stage.step(steering_to(0.0)), stage.step(steering_to(0.5))
    assert ahead.v_mps == pytest.approx(stage.max_speed_mps)
    assert ahead.omega_radps == 0
    assert left.omega_radps > 0
""",
    ),
    "score": Kind(
        doc="The mean share of obstacle.",
        imports="from collections.abc import Mapping\nfrom typing import ClassVar\n\n"
        "from graphnav import Metric, Plane, Stage, hookimpl, param",
        params="    metrics: ClassVar[tuple[Metric, ...]] = (\n"
        '        Metric("obstacle_ratio", unit="ratio", better="lower", help="Mean share of obstacle."),\n'
        "    )\n\n"
        '    skip: int = param(0, ge=0, doc="frames at the start that do not count")\n',
        body="""    def reset(self, seed: int) -> None:
        self._ratios: list[float] = []

    def step(self, plane: Plane) -> None:
        self._ratios.append(plane.obstacle_ratio)

    def summary(self) -> Mapping[str, float]:
        counted = self._ratios[self.skip :]
        return {"obstacle_ratio": sum(counted) / len(counted)} if counted else {}
""",
        test_imports="import numpy as np\nimport pytest\nfrom graphnav import Plane",
        example=_PLANE_EXAMPLE,
        steps='{"plane": plane_of(left=0, right=1)}, {"plane": plane_of(left=0, right=0)}',
        test="""def test_the_metric_is_the_mean_over_the_frames() -> None:
    stage = $cls()
    stage.reset(seed=0)
    assert stage.summary() == {}
    stage.step(plane_of(left=0, right=1))
    stage.step(plane_of(left=0, right=0))
    assert stage.summary() == {"obstacle_ratio": pytest.approx(0.25)}
""",
    ),
    "image": Kind(
        doc="The picture with other brightness.",
        imports="import numpy as np\nfrom graphnav import Image, Stage, hookimpl, param",
        params='    gain: float = param(1.0, ge=0.0, doc="more is brighter, dimensionless")\n',
        body="""    def step(self, image: Image) -> Image:
        pixels = np.clip(np.rint(self.gain * image.pixels.astype(np.float32)), 0, 255)
        return Image(pixels=pixels.astype(np.uint8), step_px=image.step_px)
""",
        test_imports="import numpy as np\nfrom graphnav import Image",
        example='''
def picture(gray: int) -> Image:
    """Return an even picture of 12 x 16 pixels."""
    return Image(pixels=np.full((12, 16), gray, np.uint8))
''',
        steps='{"image": picture(0)}, {"image": picture(200)}',
        test="""def test_brightness_is_multiplied_and_ends_at_white() -> None:
    stage = $cls(gain=2.0)
    stage.reset(seed=0)
    assert (stage.step(picture(50)).pixels == 100).all()
    assert (stage.step(picture(200)).pixels == 255).all()
""",
    ),
}
"""The starting point by family."""

_KIND_OF = {"io": "source", "world": "source"}


def kind_of(family: str) -> Kind:
    """Return the starting point for a family; an unknown family turns images into images."""
    return KINDS.get(_KIND_OF.get(family, family), KINDS["image"])
