"""The paper's Fig. 8, rows of I, u, v and D, and its Fig. 3, the sorted norms of the components."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
from graphnav_score.components import Components as ComponentsScore
from graphnav_view.flow_colour import flow_rgb
from graphnav_view.panels.norms_page import norms_figure
from graphnav_view.panels.separated import Norms, component_px, kinds_of, norms_of
from graphnav_view.panels.separation_rows import separation_figure
from graphnav_view.signals import Signals
from numpy.typing import ArrayLike

from graphnav import Components, Flow, Planar, Plane, Recording, Truth
from graphnav.arrays import Doubles
from graphnav.core.cli import main
from graphnav.core.run_folder import RunFolder

Record = Callable[..., Recording]
_ROWS, _COLS = 24, 32


@pytest.fixture(scope="module")
def literal(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a second of driving in a bend as the paper prints it: walls are in view."""
    folder = tmp_path_factory.mktemp("literal") / "run"
    words = ["--until", "1", "--no-pictures", "--no-tap", "--record", "all"]
    assert main(["run", "paper_literal_ccw", *words, "-o", str(folder)]) == 0
    return folder


def _components(rng: np.random.Generator, taken: int = 1) -> Components:
    alpha, beta = rng.standard_normal((2, _ROWS, _COLS, 2)).astype(np.float32)
    beta[:6, 4:20] *= 4
    valid = (rng.random((_ROWS, _COLS)) < 0.9).astype(np.uint8)
    mixing = np.array([[1.6, -0.4], [1.5, 0.1]])
    return Components(alpha, beta, mixing, np.array([0.5, 2.0]), taken, valid, 4)


def _truth() -> Truth:
    obstacle = np.zeros((4 * _ROWS, 4 * _COLS), np.uint8)
    obstacle[:20, 12:70] = 1
    depth_m = np.full(obstacle.shape, 2.0, np.float32)
    return Truth(obstacle, depth_m, np.zeros((*obstacle.shape, 2), np.float32), 100_000, 1)


def test_the_component_in_pixels_is_a_sum_of_both_flows_whose_greater_factor_is_1(literal: Path) -> None:
    with Recording(literal / RunFolder.LOG) as log:
        channels = ("plane.components", "flow.flow", "planar.planar")
        components, flow, planar = (log.message(channel, -1)[2] for channel in channels)
    assert isinstance(components, Components)
    assert isinstance(flow, Flow)
    assert isinstance(planar, Planar)
    valid = components.valid != 0
    both = np.stack([field[valid].ravel().astype(float) for field in (flow.uv_px, planar.planar_uv_px)], axis=1)
    for which in (0, 1):
        v_px = component_px(components, which).uv[valid].ravel()
        factors = np.linalg.lstsq(both, v_px, rcond=None)[0]
        assert np.abs(factors).max() == pytest.approx(1, abs=1e-3)
        assert both @ factors == pytest.approx(v_px, abs=1e-3)


@pytest.mark.parametrize("which", [0, 1])
@pytest.mark.parametrize("sign", [1, -1])
def test_the_sign_that_a_separation_leaves_open_is_that_of_the_flow(which: int, sign: int) -> None:
    found = _components(np.random.default_rng(3))
    other = Components(
        sign * found.alpha, sign * found.beta, sign * found.mixing, found.variances, found.taken, found.valid, 4
    )
    v_px = component_px(other, which).uv
    assert v_px == pytest.approx(component_px(found, which).uv)
    part_of_flow = found.mixing[0, which] * (found.alpha, found.beta)[which]
    assert (v_px * part_of_flow >= 0).all()


