"""Encode and decode the messages of a navigation graph by hand: `struct`, numpy and one function a type.

What a user of python-lcm writes who knows that lcm-gen's own Python moves arrays number by number. Each ``put_``
function returns the bytes of a message and checks that its floats are finite; each ``take_`` function returns the
timestamp and the message.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from struct import Struct
from typing import Any

import graphnav_lcm as types
import numpy as np

from graphnav import Flow, FlowDeviation, Image, Motion, Planar, Plane, State, Steering, Truth, Twist

Put = Callable[[int, int, Any], bytes]
Take = Callable[[bytes], tuple[int, Any]]

IMAGE = Struct(">8sqqiiiii")
MOTION = Struct(">8sqqqddd")
STATE = Struct(">8sqqddddddbbi")
TRUTH = Struct(">8sqqqiii")
TWO_DOUBLES = Struct(">8sqqdd")
FLOW = Struct(">8sqqqiii")
PLANE = Struct(">8sqqiddbii")
STEERING = Struct(">8sqq" + 9 * "d")
POTENTIAL = Struct(">8sqqiii")
GUARD_STATE = Struct(">8sqqbbbbi")
LENGTH = Struct(">i")

IMAGE_ID, MOTION_ID, STATE_ID, TRUTH_ID, GOAL_ID, FLOW_ID, PLANAR_ID, PLANE_ID, STEERING_ID, POTENTIAL_ID = (
    lcm_class._get_packed_fingerprint()  # noqa: SLF001 - lcm-gen's only name for it
    for lcm_class in (
        types.image_t,
        types.motion_t,
        types.state_t,
        types.truth_t,
        types.goal_t,
        types.flow_t,
        types.planar_t,
        types.plane_t,
        types.steering_t,
        types.potential_t,
    )
)
TWIST_ID = types.twist_t._get_packed_fingerprint()  # noqa: SLF001
FLOW_DEVIATION_ID = types.flow_deviation_t._get_packed_fingerprint()  # noqa: SLF001
GUARD_STATE_ID = types.guard_state_t._get_packed_fingerprint()  # noqa: SLF001


def check(*values: float) -> None:
    """Raise ValueError unless the sum of scalars is finite."""
    if not math.isfinite(sum(values)):
        raise ValueError("a value is not finite")


def check_array(array: Any) -> None:
    """Raise ValueError unless the sum of an array is finite."""
    if not math.isfinite(array.sum()):
        raise ValueError("a value is not finite")


def wire(array: Any) -> bytes:
    """Return an array of 4-byte floats in big-endian order."""
    data: bytes = array.astype(">f4").tobytes()
    return data


def floats(data: bytes, at: int, *shape: int) -> Any:
    """Return the native array of 4-byte floats at an offset."""
    return np.frombuffer(data, ">f4", math.prod(shape), at).astype("f4").reshape(shape)


def doubles(data: bytes, at: int, *shape: int) -> Any:
    """Return the native array of 8-byte floats at an offset."""
    return np.frombuffer(data, ">f8", math.prod(shape), at).astype("f8").reshape(shape)


def raw(array: Any) -> bytes:
    """Return the memory of an array."""
    data: bytes = array.tobytes()
    return data


def octets(data: bytes, at: int, *shape: int) -> Any:
    """Return the bytes at an offset as an array."""
    return np.frombuffer(data, "u1", math.prod(shape), at).reshape(shape)


def put_image(utime: int, seq: int, m: Any) -> bytes:
    """Encode a gray image."""
    rows, cols = m.pixels.shape
    return IMAGE.pack(IMAGE_ID, utime, seq, m.step_px, rows, cols, 1, rows * cols) + raw(m.pixels)


def take_image(data: bytes) -> tuple[int, Any]:
    """Decode a gray image."""
    _, utime, _, step_px, rows, cols, _, _ = IMAGE.unpack_from(data)
    return utime, Image(pixels=octets(data, IMAGE.size, rows, cols), step_px=step_px)


def put_motion(utime: int, seq: int, m: Any) -> bytes:
    """Encode a motion."""
    check(m.forward_m, m.left_m, m.turn_rad)
    return MOTION.pack(MOTION_ID, utime, seq, m.interval_us, m.forward_m, m.left_m, m.turn_rad)


def take_motion(data: bytes) -> tuple[int, Any]:
    """Decode a motion."""
    _, utime, _, interval_us, forward_m, left_m, turn_rad = MOTION.unpack(data)
    return utime, Motion(forward_m=forward_m, left_m=left_m, turn_rad=turn_rad, interval_us=interval_us)


def put_state(utime: int, seq: int, m: Any) -> bytes:
    """Encode the simulated robot's state."""
    check(m.x_m, m.y_m, m.yaw_rad, m.v_mps, m.omega_radps, m.clearance_m)
    check_array(m.moving)
    scalars = m.x_m, m.y_m, m.yaw_rad, m.v_mps, m.omega_radps, m.clearance_m, m.contact, m.at_goal
    return STATE.pack(STATE_ID, utime, seq, *scalars, len(m.moving)) + raw(m.moving.astype(">f8"))


