"""Metrics of a detector, worked by hand and against scikit-learn."""

from __future__ import annotations

import tracemalloc
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from graphnav_score.plane import Plane as PlaneScore
from sklearn.metrics import balanced_accuracy_score, jaccard_score, roc_auc_score

from graphnav import Plane, Truth

MakeTruth = Callable[..., Truth]
MakePlane = Callable[..., Plane]


def score_of(**parameters: float) -> PlaneScore:
    stage = PlaneScore(**parameters)
    stage.reset(seed=0)
    return stage


def test_metrics_are_scikit_learns_over_pooled_pixels(make_plane: MakePlane, make_truth: MakeTruth) -> None:
    rng = np.random.default_rng(0)
    stage, scores, truths = score_of(), [], []
    for share in (0.0, 0.1, 0.2):
        true = rng.random((24, 32)) < share
        true[4:12, 4:20] = True
        score = rng.random((6, 8)) * 0.7 + 0.3 * true[::4, ::4]
        valid = rng.random((6, 8)) < 0.8
        stage.step(make_plane(score, valid, step_px=4), make_truth(true))
        seen = np.kron(valid, np.ones((4, 4))).astype(bool)
        scores.append(np.kron(score, np.ones((4, 4)))[seen])
        truths.append(true[seen])
    pooled, is_obstacle = np.concatenate(scores), np.concatenate(truths)
    called = pooled > 0.5
    metrics = stage.summary()
    assert metrics["frames"] == 3
    assert metrics["auroc"] == pytest.approx(roc_auc_score(is_obstacle, pooled), abs=1e-3)
    assert metrics["balanced_accuracy_ratio"] == pytest.approx(balanced_accuracy_score(is_obstacle, called))
    assert metrics["iou_ratio"] == pytest.approx(jaccard_score(is_obstacle, called))
    assert metrics["false_obstacle_ratio"] == pytest.approx(called[~is_obstacle].mean())
    assert metrics["judged_ratio"] == pytest.approx(len(pooled) / (3 * 24 * 32))


def test_all_frames_with_motion_and_all_pixels_are_told_too(make_plane: MakePlane, make_truth: MakeTruth) -> None:
    rng = np.random.default_rng(4)
    stage, scores, called, truths, counted, unjudged = score_of(), [], [], [], 0, 0
    for rows, uv_px in ((0, (1.0, 0.0)), (1, (1.0, 0.0)), (4, (1.0, 0.0)), (16, (1.0, 0.0)), (4, (0.0, 0.0))):
        true = np.zeros((24, 32), np.bool_)
        true[:rows, :16] = True
        score = rng.random((24, 32)) * 0.7 + 0.3 * true
        valid = rng.random((24, 32)) < 0.8
        stage.step(make_plane(score, valid), make_truth(true, uv_px))
        if any(uv_px):
            counted += 0.05 <= true.mean() <= 0.5
            unjudged += int((true & ~valid).sum())
            scores.append(np.where(valid, score, -1.0))
            called.append(valid & (score > 0.5))
            truths.append(true)
    is_obstacle = np.concatenate(truths).ravel()
    metrics = stage.summary()
    assert metrics["counted_frames_ratio"] == counted / 4
    assert 0 < counted < 4
    assert metrics["unjudged_obstacle_ratio"] == pytest.approx(unjudged / is_obstacle.sum())
    area = roc_auc_score(is_obstacle, np.concatenate(scores).ravel())
    assert metrics["auroc_all"] == pytest.approx(area, abs=1e-3)
    accuracy = balanced_accuracy_score(is_obstacle, np.concatenate(called).ravel())
    assert metrics["balanced_accuracy_all_ratio"] == pytest.approx(accuracy)