def test_the_norms_are_about_the_median_that_the_stage_takes(literal: Path) -> None:
    """As printed the score of a cell is ε itself, so that it gives the median away."""
    with Recording(literal / RunFolder.LOG) as log:
        signals = Signals(log)
        utime = signals.stamps(Components)[-1]
        components, plane = signals.at(Components, utime), signals.at(Plane, utime)
    assert components is not None
    assert plane is not None
    valid = components.valid != 0
    norms = norms_of(components, components.taken, plane, None)
    assert (np.diff(norms.length_px) >= 0).all()
    assert norms.median_px == np.median(norms.length_px)
    length_px = np.linalg.norm(component_px(components, components.taken).uv[valid], axis=-1)
    assert np.abs(length_px - norms.median_px) == pytest.approx(plane.score[valid], abs=1e-3)
    assert norms.is_called.sum() == plane.obstacle.sum()
    assert not norms.is_ground.any()
    assert not norms.is_obstacle.any()


def test_the_areas_are_those_of_the_score(literal: Path) -> None:
    """For cells of one pixel, each of which is ground or obstacle, both count the same."""
    score = ComponentsScore(min_obstacle_ratio=0.0, max_obstacle_ratio=1.0)
    score.reset(0)
    with Recording(literal / RunFolder.LOG) as log:
        signals = Signals(log)
        utime = signals.stamps(Components)[-1]
        components, truth = signals.at(Components, utime), signals.at(Truth, utime)
    assert components is not None
    assert truth is not None
    assert 0 < truth.obstacle.mean() < 1
    score.step(components, truth)
    areas = score.summary()
    for which, name in enumerate(("alpha_auroc", "beta_auroc")):
        norms = norms_of(components, which, None, truth)
        assert norms.auroc(about_median=True) == pytest.approx(areas[name], abs=0.005)
        assert not (norms.is_ground & norms.is_obstacle).any()


def test_norms_that_are_all_longer_on_the_obstacle_are_told_apart_by_length_only() -> None:
    norms = Norms(
        np.array([1.0, 2, 3, 4, 5]),
        3.0,
        np.array([True, True, True, False, False]),
        np.array([False, False, False, True, True]),
        np.zeros(5, np.bool_),
    )
    assert norms.auroc(about_median=False) == 1
    assert norms.auroc(about_median=True) == pytest.approx((1 + 0.5 + 3 - 0.5) / 6)
    assert norms._replace(is_ground=norms.is_called).auroc(about_median=True) is None


def test_a_cell_is_what_most_of_its_pixels_are() -> None:
    components, truth = _components(np.random.default_rng(1)), _truth()
    truth.depth_m[-4:] = np.inf
    kinds = kinds_of(truth, components)
    expected = truth.obstacle.reshape(_ROWS, 4, _COLS, 4).mean(axis=(1, 3))
    assert (kinds.obstacle == (expected > 0.5)).all()
    assert not (kinds.ground & kinds.obstacle).any()
    assert not (kinds.ground | kinds.obstacle)[-1].any()
    assert kinds.obstacle_ratio(np.ones_like(components.valid)) == pytest.approx(
        kinds.obstacle.sum() / (kinds.ground | kinds.obstacle).sum()
    )
    assert kinds_of(None, components).obstacle_ratio(components.valid) is None


def test_the_figure_of_the_norms_shows_them_and_their_median() -> None:
    components, truth = _components(np.random.default_rng(2)), _truth()
    both = [norms_of(components, which, None, truth) for which in (0, 1)]
    axes = norms_figure(both, 1, "", "").axes
    assert [axes[at].get_title(loc="left").rpartition(": ")[2] for at in (0, 3)] == [
        "low variance",
        "high variance, taken",
    ]
    for at, norms in ((0, both[0]), (3, both[1])):
        (median_line,) = axes[at].lines
        assert set(np.asarray(median_line.get_ydata()).tolist()) == {norms.median_px}
        points = np.concatenate([_points(cloud.get_offsets()) for cloud in axes[at].collections])
        place = np.rint(points[:, 0] * len(norms.length_px) - 0.5).astype(int)
        assert points[:, 1] == pytest.approx(norms.length_px[place])
        bars = [bar.get_height() for bar in axes[at + 1].patches]  # type: ignore[attr-defined]
        assert np.mean(bars) == pytest.approx(norms.is_obstacle.mean(), abs=0.01)


