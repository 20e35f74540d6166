"""Record the messages of a multicast group to a log, and count losses."""

from graphnav.watch.recorder.channel_statistics import ReceiveStatistics
from graphnav.watch.recorder.receive_buffer import buffer_notice
from graphnav.watch.recorder.recorder import Recorder

__all__ = ["ReceiveStatistics", "Recorder", "buffer_notice"]
