"""History of one obstacle of a drive: visible, sighted, reacted to."""

from __future__ import annotations

from dataclasses import dataclass

from graphnav import Twist


@dataclass(frozen=True)
class Seen:
    """An obstacle from the robot: distance from the rim, whether it is ahead, and whether to the left."""

    distance_m: float
    is_ahead: bool
    is_left: bool


@dataclass
class ObstacleHistory:
    """History of one obstacle; an event is None until it happened.

    Parameters
    ----------
    visible_m
        Distance at which it was visible first.
    nearest_m
        Minimum distance since.
    """

    visible_m: float
    nearest_m: float
    sighted: Seen | None = None
    sighted_s: float = 0.0
    command: Twist | None = None
    reaction_s: float | None = None

    def sight(self, seen: Seen, command: Twist | None, time_s: float) -> None:
        """Count a sighting, of which the first matters; ``command``: the one that the robot then follows."""
        if self.sighted is None:
            self.sighted, self.command, self.sighted_s = seen, command, time_s

    def react(self, command: Twist | None, time_s: float, min_turn_radps: float, min_slowing_ratio: float) -> None:
        """Count a command, of which the first that turns away or slows down after the sighting matters."""
        if self.sighted is None or self.command is None or command is None or self.reaction_s is not None:
            return
        turn_radps = command.omega_radps - self.command.omega_radps
        turns_away = (-turn_radps if self.sighted.is_left else turn_radps) >= min_turn_radps
        slows = self.command.v_mps > 0 and command.v_mps <= (1 - min_slowing_ratio) * self.command.v_mps
        if turns_away or slows:
            self.reaction_s = time_s - self.sighted_s
