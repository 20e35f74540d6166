"""Large LCM messages, sent packet by packet with a gap by a process of its own.

A message above one packet leaves liblcm as a burst; a stock receive buffer (212,992 bytes) holds three of its packets.
`graphnav.core.large_messages.sender` is the side of the program that sends.
"""

from graphnav.core.exports import exports

__getattr__, __dir__ = exports(__name__, __file__)
