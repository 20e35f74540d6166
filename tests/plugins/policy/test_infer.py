"""Messages to the inputs of a network, and messages from its outputs."""

from __future__ import annotations

import gc
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from graphnav_policy.onnx_policy import Onnx
from onnx import helper

from graphnav import Goal, Image, Latest, Motion, ParamError, Plane, Stamp, Steering, Twist, UserError
from graphnav.core.runner import memory_mb
from graphnav.core.stage import Port, ports_of
from graphnav.testing import check_stage

from .conftest import MakePolicy
from .networks import F64, U8, linear, means, network, recurrent

TWIST = {"y": ("twist.v_mps", "twist.omega_radps")}
TICK_US = 100_000


def picture(level: int, rows: int = 6, cols: int = 8) -> Image:
    """Return a picture of one gray level."""
    return Image(np.full((rows, cols), level, np.uint8))


def at(tick: int) -> Stamp:
    """Return the stamp of a tick."""
    return Stamp(tick * TICK_US)


def speeds(outputs: Any) -> tuple[float, float]:
    """Return the speeds of the command among the outputs of a step."""
    return outputs.twist.v_mps, outputs.twist.omega_radps


def test_ports_are_what_the_parameters_name() -> None:
    words = {"a": "image_left.pixels", "b": ("goal.bearing_rad", "image.step_px"), "c": 0.5}
    cls = Onnx.with_ports(inputs=words, outputs={"y": "steering.theta_rad", **TWIST}, latest=("goal",))
    ports = ports_of(cls)
    assert ports.inputs == (Port("image_left", Image), Port("goal", Goal, latest=True), Port("image", Image))
    assert ports.outputs == (Port("twist", Twist),)
    assert cls is Onnx.with_ports(inputs=dict(words), outputs={"z": ("twist.omega_radps",)}, latest=("goal",))


def test_a_number_of_a_message_becomes_a_command(make_policy: MakePolicy) -> None:
    stage = make_policy(linear(1, [[0.0, 2.0]], [0.25, 0.0]), inputs={"x": "goal.bearing_rad"}, outputs=TWIST)
    outputs = stage.step(goal=Goal(bearing_rad=0.125, distance_m=3.0), stamp=at(0))
    assert isinstance(outputs.twist, Twist)
    assert speeds(outputs) == (0.25, 0.25)


def test_several_fields_are_one_vector_in_their_order(make_policy: MakePolicy) -> None:
    fields = ("goal.distance_m", "motion.turn_rad", "goal.bearing_rad")
    stage = make_policy(linear(3, [[1, 0], [0, 10], [0, 1]], [0, 0]), inputs={"x": fields}, outputs=TWIST)
    outputs = stage.step(goal=Goal(bearing_rad=0.5, distance_m=3.0), motion=Motion(0, 0, 0.25, 1), stamp=at(0))
    assert speeds(outputs) == (3.0, 3.0)


def test_history_is_oldest_first_and_begins_with_the_first_repeated(make_policy: MakePolicy) -> None:
    stage = make_policy(means(2), inputs={"x": "image.pixels"}, outputs=TWIST, history={"x": 2})
    found = [speeds(stage.step(image=picture(10 * k), stamp=at(k))) for k in range(1, 4)]
    assert found == [(10.0, 10.0), (10.0, 20.0), (20.0, 30.0)]


def test_state_begins_with_zeros_at_each_reset_and_after_a_gap(make_policy: MakePolicy) -> None:
    stage = make_policy(recurrent(), inputs={"x": "goal.distance_m"}, outputs=TWIST, state={"h_out": "h"})

    def counts(ticks: range) -> list[float]:
        return [stage.step(goal=Goal(0.0, 7.0), stamp=at(tick)).twist.v_mps for tick in ticks]

    assert counts(range(3)) == [0, 1, 2]
    assert counts(range(50, 52)) == [0, 1], "frames are missing"
    stage.reset(seed=1)
    assert counts(range(2)) == [0, 1]


def test_history_restarts_after_a_gap(make_policy: MakePolicy) -> None:
    stage = make_policy(means(2), inputs={"x": "image.pixels"}, outputs=TWIST, history={"x": 2})
    for tick in range(4):
        stage.step(image=picture(8), stamp=at(tick))
    assert speeds(stage.step(image=picture(40), stamp=at(90))) == (40.0, 40.0)


def test_a_sampled_input_is_zeros_before_its_first_message(make_policy: MakePolicy) -> None:
    model = linear(3, [[1, 0], [1, 0], [0, 1]], [0, 0])
    fields = ("twist.v_mps", "twist.omega_radps", "goal.distance_m")
    stage = make_policy(model, inputs={"x": fields}, outputs=TWIST, latest=("twist",))
    before = stage.step(goal=Goal(0, 5), twist=Latest[Twist](), stamp=at(0))
    after = stage.step(goal=Goal(0, 5), twist=Latest(Twist(1.0, 2.0), 0.1), stamp=at(1))
    assert (speeds(before), speeds(after)) == ((0.0, 5.0), (3.0, 5.0))


