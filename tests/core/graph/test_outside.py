"""Inputs from other programs are consumed like any other channel; outputs have a type, a guard and a stop."""

from collections.abc import Callable
from pathlib import Path

import graphnav_lcm
import pytest

from graphnav.core.codec import codec_of
from graphnav.core.errors import UserError
from graphnav.core.graph import Graph
from graphnav.core.graph.wiring.stop_message import stop_fields
from graphnav.core.messages import Image, Motion

Load = Callable[..., Graph]

LIVE = """\
inputs:
  camera.image: {channel: CAMERA, type: graphnav_lcm.image_t, max_age_s: 0.25}
  base.motion: {channel: MOTION, type: toy.odometer_t}
stages:
  flow: {use: toy.matcher, in: {image: camera}}
  plane: {use: toy.detector, in: {flow: flow.flow}, deadline_ms: 20}
  wheels: {use: toy.wheels, in: {plane: plane.plane}}
  guard: {use: toy.guard, in: {command: wheels.twist, plane: plane.plane}, every_ms: 50}
  score: {use: toy.score, in: {plane: plane.plane, motion: base.motion}}
outputs:
  guard.twist: {channel: BASE_CMD, motor: true}
  plane.plane: {channel: PLANE, max_age_s: 2}
queues: {plane.flow: {keep: all}, wheels.plane: {keep: 4}}
"""


def test_an_input_is_a_channel_like_any_other(load: Load) -> None:
    graph = load(LIVE)
    assert graph.is_live
    assert graph.sources == ()
    assert [node.name for node in graph.order] == ["flow", "plane", "wheels", "guard", "score"]
    channel = graph.channels["camera.image"]
    assert (channel.ref, channel.name, channel.message) == ("camera.image", "camera.image", Image)
    assert graph.node("flow").inputs[0].channel is channel
    assert graph.notices == ()


def test_an_input_knows_its_type_on_the_wire(load: Load) -> None:
    graph = load(LIVE)
    camera, base = graph.inputs["camera.image"], graph.inputs["base.motion"]
    assert (camera.name, camera.type_name, camera.adapter) == ("CAMERA", "graphnav_lcm.image_t", None)
    assert (camera.lcm_class, camera.max_age_s, camera.log) == (graphnav_lcm.image_t, 0.25, None)
    assert base.channel.message is Motion
    assert base.adapter is not None
    motion = base.adapter.from_lcm({"v_mps": 1.0, "omega_radps": 0.5})
    assert isinstance(motion, Motion)
    assert motion.forward_m == 1.0
    assert base.max_age_s is None


def test_a_stage_keeps_its_times_and_inputs_their_queues(load: Load) -> None:
    graph = load(LIVE)
    assert (graph.node("guard").every_ms, graph.node("guard").deadline_ms) == (50, None)
    assert (graph.node("plane").every_ms, graph.node("plane").deadline_ms) == (None, 20)
    assert graph.queues == {"plane.flow": None, "wheels.plane": 4}


def test_an_output_leaves_in_the_type_of_its_message_if_nothing_else_is_said(load: Load) -> None:
    outputs = load(LIVE).outputs
    guard, plane = outputs["guard.twist"], outputs["plane.plane"]
    assert (guard.name, guard.type_name, guard.lcm_class) == ("BASE_CMD", "graphnav_lcm.twist_t", graphnav_lcm.twist_t)
    assert (guard.motor, guard.max_age_s, guard.stop, guard.adapter) == (True, 0.5, None, None)
    assert (plane.motor, plane.max_age_s) == (False, 2)


def test_the_stop_of_a_twist_is_standing_still(load: Load) -> None:
    guard = load(LIVE).outputs["guard.twist"]
    assert stop_fields(guard, guard.stop, 5, 7) == {"utime": 5, "seq": 7, "v_mps": 0.0, "omega_radps": 0.0}