def test_frames_counted_together_are_those_counted_one_by_one(make_plane: MakePlane, make_truth: MakeTruth) -> None:
    rng = np.random.default_rng(3)
    together, one_by_one = score_of(min_obstacle_ratio=0.1), score_of(min_obstacle_ratio=0.1)
    for shape in ((60, 80),) * 16 + ((30, 40),) * 3:
        true = np.kron(rng.random(shape) < rng.choice([0.0, 0.05, 0.3]), np.ones((2, 2)))
        frame = make_plane(rng.random(shape), rng.random(shape) < 0.8, step_px=2), make_truth(true)
        together.step(*frame)
        one_by_one.step(*frame)
        one_by_one.summary()
    assert together.summary() == one_by_one.summary()
    assert 0 < together.summary()["frames"] < 19


def test_what_lies_above_the_horizon_counts_neither_way(make_plane: MakePlane, make_truth: MakeTruth) -> None:
    rng = np.random.default_rng(2)
    true = np.zeros((16, 32))
    true[10:14, 4:20] = 1
    score = rng.random((6, 8))
    horizon = make_truth(np.concatenate([np.zeros((8, 32)), true]))
    horizon.depth_m[:8] = np.inf
    cut, complete = score_of(), score_of()
    cut.step(make_plane(score[2:], step_px=4), make_truth(true))
    complete.step(make_plane(score, step_px=4), horizon)
    assert complete.summary() == cut.summary()


def test_merged_scores_are_those_of_all_frames(make_plane: MakePlane, make_truth: MakeTruth) -> None:
    rng = np.random.default_rng(1)
    complete, halves = score_of(), (score_of(), score_of())
    for half in halves:
        for _ in range(3):
            true = np.zeros((24, 32))
            true[4:12, 4:20] = 1
            plane = make_plane(rng.random((6, 8)), rng.random((6, 8)) < 0.8, step_px=4)
            complete.step(plane, make_truth(true))
            half.step(plane, make_truth(true))
    halves[0].merge(halves[1])
    merged, expected = dict(halves[0].summary()), dict(complete.summary())
    assert abs(merged.pop("flicker_ratio") - expected.pop("flicker_ratio")) < 0.2, "one pair of frames is not compared"
    assert merged == expected


def test_truth_itself_scores_full_marks(make_plane: MakePlane, make_truth: MakeTruth) -> None:
    true = np.zeros((12, 16))
    true[:4] = 1
    stage = score_of()
    stage.step(make_plane(true), make_truth(true))
    stage.step(make_plane(true), make_truth(true))
    metrics = stage.summary()
    for name in ("auroc", "recall_at_5_false_alarms_ratio", "balanced_accuracy_ratio", "iou_ratio", "judged_ratio"):
        assert metrics[name] == 1.0
    assert metrics["false_obstacle_ratio"] == metrics["flicker_ratio"] == 0.0


@pytest.mark.parametrize(("rows", "counts"), [(1, False), (2, True), (10, True), (11, False)])
def test_frames_count_by_their_true_share(
    make_plane: MakePlane, make_truth: MakeTruth, rows: int, counts: bool
) -> None:
    true = np.zeros((20, 10))
    true[:rows] = 1
    stage = score_of(min_obstacle_ratio=0.1, max_obstacle_ratio=0.5)
    stage.step(make_plane(true), make_truth(true))
    assert stage.summary()["frames"] == counts


@pytest.mark.parametrize(("uv_px", "counts"), [((0.0, 0.0), False), ((0.0, -0.09), False), ((0.0, -0.11), True)])
def test_frames_in_which_nothing_moves_do_not_count(
    make_plane: MakePlane, make_truth: MakeTruth, uv_px: tuple[float, float], counts: bool
) -> None:
    true = np.zeros((20, 10))
    true[:5] = 1
    stage = score_of()
    stage.step(make_plane(true), make_truth(true, uv_px))
    assert stage.summary()["frames"] == counts


def test_a_frame_counts_for_what_moves_past_a_robot_that_stands(make_plane: MakePlane, make_truth: MakeTruth) -> None:
    true = np.zeros((20, 10))
    true[:5] = 1
    uv_px = np.zeros((*true.shape, 2), np.float32)
    uv_px[:5] = 1.0, 0.0
    stage = score_of()
    stage.step(make_plane(true), replace(make_truth(true), flow_px=uv_px))
    assert stage.summary()["frames"] == 1


