"""Summarise a log: channels, rates, losses, origin, damage."""

from graphnav.loginfo.info_json import as_json
from graphnav.loginfo.info_text import as_text
from graphnav.loginfo.log_origin import LogOrigin
from graphnav.loginfo.survey import ChannelInfo, LogInfo, survey
from graphnav.loginfo.unfinished import unfinished

__all__ = ["ChannelInfo", "LogInfo", "LogOrigin", "as_json", "as_text", "survey", "unfinished"]
