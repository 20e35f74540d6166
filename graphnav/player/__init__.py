"""Playing logs: their messages go out again when they came, or faster, or step by step."""

from graphnav.player.choose import Chosen, choose
from graphnav.player.motor_channels import motor_channels
from graphnav.player.pace import Pace
from graphnav.player.player import Player

__all__ = ["Chosen", "Pace", "Player", "choose", "motor_channels"]
