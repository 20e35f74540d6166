"""Channels of another host's LCM group on this one's, and back, over one connection (`host_link`)."""