def take_state(data: bytes) -> tuple[int, Any]:
    """Decode the simulated robot's state."""
    _, utime, _, x_m, y_m, yaw_rad, v_mps, omega_radps, clearance_m, contact, at_goal, n = STATE.unpack_from(data)
    moving = doubles(data, STATE.size, n, 3)
    return utime, State(x_m, y_m, yaw_rad, v_mps, omega_radps, clearance_m, bool(contact), bool(at_goal), moving)


def put_truth(utime: int, seq: int, m: Any) -> bytes:
    """Encode the simulator's truth; the depth may be infinite."""
    check_array(m.flow_px)
    rows, cols = m.obstacle.shape
    head = TRUTH.pack(TRUTH_ID, utime, seq, m.interval_us, m.step_px, rows, cols)
    return b"".join((head, raw(m.obstacle), wire(m.depth_m), wire(m.flow_px)))


def take_truth(data: bytes) -> tuple[int, Any]:
    """Decode the simulator's truth."""
    _, utime, _, interval_us, step_px, rows, cols = TRUTH.unpack_from(data)
    at, n = TRUTH.size, rows * cols
    obstacle, depth_m = octets(data, at, rows, cols), floats(data, at + n, rows, cols)
    return utime, Truth(obstacle, depth_m, floats(data, at + 5 * n, rows, cols, 2), interval_us, step_px)


def put_goal(utime: int, seq: int, m: Any) -> bytes:
    """Encode a goal."""
    check(m.bearing_rad, m.distance_m)
    return TWO_DOUBLES.pack(GOAL_ID, utime, seq, m.bearing_rad, m.distance_m)


def put_flow(utime: int, seq: int, m: Any) -> bytes:
    """Encode a flow."""
    check_array(m.uv_px)
    rows, cols = m.valid.shape
    head = FLOW.pack(FLOW_ID, utime, seq, m.interval_us, m.step_px, rows, cols)
    return b"".join((head, wire(m.uv_px), raw(m.valid)))


def take_flow(data: bytes) -> tuple[int, Any]:
    """Decode a flow."""
    _, utime, _, interval_us, step_px, rows, cols = FLOW.unpack_from(data)
    uv_px = floats(data, FLOW.size, rows, cols, 2)
    return utime, Flow(uv_px, octets(data, FLOW.size + 8 * rows * cols, rows, cols), interval_us, step_px)


def put_flow_deviation(utime: int, seq: int, m: Any) -> bytes:
    """Encode how far the vectors of a flow are likely to be off."""
    check_array(m.deviation_px)
    rows, cols = m.deviation_px.shape
    return POTENTIAL.pack(FLOW_DEVIATION_ID, utime, seq, m.step_px, rows, cols) + wire(m.deviation_px)


def take_flow_deviation(data: bytes) -> tuple[int, Any]:
    """Decode how far the vectors of a flow are likely to be off."""
    _, utime, _, step_px, rows, cols = POTENTIAL.unpack_from(data)
    return utime, FlowDeviation(floats(data, POTENTIAL.size, rows, cols), step_px)


def put_planar(utime: int, seq: int, m: Any) -> bytes:
    """Encode a planar flow."""
    check_array(m.planar_uv_px)
    check_array(m.residual_px)
    rows, cols = m.planar_valid.shape
    head = FLOW.pack(PLANAR_ID, utime, seq, m.interval_us, m.step_px, rows, cols)
    return b"".join((head, wire(m.planar_uv_px), raw(m.planar_valid), wire(m.residual_px)))


def take_planar(data: bytes) -> tuple[int, Any]:
    """Decode a planar flow."""
    _, utime, _, interval_us, step_px, rows, cols = FLOW.unpack_from(data)
    at, n = FLOW.size, rows * cols
    uv_px, valid = floats(data, at, rows, cols, 2), octets(data, at + 8 * n, rows, cols)
    return utime, Planar(uv_px, valid, floats(data, at + 9 * n, rows, cols), interval_us, step_px)