def test_the_stop_of_another_type_is_what_its_adapter_makes(load: Load) -> None:
    sent = load(LIVE.replace("BASE_CMD,", "BASE_CMD, type: toy.wheels_t,")).outputs["guard.twist"]
    assert (sent.type_name, sent.lcm_class) == ("toy.wheels_t", graphnav_lcm.stop_t)
    fields = stop_fields(sent, sent.stop, 5)
    assert fields["engaged"] is True
    assert codec_of(sent.lcm_class).decode(codec_of(sent.lcm_class).encode(fields))["utime"] == 5


def test_the_stop_that_a_graph_gives_needs_neither_stamp_nor_number(load: Load) -> None:
    text = LIVE.replace("BASE_CMD, motor: true", "BASE_CMD, motor: true, stop: {v_mps: 0, omega_radps: 0}")
    sent = load(text).outputs["guard.twist"]
    fields = stop_fields(sent, sent.stop, 5, 7)
    assert codec_of(sent.lcm_class).decode(codec_of(sent.lcm_class).encode(fields)) == {
        "utime": 5, "seq": 7, "v_mps": 0.0, "omega_radps": 0.0,
    }  # fmt: skip


def test_an_output_may_have_the_name_of_its_own_channel(load: Load) -> None:
    assert load(LIVE.replace("BASE_CMD", "guard.twist")).outputs["guard.twist"].name == "guard.twist"


def test_a_log_is_found_beside_the_graph_and_its_channel_is_the_reference(load: Load, tmp_path: Path) -> None:
    (tmp_path / "past.lcmlog").touch()
    text = LIVE.replace("channel: CAMERA", "log: past.lcmlog").replace(
        "channel: MOTION", "log: past.lcmlog, channel: M"
    )
    inputs = load(text).inputs
    assert inputs["camera.image"].log == tmp_path / "past.lcmlog"
    assert inputs["camera.image"].log_written == Path("past.lcmlog")
    assert inputs["camera.image"].name == "camera.image"
    assert inputs["base.motion"].name == "M"


def test_without_inputs_a_graph_says_what_lockstep_does_not_use(load: Load) -> None:
    text = LIVE[LIVE.index("stages:") :].replace("in: {image: camera}", "in: {image: robot.image}")
    text = text.replace("base.motion", "robot.motion").replace("stages:", "stages:\n  robot: {use: toy.robot}")
    graph = load(text)
    assert not graph.is_live
    assert graph.notices == (
        "'queues' is not used in lockstep: there every complete set of inputs fires",
        "'outputs' is not used in lockstep: there nothing leaves the run",
    )
    assert graph.node("guard").every_ms == 50


INDEPENDENT = """\
inputs:
  left.image: {{channel: LEFT, type: graphnav_lcm.image_t}}
  {other}.picture: {{channel: RIGHT, type: graphnav_lcm.image_t}}
stages:
  one: {{use: toy.matcher, in: {{image: left.image}}}}
  two: {{use: toy.matcher, in: {{image: {other}.picture}}{every}}}
  both: {{use: toy.mix, in: {{first: one.flow, second: two.flow}}}}
  plane: {{use: toy.detector, in: {{flow: both.flow}}}}
"""


def test_independent_senders_that_meet_are_told_once(load: Load) -> None:
    (notice,) = load(INDEPENDENT.format(other="right", every="")).notices
    assert notice == (
        "stage 'both' (toy.mix) joins independent senders, whose stamps are never equal, so that it never fires: "
        "'first' comes from the input 'left'; 'second' comes from the input 'right'; "
        "read all but one as Latest or Since"
    )


def test_two_inputs_of_one_sender_may_meet(load: Load) -> None:
    assert load(INDEPENDENT.format(other="left", every="")).notices == ()


def test_a_timer_stamps_on_its_own(load: Load) -> None:
    (notice,) = load(INDEPENDENT.format(other="left", every=", every_ms: 50")).notices
    assert "'first' comes from the input 'left'; 'second' comes from the timer 'two'" in notice


