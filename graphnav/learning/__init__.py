"""Learning to drive: a graph as a Gymnasium environment, alone or many at a time in worker processes."""

COMMANDS: dict[str, str] = {}
"""Every command of this room and its help: none."""
