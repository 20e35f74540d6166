"""A two-wheeled base in MuJoCo: velocity-controlled wheels that roll on the floor by friction, and a caster."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from graphnav_world.geometry.movers import Mover, Walker
from graphnav_world.slip import Slip
from graphnav_world.vehicle import FARTHEST_M, SUBSTEP_S, Base, Limits, Pose, towards, within

from graphnav.arrays import Doubles
from graphnav_mujoco import engine
from graphnav_mujoco.model import BODY, TIMESTEP_S, Chassis

SETTLE_S = 1.0
"""Before the start the base comes to rest on the springs of its contacts."""


class TwoWheels:
    """A differential drive with inertia, of which the floor only sees the forces of its tyres.

    The set speed of each wheel follows the command within the limits of the drive, as `Vehicle` follows it; a motor
    turns the wheel at that speed with a time constant of 20 ms, and friction moves the base. So it is late, slides a
    little in bends, and pitches a little when it brakes. Odometry measures the wheels. With a ``slip`` the set speeds
    are less by it, and the wheels' readings are not.

    Physics steps of at most 2 ms; the first contact of the hull with a body stops it permanently.
    """

    def __init__(
        self,
        model: Any,
        start: tuple[float, float, float],
        movers: tuple[Mover, ...],
        limits: Limits,
        chassis: Chassis,
        slip: Slip | None = None,
    ) -> None:
        self._mujoco = mujoco = engine.load()
        self.movers = movers
        self._walkers = [mover for mover in movers if isinstance(mover, Walker)]
        self._model, self.data = model, mujoco.MjData(model)
        self._limits, self._slip, self._chassis = limits, slip, chassis
        self._hull = model.geom("hull").id
        is_hull = (model.geom_user[:, 0] == BODY) & (model.geom_conaffinity > 0)
        self._others = np.flatnonzero(is_hull)
        self._reach_m = model.geom_rbound[self._others] + chassis.radius_m
        self._time_s = 0.0
        self._set = (0.0, 0.0)
        self._lost = (0.0, 0.0)
        self._contact = False
        x, y, yaw = start
        self.data.qpos[:7] = x, y, 0.0, math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2)
        self._move_bodies()
        model.opt.timestep = TIMESTEP_S
        mujoco.mj_step(model, self.data, round(SETTLE_S / TIMESTEP_S))
        # it has settled by less than a millimetre, but starts where the map says
        self.data.qpos[:2] = x, y
        self.data.qvel[:] = 0.0
        mujoco.mj_forward(model, self.data)
        self._rest_z_m = float(self.data.qpos[2])
        # at rest the contacts give way by different lengths: what leans then is the zero of the mast
        self._upright_R: Doubles = self._axes().T @ planar_base(x, y, self._yaw())[1]
        self._wheels = (x, y, yaw)
        self._here_m = self._clearance_m = self._find_nearest_m()

    @property
    def base(self) -> tuple[Doubles, Doubles]:
        """The base's frame: its origin in W, at rest on the floor, and its axes, which pitch and roll."""
        body = self._model.body("base").id
        origin = self.data.xpos[body] - (0.0, 0.0, self._rest_z_m)
        return origin, self._axes() @ self._upright_R

    def _axes(self) -> Doubles:
        axes: Doubles = self.data.xmat[self._model.body("base").id].reshape(3, 3)
        return axes

    def _yaw(self) -> float:
        axes = self._axes()
        return math.atan2(axes[1, 0], axes[0, 0])

    @property
    def pose(self) -> Pose:
        """The current pose; its clearance is the minimum during the last `advance`."""
        origin, _ = self.base
        yaw = self._yaw()
        v_x, v_y = self.data.qvel[:2].tolist()
        v = v_x * math.cos(yaw) + v_y * math.sin(yaw)
        return Pose(float(origin[0]), float(origin[1]), yaw, v, float(self.data.qvel[5]), self._clear_m, self._contact)

    @property
    def wheels(self) -> Pose:
        """Pose and speeds by the angles of the wheels, from the start on."""
        x, y, yaw = self._wheels
        v, omega = self._rolled()
        return Pose(x, y, math.remainder(yaw, 2 * math.pi), v, omega, self._clear_m, self._contact)

    @property
    def _clear_m(self) -> float:
        return 0.0 if self._contact else self._clearance_m

    def advance(self, v_mps: float, omega_radps: float, until_s: float) -> Pose:
        """Drive towards a command until a time; return the pose then, or where the first contact was."""
        steps = max(1, math.ceil((until_s - self._time_s) / SUBSTEP_S - 1e-9))
        begin_s, dt_s = self._time_s, (until_s - self._time_s) / steps
        self._clearance_m = self._here_m
        wanted = within(v_mps, self._limits.speed_mps), within(omega_radps, self._limits.turn_radps)
        for k in range(steps):
            if self._contact:
                break
            self._step(wanted, begin_s + k * dt_s, dt_s)
            self._here_m = self._find_nearest_m()
            self._clearance_m = min(self._clearance_m, self._here_m)
        self._time_s = until_s
        return self.pose

    def _step(self, wanted: tuple[float, float], begin_s: float, dt_s: float) -> None:
        """Drive for at most 10 ms with one set speed of each wheel."""
        limits, data = self._limits, self.data
        for walker in self._walkers:
            walker.see(begin_s, tuple(data.qpos[:2].tolist()), tuple(data.qvel[:2].tolist()))
        v = towards(self._set[0], wanted[0], limits.speed_mps * (dt_s / limits.speed_up_s))
        omega = towards(self._set[1], wanted[1], limits.turn_radps * (dt_s / limits.turn_up_s))
        self._set = v, omega
        if self._slip is not None:
            v, omega = self._slip.roll(v, omega, dt_s)
            self._lost = self._set[0] - v, self._set[1] - omega
        half_m = self._chassis.track_m / 2
        data.ctrl[:] = (v - omega * half_m) / self._chassis.wheel_m, (v + omega * half_m) / self._chassis.wheel_m
        n = max(1, math.ceil(dt_s / TIMESTEP_S - 1e-9))
        self._model.opt.timestep = dt_s / n
        for k in range(n):
            self._time_s = begin_s + (k + 1) * dt_s / n
            self._move_bodies()
            self._mujoco.mj_step(self._model, data)
            self._reckon(dt_s / n)
            if self._touches():
                self._contact = True
                return

    def _move_bodies(self) -> None:
        for k, mover in enumerate(self.movers):
            self.data.mocap_pos[k] = *mover.at(self._time_s), 0.0

    def _rolled(self) -> tuple[float, float]:
        """Return the speeds (m/s, rad/s) by those of the wheels, with what slip takes."""
        left, right = (self._chassis.wheel_m * self.data.qvel[6:8]).tolist()
        v, omega = (left + right) / 2, (right - left) / self._chassis.track_m
        return v + self._lost[0], omega + self._lost[1]

    def _reckon(self, dt_s: float) -> None:
        (x, y, yaw), (v, omega) = self._wheels, self._rolled()
        midway = yaw + omega * dt_s / 2
        self._wheels = x + v * dt_s * math.cos(midway), y + v * dt_s * math.sin(midway), yaw + omega * dt_s

    def _touches(self) -> bool:
        contacts = self.data.contact
        return self.data.ncon > 0 and bool((contacts.geom == self._hull).any())

    def _find_nearest_m(self) -> float:
        """Return the distance from the hull to the nearest body, 1000 m if there is none.

        Bodies are asked in the order of the distances of the spheres around them, until one cannot be nearer.
        """
        if not len(self._others):
            return FARTHEST_M
        away = self.data.geom_xpos[self._others, :2] - self.data.geom_xpos[self._hull, :2]
        bound = np.hypot(away[:, 0], away[:, 1]) - self._reach_m
        nearest = FARTHEST_M
        ends: Doubles = np.zeros(6)
        for k in np.argsort(bound).tolist():
            if bound[k] >= nearest:
                break
            found = self._mujoco.mj_geomDistance(
                self._model, self.data, self._hull, int(self._others[k]), nearest, ends
            )
            nearest = min(nearest, float(found))
        return max(nearest, 0.0)


