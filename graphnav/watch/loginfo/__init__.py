"""Summarise a log: channels, rates, losses, origin, damage."""

from graphnav.watch.loginfo.log_origin import LogOrigin
from graphnav.watch.loginfo.summary import as_json, as_text
from graphnav.watch.loginfo.survey import ChannelInfo, LogInfo, survey, unfinished

__all__ = ["ChannelInfo", "LogInfo", "LogOrigin", "as_json", "as_text", "survey", "unfinished"]
