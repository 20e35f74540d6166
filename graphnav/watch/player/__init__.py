"""Play logs: publish their messages in real time, faster, or step by step."""

from graphnav.watch.player.motor_channels import motor_channels
from graphnav.watch.player.playback_clock import PlaybackClock
from graphnav.watch.player.player import Player
from graphnav.watch.player.select_events import EventSelection, select_events

__all__ = ["EventSelection", "PlaybackClock", "Player", "motor_channels", "select_events"]
