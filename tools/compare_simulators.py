"""Compare both simulators from the same poses: `python tools/compare_simulators.py`.

Masks, depth, flow and gray of `world.pymunk` and `world.mujoco`, which compute them independently of each other; then
the time of a step, in turns, at three sizes of the picture. With a FILE it draws what both show instead.
"""

from __future__ import annotations

import math
import statistics
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from graphnav_mujoco.base import planar_base, positions
from graphnav_mujoco.eye import MujocoFrame, eye_of
from graphnav_mujoco.world import Mujoco
from graphnav_world.geometry import outlines
from graphnav_world.geometry.scene import Body
from graphnav_world.rendering.film import Film
from graphnav_world.rendering.placed_faces import Placed
from graphnav_world.rendering.render import Frame
from graphnav_world.world import Pymunk

from graphnav import Latest, Stamp, Twist
from graphnav.arrays import Bytes

MAPS = Path(__file__).resolve().parent.parent / "graphs" / "graphnav_graphs" / "maps"
WORLDS = (
    ("corridor_ccw", 7, 75.0),
    ("pillars", 5, 75.0),
    ("suite/office", 7, 75.0),
    ("suite/maze", 7, 60.0),
    ("barn", 49, 60.0),
    ("movers", 1, 75.0),
    ("crossing", 1, 45.0),
)
SIZES = ((160, 120), (320, 240), (640, 480))
POSES, STEPS = 20, 30
DRAWN = (("crowded", 5, 60.0), ("barn", 49, 60.0))
SCALE, GAP_PX = 2, 6
Pose = tuple[float, float, float]


@dataclass(frozen=True)
class Agreement:
    """How two frames agree: of masks everywhere, of all else where the masks agree; gray without noise."""

    iou: float
    depth_m: float
    flow_px: float
    gray: float


def agreement(ours: Frame, other: MujocoFrame) -> Agreement:
    """Return how two frames with truth agree, maxima of depth and flow, the mean of gray."""
    one, two = ours.obstacle.astype(bool), other.obstacle.astype(bool)
    both = (one == two) & np.isfinite(ours.depth_m)
    flows = ours.flow_px, other.flow_px
    assert flows[0] is not None
    assert flows[1] is not None
    union = int((one | two).sum())
    return Agreement(
        iou=int((one & two).sum()) / union if union else 1.0,
        depth_m=float(np.abs(ours.depth_m - other.depth_m)[both].max()),
        flow_px=float(np.linalg.norm(flows[0] - flows[1], axis=-1)[both].max()),
        gray=float(np.abs(ours.pixels.astype(float) - Film().exposed(other.gray))[both].mean()),
    )


class Both:
    """Both simulators of one map and seed, which render from any pose."""

    def __init__(self, map_file: Path, seed: int, *, size: tuple[int, int] = SIZES[0], tilt_deg: float = 75.0) -> None:
        self.ours = Pymunk(map=map_file, size=size, tilt_deg=tilt_deg, noise_sigma_gray=0.0)
        self.other = Mujoco(map=map_file, size=size, tilt_deg=tilt_deg, noise_sigma_gray=0.0)
        for world in (self.ours, self.other):
            world.reset(seed)

    def frames(self, now: Pose, before: Pose, time_s: float = 0.0, then_s: float = 0.0) -> tuple[Frame, MujocoFrame]:
        """Return the frames from a pose, with the flow since another one."""
        camera, faces, base = self.ours._camera, self.ours._faces, self.other._base  # noqa: SLF001
        placed = Placed.at(camera, faces, *now, time_s), Placed.at(camera, faces, *before, then_s)
        now_eye, then_eye = (
            eye_of(camera, *planar_base(*pose), positions(base.movers, at_s))
            for pose, at_s in ((now, time_s), (before, then_s))
        )
        retina = self.other._retina  # noqa: SLF001
        assert retina is not None
        return self.ours._renderer.render(*placed), retina.frame(now_eye, then_eye)  # noqa: SLF001

    def poses(self, count: int) -> list[Pose]:
        """Return random poses outside of all bodies, within 2.5 m of the start and on to the goal."""
        draw, rng = self.ours._draw, np.random.default_rng(0)  # noqa: SLF001
        goal = draw.goal_m.mean(axis=0) if len(draw.goal_m) else np.array(draw.start[:2])
        found: list[Pose] = []
        while len(found) < count:
            x, y = np.array(draw.start[:2]) + rng.uniform() * (goal - draw.start[:2]) + rng.uniform(-2.5, 2.5, 2)
            if not _is_inside(draw.bodies, float(x), float(y)):
                found.append((float(x), float(y), float(rng.uniform(-math.pi, math.pi))))
        return found

    def close(self) -> None:
        """Free what OpenGL holds."""
        self.other.close()


