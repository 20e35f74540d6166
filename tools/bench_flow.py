"""Measure the flow estimators against the simulator's truth and against OpenCV's Farneback, in one process.

``python tools/bench_flow.py [first seed] [seeds]`` prints for each image size, for straight, gentle and fast turning
drives, the mean endpoint error of every estimator and its share of Farneback's, then the time of a step and its share
of ``cv2.calcOpticalFlowFarneback``'s with the tutorial's parameters on the same frames, beside those of the bare
functions that ``flow.dis`` and ``flow.farneback`` call. Times are medians of the thread's own processor time, so that
other programs do not count; one thread.
"""

from __future__ import annotations

import itertools
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from graphnav_flow.dis import Dis
from graphnav_flow.farneback import Farneback
from graphnav_flow.lucas_kanade import LucasKanade
from graphnav_world.world import Pymunk
from taking_turns import Ratio, Turns, load_told, take_turns, timed
from testbed.flows import flow_from

from graphnav import Finished, Image, Latest, Stage, Stamp, Truth, Twist
from graphnav.arrays import Bytes

MAP = Path(__file__).parents[1] / "graphs" / "graphnav_graphs" / "maps" / "corridor_ccw.yaml"
TURNS_RADPS = {"straight": 0.0, "gentle": 0.5, "turning": 1.5}
SIZES = ((160, 120), (320, 240), (640, 480))
"""Columns and rows."""

SPEED_MPS = 0.3
PERIOD_US = 100_000
WARM_UP_FRAMES = 6
FRAMES = 40


@dataclass(frozen=True)
class Step:
    """Two consecutive frames and the truth of the later one."""

    before: Image
    now: Image
    truth: Truth


def estimators() -> dict[str, Stage]:
    """Return the compared stages; the first is the reference of all ratios."""
    return {
        "farneback": Farneback(),
        "farneback wide": Farneback(window_px=21, iterations=5, expansion_px=7, expansion_sigma_px=1.5),
        "lucas_kanade": LucasKanade(),
        "dis medium": Dis(),
        "dis fast": Dis(preset="fast"),
    }


def drive(seed: int, turn_radps: float, frames: int = FRAMES, size: tuple[int, int] = SIZES[0]) -> Iterator[Step]:
    """Yield what the world shows at 0.3 m/s, 10 Hz while the robot turns at a constant rate, until it touches."""
    world = Pymunk(map=MAP, size=size)
    world.reset(seed)
    command = Latest(Twist(v_mps=SPEED_MPS, omega_radps=turn_radps), age_s=0.0)
    before: Image | None = None
    for frame in range(WARM_UP_FRAMES + frames):
        try:
            shown = world.step(command, Stamp(frame * PERIOD_US))
        except Finished:
            break
        if before is not None and shown.truth is not None and frame >= WARM_UP_FRAMES:
            yield Step(before, shown.image, shown.truth)
        before = shown.image
    world.close()


def collect(turn_radps: float, seeds: Sequence[int], every: int = 4, size: tuple[int, int] = SIZES[0]) -> list[Step]:
    """Return every so many steps of one drive a seed, turning left and right alternately."""
    return [
        step
        for seed in seeds
        for step in itertools.islice(drive(seed, turn_radps * (-1) ** seed, size=size), 0, None, every)
    ]


def endpoint_error_px(stage: Stage, steps: Sequence[Step]) -> float:
    """Return the mean length of the error of all vectors, valid or not."""
    errors = []
    for step in steps:
        stage.reset(0)
        stage.step(step.before, Stamp(0))  # type: ignore[attr-defined]
        flow = flow_from(stage, step.now, Stamp(PERIOD_US))
        errors.append(np.linalg.norm(flow.uv_px - step.truth.flow_px, axis=-1).mean())
    return float(np.mean(errors))


def step_times(stages: dict[str, Stage], steps: Sequence[Step], rounds: int = 60) -> Turns:
    """Return the processor time of a step of each stage, taking turns with OpenCV's own functions.

    Those are "cv2", bare Farneback with the tutorial's parameters, and "cv2 dis", bare DIS with its medium preset.
    """
    dis = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_MEDIUM)
    bare: dict[str, Callable[[Bytes, Bytes], object]] = {
        "cv2": lambda now, before: cv2.calcOpticalFlowFarneback(now, before, None, 0.5, 3, 15, 3, 5, 1.2, 0),
        "cv2 dis": lambda now, before: dis.calc(now, before, None),
    }
    for stage in stages.values():
        stage.reset(0)
    rivals = {name: _calls(steps, function) for name, function in bare.items()}
    rivals |= {name: _calls(steps, stage) for name, stage in stages.items()}
    return take_turns(rivals, rounds - 2, warm_up=2)


def _calls(steps: Sequence[Step], called: Stage | Callable[[Bytes, Bytes], object]) -> Callable[[], float]:
    """Return a rival that gives one step after another to a stage, or both its pictures to a function."""
    turns = itertools.count()

    def call() -> None:
        turn = next(turns)
        step = steps[turn % len(steps)]
        if isinstance(called, Stage):
            called.step(step.now, Stamp(turn * PERIOD_US))  # type: ignore[attr-defined]
        else:
            called(step.now.pixels, step.before.pixels)

    return timed(call, time.thread_time)


def time_ratios(size: tuple[int, int], seeds: Sequence[int]) -> dict[str, Ratio]:
    """Return each step's share of the time of bare Farneback at ``size``, on straight drives.

    "dis / cv2" and "farneback / cv2" are relative to the bare function that the stage calls.
    """
    stages = {
        name: stage for name, stage in estimators().items() if name in ("lucas_kanade", "dis medium", "farneback")
    }
    turns = step_times(stages, collect(0.0, seeds, size=size), rounds=60 * SIZES[0][0] // size[0])
    ratios = {name: turns.ratio(name, "cv2") for name in stages}
    return ratios | {"dis / cv2": turns.ratio("dis medium", "cv2 dis"), "farneback / cv2": ratios["farneback"]}


def main(first_seed: int = 0, seeds: int = 10) -> None:
    """Print the results of ``seeds`` drives from ``first_seed``."""
    cv2.setNumThreads(1)
    stages = estimators()
    for size in SIZES:
        # A larger image has more vectors: fewer frames give as certain a mean.
        every = 4 * size[0] // SIZES[0][0]
        shown = {
            name: collect(turn, range(first_seed, first_seed + seeds), every, size)
            for name, turn in TURNS_RADPS.items()
        }
        for name, steps in shown.items():
            print(f"{size[0]}x{size[1]}, {name}: {len(steps)} frames, endpoint error in px (share of Farneback's)")
            errors = {stage_name: endpoint_error_px(stage, steps) for stage_name, stage in stages.items()}
            for stage_name, error in errors.items():
                print(f"  {stage_name:16} {error:6.3f}  ({error / errors['farneback']:.2f})")
        turns = step_times(stages, shown["straight"], rounds=60 * SIZES[0][0] // size[0])
        print(f"{size[0]}x{size[1]}: time of a step in ms (share of cv2.calcOpticalFlowFarneback's)")
        for name in turns.costs:
            print(f"  {name:16} {1e3 * turns.median(name):6.2f}  ({turns.ratio(name, 'cv2')})")


if __name__ == "__main__":
    with load_told():
        main(*map(int, sys.argv[1:]))