class Carried:
    """A base that another one drives, upright, and that a model of MuJoCo only shows."""

    def __init__(self, model: Any, driver: Base) -> None:
        self._mujoco = mujoco = engine.load()
        self.movers = driver.movers
        self._model, self._driver, self.data = model, driver, mujoco.MjData(model)
        self._show(driver.pose)

    @property
    def base(self) -> tuple[Doubles, Doubles]:
        """The base's frame: its origin in W, on the floor, and its axes."""
        pose = self._driver.pose
        return planar_base(pose.x_m, pose.y_m, pose.yaw_rad)

    @property
    def pose(self) -> Pose:
        """The driver's pose."""
        return self._driver.pose

    @property
    def wheels(self) -> Pose:
        """The driver's pose by its wheels."""
        return self._driver.wheels

    def advance(self, v_mps: float, omega_radps: float, until_s: float) -> Pose:
        """Drive as the driver does, and show where that is."""
        pose = self._driver.advance(v_mps, omega_radps, until_s)
        self._show(pose)
        return pose

    def _show(self, pose: Pose) -> None:
        half = pose.yaw_rad / 2
        self.data.qpos[:7] = pose.x_m, pose.y_m, 0.0, math.cos(half), 0.0, 0.0, math.sin(half)
        self._mujoco.mj_forward(self._model, self.data)


def planar_base(x_m: float, y_m: float, yaw_rad: float) -> tuple[Doubles, Doubles]:
    """Return a base that stands upright at a pose, as `TwoWheels.base`."""
    c, s = math.cos(yaw_rad), math.sin(yaw_rad)
    return np.array([x_m, y_m, 0.0]), np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def positions(movers: Sequence[Mover], time_s: float) -> Doubles:
    """Return x and y of moving bodies at a time, (bodies, 2)."""
    return np.array([mover.at(time_s) for mover in movers], float).reshape(-1, 2)
