"""Channels of another host's LCM group on this one's, and back, over one connection (`host_link`)."""

PORT = 7668
"""The TCP port on which the end that serves waits."""