def _is_inside(bodies: Sequence[Body], x_m: float, y_m: float) -> bool:
    return any(body.course is None and outlines.contains(body.outline, x_m, y_m) for body in bodies)


def compared(both: Both, count: int) -> list[Agreement]:
    """Return the agreement from so many poses, each after a step of 3 cm and 1 degree."""
    found = []
    for number, (x, y, yaw) in enumerate(both.poses(count)):
        before = (x - 0.03 * math.cos(yaw), y - 0.03 * math.sin(yaw), yaw - math.radians(1))
        time_s = 0.1 * (number + 1)
        found.append(agreement(*both.frames((x, y, yaw), before, time_s, time_s - 0.1)))
    return found


def step_ms(both: Both) -> tuple[float, float]:
    """Return the median time of a step of each, with truth, in turns (ms)."""
    command = Latest(Twist(v_mps=0.05, omega_radps=0.05), 0.0)
    taken: tuple[list[float], list[float]] = ([], [])
    for k in range(STEPS):
        for world, times in zip((both.ours, both.other), taken, strict=True):
            begin = time.perf_counter()
            world.step(command, Stamp(k * 100_000))
            times.append(1e3 * (time.perf_counter() - begin))
    return statistics.median(taken[0]), statistics.median(taken[1])


def drawn(both: Both, pose: Pose) -> Bytes:
    """Return a row of pictures, gray: of each simulator what it shows and where it sees obstacles."""
    x, y, yaw = pose
    frames = both.frames(pose, (x - 0.03 * math.cos(yaw), y - 0.03 * math.sin(yaw), yaw))
    tiles = [tile for frame in frames for tile in (Film().exposed(frame.gray), 255 * frame.obstacle)]
    large = [cv2.resize(tile, None, fx=SCALE, fy=SCALE, interpolation=cv2.INTER_NEAREST) for tile in tiles]
    framed = [cv2.copyMakeBorder(tile, *(GAP_PX // 2,) * 4, cv2.BORDER_CONSTANT, value=(255,)) for tile in large]
    row: Bytes = np.hstack(framed).astype(np.uint8)
    return row


def draw(path: str) -> None:
    """Write the rows of `DRAWN`."""
    rows = []
    for name, seed, tilt_deg in DRAWN:
        both = Both(MAPS / f"{name}.yaml", seed, tilt_deg=tilt_deg)
        rows.append(drawn(both, both.poses(1)[0]))
        both.close()
    cv2.imwrite(path, np.vstack(rows))


def main() -> None:
    """Print both tables, or draw what both show into a file."""
    if sys.argv[1:]:
        draw(sys.argv[1])
        return
    print(f"{POSES} poses each, 160x120: minimum of IoU, maxima of depth and flow, mean of gray")
    print(f"{'map':<14}{'seed':>5}{'IoU':>9}{'depth um':>10}{'flow px':>10}{'gray':>7}")
    for name, seed, tilt_deg in WORLDS:
        both = Both(MAPS / f"{name}.yaml", seed, tilt_deg=tilt_deg)
        all_of = compared(both, POSES)
        iou, depth_um = min(one.iou for one in all_of), 1e6 * max(one.depth_m for one in all_of)
        flow, gray = max(one.flow_px for one in all_of), statistics.mean(one.gray for one in all_of)
        print(f"{name:<14}{seed:>5}{iou:>9.4f}{depth_um:>10.0f}{flow:>10.5f}{gray:>7.2f}", flush=True)
        both.close()
    print(f"ms a step with truth, corridor_ccw, medians of {STEPS}: world.pymunk, world.mujoco")
    for size in SIZES:
        both = Both(MAPS / "corridor_ccw.yaml", 7, size=size)
        ours, other = step_ms(both)
        print(f"{size[0]}x{size[1]:<6}{ours:>8.1f}{other:>8.1f}", flush=True)
        both.close()


if __name__ == "__main__":
    main()
