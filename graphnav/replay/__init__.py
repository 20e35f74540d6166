"""Replay a log: play its sources, step the stages of its graph again, compare their messages with the recorded ones."""

COMMANDS = {
    "replay": "step the stages of a recorded run again, with swaps, and compare with the recorded messages",
}
"""Every command of this room and its help; ``main`` of ``commands/<command>.py`` is the `Command`."""
