"""Summarise a log: channels, rates, losses, origin, damage."""

from graphnav.watch.loginfo.info_json import as_json
from graphnav.watch.loginfo.info_text import as_text
from graphnav.watch.loginfo.log_origin import LogOrigin
from graphnav.watch.loginfo.survey import ChannelInfo, LogInfo, survey
from graphnav.watch.loginfo.unfinished import unfinished

__all__ = ["ChannelInfo", "LogInfo", "LogOrigin", "as_json", "as_text", "survey", "unfinished"]
