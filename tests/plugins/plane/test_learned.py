"""The learned detector: its file, its network against scikit-learn's, its inputs, and that it sees."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from graphnav_plane.learned import Learned
from graphnav_plane.learning.features import NAMES, Features
from graphnav_plane.learning.model_file import LearnedModel, Network, read_model, write_model
from graphnav_plane.one_gain import OneGain
from sklearn.neural_network import MLPClassifier

from graphnav import ParamError, Planar, Stamp
from graphnav.core.graph.find import shipped_folder

if TYPE_CHECKING:
    from tests.plugins.plane.conftest import Scenes

SHIPPED = shipped_folder() / "models" / "learned_160x120.npz"


def network_of(sizes: tuple[int, ...] = (len(NAMES), 5, 1), seed: int = 0) -> Network:
    rng = np.random.default_rng(seed)
    return Network(
        mean=rng.normal(size=sizes[0]).astype(np.float32),
        scale=rng.uniform(0.5, 2, sizes[0]).astype(np.float32),
        weights=tuple(rng.normal(size=shape).astype(np.float32) for shape in pairwise(sizes)),
        biases=tuple(rng.normal(size=size).astype(np.float32) for size in sizes[1:]),
    )


def model_of(network: Network | None = None) -> LearnedModel:
    return LearnedModel(network or network_of(), (30, 40), 4, {"seeds": [1, 2]})


def learned(path: Path = SHIPPED, **params: Any) -> Learned:
    stage = Learned(model=path, **params)
    stage.reset(0)
    return stage


@pytest.mark.filterwarnings("ignore:Stochastic Optimizer")
def test_the_network_computes_what_scikit_learns_does() -> None:
    rng = np.random.default_rng(0)
    features = rng.normal(size=(500, 4)).astype(np.float32)
    classifier = MLPClassifier((6, 3), max_iter=5, random_state=0).fit(features, features[:, 0] * features[:, 1] > 0)
    weights, biases = (tuple(a.astype(np.float32) for a in x) for x in (classifier.coefs_, classifier.intercepts_))
    network = Network(np.zeros(4, np.float32), np.ones(4, np.float32), weights, biases)
    probability = classifier.predict_proba(features)[:, 1]
    assert 1 / (1 + np.exp(-network.log_odds(features))) == pytest.approx(probability, abs=1e-5)


def test_features_that_were_never_taught_stay_finite() -> None:
    features = np.array([[1e30] * len(NAMES), [-1e30] * len(NAMES)], np.float32)
    assert np.isfinite(network_of().log_odds(features)).all()


def test_a_written_model_is_read_again_and_the_same_one_has_the_same_bytes(tmp_path: Path) -> None:
    for name in ("one.npz", "other.npz"):
        write_model(tmp_path / name, model_of())
    assert (tmp_path / "one.npz").read_bytes() == (tmp_path / "other.npz").read_bytes()
    read, written = read_model(tmp_path / "one.npz"), model_of()
    assert (read.shape, read.step_px, read.about["seeds"]) == ((30, 40), 4, [1, 2])
    for one, other in zip(
        (read.network.mean, *read.network.weights, *read.network.biases),
        (written.network.mean, *written.network.weights, *written.network.biases),
        strict=True,
    ):
        assert np.array_equal(one, other)


def test_a_file_that_does_not_exist_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ParamError, match=r"cannot read .*none\.npz: No such file"):
        read_model(tmp_path / "none.npz")
    with pytest.raises(ParamError, match=r"cannot read .*: Is a directory"):
        read_model(tmp_path)


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04", b"\x80\x04N.", b"[1, 2]"])
def test_another_file_is_refused(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "file.npz").write_bytes(content)
    with pytest.raises(ParamError, match="is not a learned model"):
        read_model(tmp_path / "file.npz")


def test_a_damaged_file_is_refused_or_gives_finite_scores(tmp_path: Path) -> None:
    write_model(tmp_path / "model.npz", model_of())
    content = (tmp_path / "model.npz").read_bytes()
    rng = np.random.default_rng(0)
    refused = 0
    for number in range(60):
        damaged = bytearray(content[: len(content) // 2] if number % 2 else content)
        damaged[rng.integers(len(damaged))] ^= 0xFF
        (tmp_path / "model.npz").write_bytes(bytes(damaged))
        try:
            network = read_model(tmp_path / "model.npz").network
            assert np.isfinite(network.log_odds(np.ones((2, len(NAMES)), np.float32))).all()
        except ParamError:
            refused += 1
    assert refused >= 30, "every one that is cut"


@pytest.mark.parametrize(
    ("network", "message"),
    [
        (network_of((3, 5, 1)), "do not fit together"),
        (network_of((len(NAMES), 5, 2)), "do not fit together"),
        (replace(network_of(), biases=network_of((len(NAMES), 4, 1)).biases), "do not fit together"),
        (replace(network_of(), scale=np.zeros(len(NAMES), np.float32)), "do not fit together"),
        (replace(network_of(), mean=np.full(len(NAMES), np.nan, np.float32)), "not finite float32"),
        (replace(network_of(), mean=np.zeros(len(NAMES), float)), "not finite float32"),
        (replace(network_of(), biases=network_of().biases[:1]), "lacks biases_1"),
    ],
)
def test_arrays_that_do_not_fit_are_refused(tmp_path: Path, network: Network, message: str) -> None:
    write_model(tmp_path / "model.npz", model_of(network))
    with pytest.raises(ParamError, match=message):
        read_model(tmp_path / "model.npz")


def test_other_features_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("graphnav_plane.learning.model_file.FORMAT", 0)
    write_model(tmp_path / "model.npz", model_of())
    monkeypatch.undo()
    with pytest.raises(ParamError, match="taught by another version"):
        read_model(tmp_path / "model.npz")


def test_nothing_is_unpickled(tmp_path: Path) -> None:
    np.savez(tmp_path / "model.npz", about=np.array([{"format": 1}], object))
    with pytest.raises(ParamError, match="is not a learned model"):
        read_model(tmp_path / "model.npz")


def test_features_are_what_their_names_say(scenes: Scenes) -> None:
    scene = scenes.scene(0.25, gain=0.8, noise_px=0.0)
    found, valid, step_px = Features().of(scene.flow, scene.planar, 6)
    column = dict(zip(NAMES, found.T, strict=True))
    assert (found.shape, step_px) == ((1200, len(NAMES)), 4)
    assert valid.all()
    assert column["gain"] == pytest.approx(0.8, abs=1e-3)
    assert column["flow_down_px"] == pytest.approx(scene.flow.uv_px[..., 1].ravel())
    assert column["planar_down_px"] == pytest.approx(0.8 * scene.planar.planar_uv_px[..., 1].ravel(), abs=0.01)
    left = np.hypot(column["left_right_px"], column["left_down_px"])
    assert column["left_px"] == pytest.approx(left)
    assert column["remembered_px"] == pytest.approx(left), "of the first frame"
    rows, cols = column["row"].reshape(30, 40), column["col"].reshape(30, 40)
    assert (rows[0, 0], rows[-1, 0], cols[0, 0], cols[0, -1]) == pytest.approx((-29 / 30, 29 / 30, -39 / 40, 39 / 40))
    inner = column["left_px"].reshape(30, 40)[10:13, 34:37].mean()
    assert column["remembered_3x3_px"].reshape(30, 40)[11, 35] == pytest.approx(inner, abs=1e-6)


def test_cells_that_are_not_valid_change_nothing(scenes: Scenes) -> None:
    scene = scenes.scene(0.25)
    valid = scene.flow.valid.copy()
    valid[-4:] = 0
    rubbish = scene.flow.uv_px.copy()
    rubbish[-4:] = 1e6
    one, other = (
        learned().step(replace(scene.flow, valid=valid, uv_px=uv_px), scene.planar, Stamp(0))
        for uv_px in (scene.flow.uv_px, rubbish)
    )
    assert np.array_equal(one.score, other.score)
    assert not one.valid[-4:].any()
    assert not one.obstacle[-4:].any()


def test_another_grid_is_refused(scenes: Scenes) -> None:
    uv_px = scenes.floor(3.0, 0.0, 15, 20)
    flow, planar = scenes.flow(uv_px), scenes.planar(uv_px)
    with pytest.raises(ValueError, match="model is 40x30 cells of 4 px, but the planar flow is 20x15 cells of 4 px"):
        learned().step(flow, planar, Stamp(0))


@pytest.mark.parametrize("vectors", [0, 5])
def test_fewer_than_six_vectors_are_not_judged(scenes: Scenes, vectors: int) -> None:
    scene = scenes.scene(0.25)
    valid = np.zeros((30, 40), np.uint8)
    valid.flat[:vectors] = 1
    plane = learned().step(replace(scene.flow, valid=valid), scene.planar, Stamp(0))
    assert not plane.valid.any()
    assert not plane.obstacle.any()


def test_a_higher_threshold_marks_less(scenes: Scenes) -> None:
    scene = scenes.scene(0.25)
    planes = [learned(threshold_ratio=ratio).step(scene.flow, scene.planar, Stamp(0)) for ratio in (0.1, 0.5, 0.99)]
    shares = [plane.obstacle_ratio for plane in planes]
    assert shares == sorted(shares, reverse=True)
    assert all(np.array_equal(plane.obstacle > 0, plane.score > plane.threshold) for plane in planes)
    assert np.array_equal(planes[0].score, planes[2].score)


def test_the_shipped_model_is_small_and_says_where_it_comes_from() -> None:
    model = read_model(SHIPPED)
    assert SHIPPED.stat().st_size < 200_000
    assert (model.shape, model.step_px) == ((30, 40), 4)
    assert all(drive["seed"] < 1000 for drive in model.about["drives"])
    assert {"graphnav", "sklearn", "numpy"} <= model.about["versions"].keys()
    assert model.about["auroc"]["judging"] > 0.98


def test_the_shipped_model_tells_a_wall_from_the_floor(scenes: Scenes) -> None:
    scene, found = scenes.scene(0.25, noise_px=0.03), {}
    reference = OneGain()
    reference.reset(0)
    for stage in (learned(), reference):
        found[type(stage)] = stage.step(scene.flow, scene.planar, Stamp(0)).obstacle > 0
    for mask in found.values():
        assert mask[scene.obstacle].mean() > 0.8
        assert mask[~scene.obstacle].mean() < 0.05


def test_it_is_fed_like_the_residual(scenes: Scenes) -> None:
    planar: Planar = replace(scenes.scene().planar, interval_us=50_000)
    with pytest.raises(ValueError, match="planar flow covers 50000 us, but the flow 100000 us"):
        learned().step(scenes.scene().flow, planar, Stamp(0))
