"""Runs in several processes: stages in children, which are watched over, restarted, and ended with the run."""

COMMANDS = {
    "ps": "list the runs that are running, and the processes of their stages",
    "logs": "print what a running or ended run printed",
    "stop": "end a run that is running",
    "set": "set parameters of stages of a running run",
    "swap": "swap stages of a running run",
    "restart": "restart a stage of a running run",
    "up": "start the hosts of a graph over ssh, run it here, and end all together",
    "tunnel": "join the LCM group of another host with this one's, channel by channel",
    "deploy": "write units with which systemd or Docker Compose keep a live graph running",
}
"""Every command of this room and its help; ``main`` of ``commands/<command>.py`` is the `Command`."""
LINUX_COMMANDS = tuple(COMMANDS)
"""Those that work on Linux only."""