def test_frames_without_obstacle_count_for_false_obstacle(make_plane: MakePlane, make_truth: MakeTruth) -> None:
    stage = score_of()
    score = np.zeros((10, 10))
    score[0, :3] = 1.0
    stage.step(make_plane(score), make_truth(np.zeros((10, 10))))
    assert stage.summary() == {
        "frames": 0.0,
        "counted_frames_ratio": 0.0,
        "false_obstacle_ratio": pytest.approx(0.03),
    }


def test_frames_that_count_anyway_do_not_count_twice(make_plane: MakePlane, make_truth: MakeTruth) -> None:
    stage = score_of(min_obstacle_ratio=0.0)
    score = np.zeros((10, 10))
    score[0, :3] = 1.0
    stage.step(make_plane(score), make_truth(np.zeros((10, 10))))
    true = np.zeros((10, 10))
    true[:5] = 1
    stage.step(make_plane(true), make_truth(true))
    assert stage.summary()["false_obstacle_ratio"] == pytest.approx(3 / 150)


def test_flicker_counts_changes_that_the_truth_did_not_make(make_plane: MakePlane, make_truth: MakeTruth) -> None:
    stage = score_of()
    before, after = np.zeros((10, 10)), np.zeros((10, 10))
    before[0] = after[0] = after[1] = 1.0  # the truth moved on by a row
    seen = after.copy()
    seen[5, :4] = 1.0  # and this is noise
    stage.step(make_plane(before), make_truth(before))
    stage.step(make_plane(seen), make_truth(after))
    assert stage.summary()["flicker_ratio"] == pytest.approx(4 / 90)


def test_cells_at_the_rim_speak_for_what_is_there(make_plane: MakePlane, make_truth: MakeTruth) -> None:
    true = np.zeros((10, 9))
    true[8:] = 1
    score = np.zeros((3, 3))
    score[2] = 1.0
    stage = score_of()
    stage.step(make_plane(score, step_px=4), make_truth(true))
    assert stage.summary()["iou_ratio"] == 1.0


@pytest.mark.parametrize(("shape", "step_px"), [((3, 3), 4), ((24, 32), 2), ((8, 12), 3)])
def test_grid_of_another_image_is_refused(
    make_plane: MakePlane, make_truth: MakeTruth, shape: tuple[int, int], step_px: int
) -> None:
    with pytest.raises(ValueError, match=f"a grid of {shape[1]}x{shape[0]} cells of {step_px} px cannot"):
        score_of().step(make_plane(np.zeros(shape), step_px=step_px), make_truth(np.zeros((24, 32))))


def test_what_is_not_defined_is_left_out(make_plane: MakePlane, make_truth: MakeTruth) -> None:
    stage = score_of()
    assert stage.summary() == {"frames": 0.0}
    half = np.zeros((10, 10))
    half[:5] = 1
    stage.step(make_plane(np.zeros((10, 10)), valid=np.zeros((10, 10))), make_truth(half))
    assert stage.summary() == {
        "frames": 1.0,
        "counted_frames_ratio": 1.0,
        "judged_ratio": 0.0,
        "auroc_all": 0.5,
        "balanced_accuracy_all_ratio": 0.5,
        "unjudged_obstacle_ratio": 1.0,
    }


def test_memory_does_not_grow_with_the_run(make_plane: MakePlane, make_truth: MakeTruth) -> None:
    rng = np.random.default_rng(0)
    true = np.zeros((24, 32))
    true[:6] = 1
    truth, stage = make_truth(true), score_of()

    def drive(frames: int) -> None:
        for _ in range(frames):
            stage.step(make_plane(rng.random((6, 8)), step_px=4), truth)

    drive(5)
    tracemalloc.start()
    drive(5)
    few = tracemalloc.get_traced_memory()[0]
    drive(200)
    many = tracemalloc.get_traced_memory()[0]
    tracemalloc.stop()
    assert many - few < 20_000