def _points(offsets: ArrayLike) -> Doubles:
    points: Doubles = np.asarray(offsets, float).reshape(-1, 2)
    return points


def test_the_rows_show_image_flow_component_and_plane_as_published(literal: Path) -> None:
    with Recording(literal / RunFolder.LOG) as log:
        signals = Signals(log)
        utimes = signals.stamps(Components)[3:9:5]
        figure = separation_figure(signals, utimes)
        planes = [signals.at(Plane, utime) for utime in utimes]
        flows = [signals.at(Flow, utime) for utime in utimes]
    assert len(figure.axes) == 4 * len(utimes)
    for row, (plane, flow) in enumerate(zip(planes, flows, strict=True)):
        assert plane is not None
        assert flow is not None
        drawn_u, _, drawn_d = (
            np.asarray(axes.images[0].get_array()) for axes in figure.axes[4 * row + 1 : 4 * row + 4]
        )
        assert ((drawn_d < 128) == (plane.obstacle != 0)).all()
        assert drawn_u.shape[:2] == flow.valid.shape
        gray = flow_rgb(flow.uv_px, flow.valid, 1.0)[flow.valid == 0]
        assert (drawn_u[flow.valid == 0] == gray).all()


def test_the_picture_grows_with_the_frames_and_knows_the_published_shares(
    literal: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    heights = []
    for times in (["0.3s"], ["0.3s", "0.6s"]):
        words = [word for time in times for word in ("--at", time)]
        assert main(["figure", str(literal), "--separation", *words, "-o", str(tmp_path)]) == 0
        assert capsys.readouterr().out.split() == [str(tmp_path / "separation.png")]
        picture = cv2.imread(str(tmp_path / "separation.png"))
        assert picture is not None
        heights.append(picture.shape[0])
    assert heights[1] - heights[0] == pytest.approx(120 * (0.32 + 2.0 * 0.75), abs=2)
    assert main(["figure", str(literal), "--separation", "--at", "0.5s", "--format", "svg", "-o", str(tmp_path)]) == 0
    with Recording(literal / RunFolder.LOG) as log:
        plane = Signals(log).at(Plane, 500_000)
    assert plane is not None
    text = (tmp_path / "separation.svg").read_text()
    assert f"obstacle in D {plane.obstacle_ratio:.0%}" in text
    assert "true obstacle" in text


def test_any_graph_with_the_ica_is_drawn_once_a_stage_reads_its_components(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["--until", "0.6", "--no-pictures", "--no-tap", "--set", "components+=score.components"]
    assert main(["run", "approach", *words, "-o", str(tmp_path / "run")]) == 0
    capsys.readouterr()
    assert main(["figure", str(tmp_path / "run"), "--at", "0.5s", "-o", str(tmp_path)]) == 0
    assert str(tmp_path / "norms_0.50s.png") in capsys.readouterr().out.split()
    assert main(["figure", str(tmp_path / "run"), "--separation", "--at", "0.5s", "-o", str(tmp_path)]) == 0
    assert capsys.readouterr().out.split() == [str(tmp_path / "separation.png")]


def test_a_log_without_components_says_how_to_get_them(
    record: Record, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    record(frames=12)
    assert main(["figure", str(tmp_path), "--separation", "--at", "0.5s"]) == 2
    assert capsys.readouterr().err == (
        "the log has no independent components: plane.ica publishes them where a stage reads them\n"
        "  run the graph with --set components+=score.components\n"
    )
    assert not (tmp_path / "separation.png").exists()


def test_separation_needs_times(record: Record, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    record(frames=3)
    assert main(["figure", str(tmp_path), "--separation"]) == 2
    assert capsys.readouterr().err == (
        "--separation is for frames of given times\n  add --at 2s --at 4s, or leave it out\n"
    )


def test_what_no_camera_saw_has_no_separation(
    record: Record, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    record(frames=12, without=("robot.image", "flow.flow", "plane.plane"))
    assert main(["figure", str(tmp_path), "--separation", "--at", "0.5s"]) == 2
    assert "contains nothing to draw" in capsys.readouterr().err
