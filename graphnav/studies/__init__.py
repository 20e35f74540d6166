"""Studies: swap stages and conditions, repeat over seeds, compare with statistics; tune rivals with one budget."""

COMMANDS = {
    "ablate": "swap stages and conditions, repeat over seeds, compare with statistics",
    "tune": "search the parameters of rivals, the same budget for each, in worlds for tuning",
}
"""Every command of this room and its help; ``main`` of ``commands/<command>.py`` is the `Command`."""
