"""Means of flow over blocks of pixels."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from graphnav import Flow
from graphnav.core.grid import block_sum, coarsen


def random_flow(rows: int, cols: int, step_px: int = 1) -> Flow:
    rng = np.random.default_rng(0)
    uv_px = rng.normal(size=(rows, cols, 2)).astype(np.float32)
    valid = (rng.random((rows, cols)) < 0.7).astype(np.uint8)
    return Flow(uv_px=uv_px, valid=valid, interval_us=100_000, step_px=step_px)


@pytest.mark.parametrize(
    ("rows", "cols", "step_px"), [(8, 12, 4), (16, 24, 8), (18, 12, 6), (7, 9, 4), (3, 2, 4), (6, 6, 2), (5, 1, 3)]
)
def test_a_block_is_the_mean_of_its_valid_vectors(rows: int, cols: int, step_px: int) -> None:
    flow = random_flow(rows, cols)
    coarse = coarsen(flow, step_px)
    assert coarse.step_px == step_px
    assert coarse.uv_px.dtype == np.float32
    for row, col in np.ndindex(coarse.valid.shape):
        block = np.s_[row * step_px : (row + 1) * step_px, col * step_px : (col + 1) * step_px]
        vectors = flow.uv_px[block][flow.valid[block] > 0]
        assert coarse.uv_px[row, col] == pytest.approx(vectors.sum(axis=0) / max(len(vectors), 1), abs=1e-5)
        assert coarse.valid[row, col] == (2 * len(vectors) >= step_px**2)


def test_a_flow_that_is_this_coarse_is_passed_on() -> None:
    flow = random_flow(6, 8, step_px=4)
    assert coarsen(flow, 4) is flow


def test_a_vector_that_is_not_valid_does_not_count_whatever_it_holds() -> None:
    flow = random_flow(8, 12)
    uv_px = np.where(flow.valid[..., None] > 0, flow.uv_px, np.float32(np.nan))
    assert np.array_equal(coarsen(replace(flow, uv_px=uv_px), 4).uv_px, coarsen(flow, 4).uv_px)


def test_a_received_flow_is_coarsened_once() -> None:
    flow = random_flow(8, 12)
    assert coarsen(flow, 4) is not coarsen(flow, 4)
    for field in (flow.uv_px, flow.valid):
        field.setflags(write=False)
    coarse = coarsen(flow, 4)
    for reader in (flow, flow.twin()):
        assert coarsen(reader, 4).uv_px is coarse.uv_px
    assert not coarse.uv_px.flags.writeable
    assert coarsen(replace(flow, interval_us=1), 4).interval_us == 1
    assert coarsen(replace(flow, valid=1 - flow.valid), 4).uv_px is not coarse.uv_px
    assert coarsen(flow, 2).step_px == 2


def test_steps_multiply() -> None:
    assert coarsen(random_flow(6, 8, step_px=2), 4).valid.shape == (3, 4)


@pytest.mark.parametrize("step_px", [1, 3, 5])
def test_a_step_that_is_no_multiple_is_refused(step_px: int) -> None:
    with pytest.raises(ValueError, match=f"every 2 px to {step_px} px"):
        coarsen(random_flow(6, 8, step_px=2), step_px)


def test_block_sums_keep_the_total() -> None:
    field = np.random.default_rng(0).random((7, 9))
    assert block_sum(field, 4).sum() == pytest.approx(field.sum())
    assert block_sum(field, 4).shape == (2, 3)
