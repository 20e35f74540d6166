"""How far vectors are likely to be off against how far they are, and one setting of the flow against two."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import bench_flow
import cv2
import flow_textures
import numpy as np
import pytest
from graphnav_flow.deviation import STEP_PX
from graphnav_flow.lucas_kanade import LucasKanade

from graphnav import Image, Stamp
from graphnav.arrays import Bytes, Doubles, Floats

if TYPE_CHECKING:
    from tests.targets import Targets

MIN_WITHIN_TWICE = 0.9
"""Of errors with the normal distribution 0.98 are; 0.63 are within the deviation itself."""
MAX_EPE_RATIO = 1.05
BORDER_PX = 16
SHIFTS_PX = (1, 3, 6)
REAL = ("brick", "gravel", "grass")
LIGHT_RATIO = 1.15

Pair = tuple[Bytes, Bytes, Doubles]


@pytest.fixture(autouse=True)
def _one_thread() -> None:
    cv2.setNumThreads(1)


@pytest.mark.parametrize("turn", bench_flow.TURNS_RADPS)
def test_deviation_of_simulated_pictures(targets: Targets, seeds: range, turn: str) -> None:
    """The share of errors within one and two of the predicted deviation, on drives through the corridor."""
    _check_shares(targets, f"simulated, {turn}", _simulated(turn, seeds))


@pytest.mark.parametrize("name", REAL)
def test_deviation_of_real_pictures(targets: Targets, name: str) -> None:
    """The same on photographs of floors that are warped by a known motion, with noise."""
    _check_shares(targets, name, _photographed(name))


def test_one_setting_is_as_good_as_the_better_of_two(targets: Targets, seeds: range) -> None:
    """Endpoint error of valid vectors by default, against never and always normalized pictures."""
    sets: dict[str, Callable[[], Sequence[Pair]]] = {
        "straight": lambda: _simulated("straight", seeds),
        "turning": lambda: _simulated("turning", seeds),
        "light steps by 15 %": lambda: [_lit(pair) for pair in _simulated("straight", seeds)],
        **{name: partial(_photographed, name) for name in REAL},
        "motorcycle": _motorcycle,
    }
    stages: dict[str, dict[str, Any]] = {
        "never": {"normalize_sigma_px": None},
        "always": {"light_ratio": 0.0},
        "default": {},
    }
    for what, pairs in sets.items():
        found = {name: _epe_px(LucasKanade(**given), pairs()) for name, given in stages.items()}
        ratio = found["default"] / min(found["never"], found["always"])
        text = ", ".join(f"{name} {epe_px:.3f} px" for name, epe_px in found.items())
        targets.check(f"EPE, {what}: {text}: ratio {ratio:.3f}, at most {MAX_EPE_RATIO}", good=ratio <= MAX_EPE_RATIO)


def _check_shares(targets: Targets, what: str, pairs: Sequence[Pair]) -> None:
    ratios = np.concatenate([_off_by_deviation(pair) for pair in pairs])
    one, two = ((ratios <= limit).mean() for limit in (1.0, 2.0))
    text = f"{what}: {one:.2f} within the deviation, {two:.2f} within twice of it, of {len(ratios)} vectors"
    targets.check(text, good=two >= MIN_WITHIN_TWICE)


def _off_by_deviation(pair: Pair) -> Doubles:
    """Return the error of each block's vector in units of its deviation, where the vector is valid."""
    before, now, true_px = pair
    stage = LucasKanade()
    stage.reset(0)
    stage.step(Image(pixels=before), Stamp(0))
    made = stage.step(Image(pixels=now), Stamp(100_000))
    assert made is not None
    blocks = np.s_[BORDER_PX:-BORDER_PX:STEP_PX, BORDER_PX:-BORDER_PX:STEP_PX]
    off_px = np.linalg.norm(made.flow.uv_px - true_px, axis=-1)[blocks]
    deviation_px = made.deviation.at(made.flow.valid.shape, 1)[blocks]
    counts = (made.flow.valid[blocks] > 0) & np.isfinite(off_px)
    return np.asarray((off_px / deviation_px)[counts])


def _epe_px(stage: LucasKanade, pairs: Sequence[Pair]) -> float:
    errors = []
    for before, now, true_px in pairs:
        stage.reset(0)
        stage.step(Image(pixels=before), Stamp(0))
        made = stage.step(Image(pixels=now), Stamp(100_000))
        assert made is not None
        off_px = np.linalg.norm(made.flow.uv_px - true_px, axis=-1)
        errors.append(off_px[(made.flow.valid > 0) & np.isfinite(off_px)].mean())
    return float(np.mean(errors))


def _simulated(turn: str, seeds: range) -> list[Pair]:
    steps = bench_flow.collect(bench_flow.TURNS_RADPS[turn], seeds)
    return [(step.before.pixels, step.now.pixels, np.asarray(step.truth.flow_px, np.float64)) for step in steps]


def _lit(pair: Pair) -> Pair:
    before, now, true_px = pair
    lit = np.clip(np.rint(LIGHT_RATIO * now.astype(np.float32)), 0, 255).astype(np.uint8)
    return before, lit, true_px


def _photographed(name: str) -> list[Pair]:
    return [pair for shift_px in SHIFTS_PX for pair in _warped(name, shift_px)]


def _warped(name: str, shift_px: float) -> list[Pair]:
    """Return parts of a photograph of a floor, each warped."""
    data = pytest.importorskip("skimage.data", reason="pip install scikit-image: its photographs are the test's data")
    picture: Floats = np.asarray(getattr(data, name)(), np.float32)
    parts = [picture[row : row + 120, col : col + 160] for row in range(0, 392, 130) for col in range(0, 352, 170)]
    return [flow_textures.warped(np.ascontiguousarray(part), k, shift_px, 1.0) for k, part in enumerate(parts)]


def _motorcycle() -> list[Pair]:
    """Return the stereo pair of a motorcycle, at a quarter of its size; its true flow is the disparity."""
    data = pytest.importorskip("skimage.data")
    left, right, disparity_px = data.stereo_motorcycle()
    size = (left.shape[1] // 4, left.shape[0] // 4)
    before, now = (
        cv2.resize(cv2.cvtColor(one, cv2.COLOR_RGB2GRAY), size, interpolation=cv2.INTER_AREA) for one in (right, left)
    )
    known = np.where(np.isfinite(disparity_px), disparity_px, np.nan).astype(np.float32)
    small_px = cv2.resize(known, size, interpolation=cv2.INTER_NEAREST) / 4
    return [(before, now, np.dstack([small_px, np.zeros_like(small_px)]).astype(np.float64))]
