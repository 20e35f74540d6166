"""Live runs: graphs in wall time, connected to channels of other programs."""

COMMANDS = {
    "teach": "run an obstacle-free graph and save the learned planar model",
    "pub": "publish a message, once or at a rate",
    "base": "pass the commands of a run on to a base on a serial line",
    "teleop": "drive by keyboard: a dead man's twist, and a latching stop",
}
"""Every command of this room and its help; ``main`` of ``commands/<command>.py`` is the `Command`."""
LINUX_COMMANDS = ("pub", "base", "teleop")
"""Those that work on Linux only."""
