"""Play logs: publish their messages in real time, faster, or step by step."""

from graphnav.player.motor_channels import motor_channels
from graphnav.player.playback_clock import PlaybackClock
from graphnav.player.player import Player
from graphnav.player.select_events import EventSelection, select_events

__all__ = ["EventSelection", "PlaybackClock", "Player", "motor_channels", "select_events"]
