"""For authors of stages and graphs: profile, doctor, completion, templates, types."""

COMMANDS = {
    "new-stage": "write a working one-file plugin and its test",
    "schema": "print the JSON Schema of graphs, studies or maps, for completion in editors",
    "profile": "measure where the time of a tick goes: by stage, by channel; a flame graph",
    "types": "list the message types, or describe one; definitions, Java for lcm-spy",
    "lcm-spy": "start lcm-spy of LCM with the types of graphnav",
    "calibrate": "find the lens and the mounting of a camera from pictures of a board; print a board",
    "cameras": "list the cameras of this machine, with their formats, sizes and rates",
    "doctor": "check this machine, and what a graph needs of it; print the commands that fix problems",
    "completion": "print the script that makes bash, zsh or fish complete commands and names with TAB",
}
"""Every command of this room and its help; ``main`` of ``commands/<command>.py`` is the `Command`."""
LINUX_COMMANDS = ("lcm-spy", "cameras", "doctor", "completion")
"""Those that work on Linux only."""