def put_plane(utime: int, seq: int, m: Any) -> bytes:
    """Encode a dominant plane."""
    check(m.obstacle_ratio, m.threshold)
    check_array(m.score)
    rows, cols = m.valid.shape
    scalars = m.step_px, m.obstacle_ratio, m.threshold, m.converged
    head = PLANE.pack(PLANE_ID, utime, seq, *scalars, rows, cols)
    return b"".join((head, raw(m.obstacle), wire(m.score), raw(m.valid)))


def take_plane(data: bytes) -> tuple[int, Any]:
    """Decode a dominant plane."""
    _, utime, _, step_px, obstacle_ratio, threshold, converged, rows, cols = PLANE.unpack_from(data)
    at, n = PLANE.size, rows * cols
    obstacle, score = octets(data, at, rows, cols), floats(data, at + n, rows, cols)
    valid = octets(data, at + 5 * n, rows, cols)
    return utime, Plane(obstacle, score, valid, step_px, obstacle_ratio, threshold, bool(converged))


def put_steering(utime: int, seq: int, m: Any) -> bytes:
    """Encode a steering."""
    values = *m.repulsive, *m.guiding, *m.control, m.theta_rad, *m.eigenvalues
    check(*values)
    return STEERING.pack(STEERING_ID, utime, seq, *values)


def take_steering(data: bytes) -> tuple[int, Any]:
    """Decode a steering."""
    _, utime, _, *values = STEERING.unpack(data)
    repulsive, guiding, control, eigenvalues = map(np.array, (values[:2], values[2:4], values[4:6], values[7:]))
    return utime, Steering(repulsive, guiding, control, values[6], eigenvalues)


def put_potential(utime: int, seq: int, m: Any) -> bytes:
    """Encode an obstacle potential."""
    check_array(m.potential)
    check_array(m.gradient)
    rows, cols = m.potential.shape
    head = POTENTIAL.pack(POTENTIAL_ID, utime, seq, m.step_px, rows, cols)
    return b"".join((head, wire(m.potential), wire(m.gradient)))


def put_twist(utime: int, seq: int, m: Any) -> bytes:
    """Encode a velocity command."""
    check(m.v_mps, m.omega_radps)
    return TWO_DOUBLES.pack(TWIST_ID, utime, seq, m.v_mps, m.omega_radps)


def take_twist(data: bytes) -> tuple[int, Any]:
    """Decode a velocity command."""
    _, utime, _, v_mps, omega_radps = TWO_DOUBLES.unpack(data)
    return utime, Twist(v_mps, omega_radps)


def put_guard_state(utime: int, seq: int, m: Any) -> bytes:
    """Encode the guard's decision."""
    check_array(m.values)
    check_array(m.limits)
    scalars = m.may_move, m.may_advance, m.overridden, m.stopped, len(m.causes)
    pieces = [GUARD_STATE.pack(GUARD_STATE_ID, utime, seq, *scalars)]
    for text in (*m.causes, *m.ports):
        encoded = text.encode() + b"\0"
        pieces += (LENGTH.pack(len(encoded)), encoded)
    pieces += (m.values.astype(">f8").tobytes(), m.limits.astype(">f8").tobytes())
    return b"".join(pieces)


PUT: dict[str, Put] = {
    "robot.image": put_image,
    "robot.motion": put_motion,
    "robot.state": put_state,
    "robot.truth": put_truth,
    "robot.goal": put_goal,
    "flow.flow": put_flow,
    "flow.deviation": put_flow_deviation,
    "planar.planar": put_planar,
    "plane.plane": put_plane,
    "steer.steering": put_steering,
    "steer.potential": put_potential,
    "control.twist": put_twist,
    "guard.twist": put_twist,
    "guard.state": put_guard_state,
}
"""The encoders by channel; the map, which is published once, is not among them."""

TAKE: dict[str, Take] = {
    "robot.image": take_image,
    "robot.motion": take_motion,
    "robot.state": take_state,
    "robot.truth": take_truth,
    "flow.flow": take_flow,
    "flow.deviation": take_flow_deviation,
    "planar.planar": take_planar,
    "plane.plane": take_plane,
    "steer.steering": take_steering,
    "control.twist": take_twist,
    "guard.twist": take_twist,
}
"""The decoders of the channels that a stage reads."""