def test_a_sampled_input_may_mix_a_source_with_an_input(load: Load) -> None:
    text = LIVE.replace("motion: base.motion", "motion: robot.motion").replace(
        "stages:", "stages:\n  robot: {use: toy.robot}"
    )
    assert [node.name for node in load(text).sources] == ["robot"]


def test_a_diamond_of_many_joins_is_followed_fast(load: Load) -> None:
    lines = [LIVE[: LIVE.index("stages:")] + "stages:", "  m0: {use: toy.matcher, in: {image: camera}}"]
    lines += [f"  m{k}: {{use: toy.mix, in: {{first: m{k - 1}, second: m{k - 1}}}}}" for k in range(1, 60)]
    assert len(load("\n".join(lines)).order) == 60


def test_a_broken_input_is_told_once(load: Load) -> None:
    with pytest.raises(UserError) as caught:
        load(LIVE.replace("graphnav_lcm.image_t", "graphnav_lcm.imag_t"))
    assert len(caught.value.problems) == 1


GUARDED = """\
inputs:
  camera.image: {channel: CAMERA, type: graphnav_lcm.image_t}
  base.odometry: {channel: ODOMETRY, type: graphnav_lcm.odometry_t}
  operator.twist: {channel: TELEOP, type: graphnav_lcm.twist_t}
stages:
  flow: {use: toy.matcher, in: {image: camera.image}}
  motion: {use: odometry.motion, in: {flow: flow.flow, odometry: base.odometry}}
  plane: {use: toy.detector, in: {flow: flow.flow}}
  wheels: {use: toy.wheels, in: {plane: plane.plane}}
  guard:
    use: control.guard
    every_ms: 50
    in: {command: wheels.twist, plane: plane.plane, flow: flow.flow, motion: motion.motion, odometry: motion.check}
outputs: {guard.twist: {channel: BASE, motor: true}}
"""
UNNOTICED = "the guard 'guard' (control.guard) of the motor output 'guard.twist' cannot notice "
FROZEN = f"{UNNOTICED}a picture that freezes, since its 'flow' is not wired: write in: {{flow: flow.flow}}"
ODOMETRY = f"{UNNOTICED}odometry that contradicts the picture, since its 'odometry' is not wired: "


@pytest.mark.parametrize(
    ("wired", "instead", "told"),
    [
        ("", "", []),
        ("flow: flow.flow, motion: motion.motion", "motion: motion.motion", [FROZEN]),
        (", odometry: motion.check", "", [f"{ODOMETRY}write in: {{odometry: motion.check}}"]),
        ("flow: flow.flow, motion: motion.motion, odometry: motion.check", "image: camera.image", [FROZEN]),
        ("motor: true", "motor: false", []),
        (
            "command: wheels.twist, plane: plane.plane, flow: flow.flow, motion: motion.motion, odometry: motion.check",
            "command: operator.twist",
            [],
        ),
    ],
    ids=["all", "no flow", "no odometry check", "a picture alone, no odometry behind", "no motor", "operator alone"],
)
def test_what_a_guard_cannot_notice_is_told(load: Load, wired: str, instead: str, told: list[str]) -> None:
    text = GUARDED.replace(wired, instead) if wired else GUARDED
    assert list(load(text).notices) == told


def test_without_a_stage_that_writes_what_a_guard_lacks_it_is_told_where_to_look(load: Load) -> None:
    text = """\
inputs:
  seen.plane: {channel: PLANE, type: graphnav_lcm.plane_t}
stages:
  wheels: {use: toy.wheels, in: {plane: seen.plane}}
  guard: {use: control.guard, every_ms: 50, in: {command: wheels.twist, plane: seen.plane}}
outputs: {guard.twist: {channel: BASE, motor: true}}
"""
    (notice,) = load(text).notices
    where = "wire a stage that writes Flow: 'graphnav stages Flow' lists them"
    assert notice == FROZEN.replace("write in: {flow: flow.flow}", where)
