"""What a log holds, who made it, and what of it is damaged."""

from graphnav.loginfo.as_json import as_json
from graphnav.loginfo.as_text import as_text
from graphnav.loginfo.made_by import MadeBy
from graphnav.loginfo.survey import ChannelInfo, LogInfo, survey

__all__ = ["ChannelInfo", "LogInfo", "MadeBy", "as_json", "as_text", "survey"]