def test_a_constant_fills_an_input(make_policy: MakePolicy) -> None:
    model = network(
        [helper.make_node("Concat", ["x", "top"], ["y"], axis=1)], {"x": (1, 1), "top": (1, 1)}, {"y": (1, 2)}
    )
    stage = make_policy(model, inputs={"x": "goal.distance_m", "top": 0.5}, outputs=TWIST)
    assert speeds(stage.step(goal=Goal(0, 5), stamp=at(0))) == (5.0, 0.5)


def test_a_network_gives_arrays_and_constants_the_other_fields(make_policy: MakePolicy) -> None:
    cast = helper.make_node("Cast", ["x"], ["score"], to=1)
    shape = (1, None, None)
    nodes = [cast, ("Identity", "x", "obstacle"), ("Greater", "x x", "none"), ("Not", "none", "all")]
    valid = helper.make_node("Cast", ["all"], ["valid"], to=U8)
    model = network([*nodes, valid], {"x": shape}, dict.fromkeys(("obstacle", "score", "valid"), shape),
                    types=dict.fromkeys(("x", "obstacle", "valid"), U8))  # fmt: skip
    stage = make_policy(
        model,
        inputs={"x": "image.pixels"},
        outputs={name: f"plane.{name}" for name in ("obstacle", "score", "valid")},
        constants={"plane.step_px": 1, "plane.obstacle_ratio": 0.5},
    )
    plane = stage.step(image=picture(1), stamp=at(0)).plane
    assert isinstance(plane, Plane)
    assert (plane.obstacle.shape, str(plane.score.dtype), plane.valid.min(), plane.obstacle_ratio) == (
        (6, 8),
        "float32",
        1,
        0.5,
    )


def test_fields_of_fixed_length_are_cut_from_one_output(make_policy: MakePolicy) -> None:
    fields = (
        "steering.repulsive",
        "steering.guiding",
        "steering.control",
        "steering.theta_rad",
        "steering.eigenvalues",
    )
    model = linear(1, [list(range(9))], [0.0] * 9)
    steering = (
        make_policy(model, inputs={"x": "goal.distance_m"}, outputs={"y": fields})
        .step(goal=Goal(0, 1), stamp=at(0))
        .steering
    )
    assert isinstance(steering, Steering)
    assert (steering.control.tolist(), steering.theta_rad, steering.eigenvalues.tolist()) == ([4, 5], 6, [7, 8])


def test_float32_goes_into_a_network_of_doubles(make_policy: MakePolicy) -> None:
    model = network([helper.make_node("Cast", ["x"], ["y"], to=1)], {"x": (1, 1)}, {"y": (1, 1)}, types={"x": F64})
    words = {"twist.omega_radps": 0.0}
    stage = make_policy(model, inputs={"x": "goal.distance_m"}, outputs={"y": "twist.v_mps"}, constants=words)
    assert speeds(stage.step(goal=Goal(0, 0.1), stamp=at(0)))[0] == pytest.approx(0.1)


def test_a_picture_of_another_size_is_told(make_policy: MakePolicy) -> None:
    stage = make_policy(means(2, 6, 8), inputs={"x": "image.pixels"}, outputs=TWIST, history={"x": 2})
    told = r"^the network's input 'x' takes \(1, 2, 6, 8\), but image\.pixels is \(1, 2, 12, 16\)$"
    with pytest.raises(ValueError, match=told):
        stage.step(image=picture(1, 12, 16), stamp=at(0))


def test_a_picture_that_changes_its_size_is_told(make_policy: MakePolicy) -> None:
    stage = make_policy(means(2), inputs={"x": "image.pixels"}, outputs=TWIST, history={"x": 2})
    stage.step(image=picture(1), stamp=at(0))
    told = r"^image\.pixels is \(12, 16\), and was \(6, 8\) before: the network's input 'x' takes the last 2$"
    with pytest.raises(ValueError, match=told):
        stage.step(image=picture(1, 12, 16), stamp=at(1))


def test_a_colour_picture_is_not_a_gray_one(make_policy: MakePolicy) -> None:
    stage = make_policy(means(2), inputs={"x": "image.pixels"}, outputs=TWIST, history={"x": 2})
    with pytest.raises(ValueError, match=r"takes \(1, 2, \?, \?\), but image\.pixels is \(1, 2, 6, 8, 3\)$"):
        stage.step(image=Image(np.zeros((6, 8, 3), np.uint8)), stamp=at(0))


