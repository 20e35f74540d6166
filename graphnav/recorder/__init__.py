"""Recording: what is heard on a multicast group goes into a log, and what is lost is counted."""

from graphnav.recorder.receive_buffer import buffer_notice
from graphnav.recorder.recorder import Recorder
from graphnav.recorder.tally import ChannelTally, Tally

__all__ = ["ChannelTally", "Recorder", "Tally", "buffer_notice"]
