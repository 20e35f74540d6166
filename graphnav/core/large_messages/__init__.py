"""Large LCM messages, sent packet by packet with a gap by a process of its own.

A message above one packet leaves liblcm as a burst; a stock receive buffer (212,992 bytes) holds three of its packets.
`graphnav.core.large_messages.sender` is the side of the program that sends.
"""