def test_an_output_of_another_length_is_told(make_policy: MakePolicy) -> None:
    model = network([helper.make_node("Concat", ["x", "x", "x"], ["y"], axis=1)], {"x": (1, None)}, {"y": (1, None)})
    stage = make_policy(model, inputs={"x": "goal.distance_m"}, outputs=TWIST)
    told = r"^the network's output 'y' is \(1, 3\), but twist\.v_mps and twist\.omega_radps are 2 numbers$"
    with pytest.raises(ValueError, match=told):
        stage.step(goal=Goal(0, 1), stamp=at(0))


def test_an_operator_that_fails_is_told_in_one_line(make_policy: MakePolicy) -> None:
    model = network([("Reshape", "x s", "y")], {"x": (1, None)}, {"y": (1, 2)})
    shape = helper.make_tensor("s", 7, [2], [1, 2])
    model.graph.initializer.append(shape)
    stage = make_policy(model, inputs={"x": "goal.distance_m"}, outputs=TWIST)
    with pytest.raises(ValueError, match=r"^the network failed: ") as error:
        stage.step(goal=Goal(0, 1), stamp=at(0))
    assert "\n" not in str(error.value)
    assert len(str(error.value)) < 350


def test_no_integer_is_made_of_a_nan(make_policy: MakePolicy) -> None:
    model = network([("Log", "x", "y")], {"x": (1, 1)}, {"y": (1, 1)})
    stage = make_policy(
        model,
        inputs={"x": "goal.bearing_rad"},
        outputs={"y": "motion.interval_us"},
        constants={"motion.forward_m": 0, "motion.left_m": 0, "motion.turn_rad": 0},
    )
    with pytest.raises(ValueError, match=r"^interval_us is NaN, expected a number that can be rounded$"):
        stage.step(goal=Goal(-1.0, 1.0), stamp=at(0))


@pytest.mark.parametrize(("opset", "ir_version"), [(99, 9), (17, 99)])
def test_a_network_that_is_too_new_is_refused_in_one_line(make_policy: MakePolicy, opset: int, ir_version: int) -> None:
    model = linear(1, [[1.0, 0.0]], [0.0, 0.0])
    model.opset_import[0].version, model.ir_version = opset, ir_version
    with pytest.raises(ParamError) as error:
        make_policy(model, inputs={"x": "goal.bearing_rad"}, outputs=TWIST)
    assert error.value.param == "file"
    assert f"network.onnx (opset {opset}, IR version {ir_version}): " in error.value.what
    assert "\n" not in error.value.what
    assert error.value.hint == "export it with an older opset and IR version, or install a newer onnxruntime"


def test_an_operator_of_a_library_is_refused(make_policy: MakePolicy, capfd: pytest.CaptureFixture[str]) -> None:
    model = network([helper.make_node("Wish", ["x"], ["y"], domain="elsewhere")], {"x": (1, 1)}, {"y": (1, 2)})
    model.opset_import.append(helper.make_opsetid("elsewhere", 1))
    with pytest.raises(ParamError, match="cannot load"):
        make_policy(model, inputs={"x": "goal.bearing_rad"}, outputs=TWIST)
    assert capfd.readouterr() == ("", ""), "onnxruntime prints nothing of its own"


def test_it_keeps_the_contract_of_stages(make_policy: MakePolicy, tmp_path: Path) -> None:
    words: dict[str, Any] = {"inputs": {"x": "image.pixels"}, "outputs": TWIST, "history": {"x": 2}}
    make_policy(means(2), **words)
    steps = [{"image": picture(level), "stamp": at(level)} for level in range(5)]
    check_stage(Onnx, *steps, file=tmp_path / "network.onnx", **words)


def test_a_thousand_steps_take_no_more_memory(make_policy: MakePolicy) -> None:
    stage = make_policy(means(2), inputs={"x": "image.pixels"}, outputs=TWIST, history={"x": 2})
    image = picture(3, 120, 160)

    def after(ticks: range) -> float:
        for tick in ticks:
            stage.step(image=image, stamp=at(tick))
        gc.collect()
        return memory_mb()

    before_mb = after(range(200))
    assert after(range(200, 1200)) - before_mb < 4.0, "two pictures as float32 take 0.15 MB a step"


def test_without_onnxruntime_it_says_what_to_install(make_policy: MakePolicy, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "onnxruntime", None)
    with pytest.raises(UserError, match=r"policy\.onnx needs onnxruntime\n  pip install 'onnxruntime>=1\.19'"):
        make_policy(linear(1, [[1.0, 0.0]], [0.0, 0.0]), inputs={"x": "goal.bearing_rad"}, outputs=TWIST)
