"""Runs in several processes: stages in children, which are watched over, restarted, and ended with the run."""

COMMANDS: dict[str, str] = {}
"""Every command of this room and its help; ``main`` of ``commands/<command>.py`` is the `Command`."""
