"""Watch running graphs and logs: the terminal, the page, viewers of others; record, play and export."""

COMMANDS = {
    "figure": "redraw the pictures of a recorded run: panels, single frames, a contact sheet",
    "export": "write a log as video, pictures, tables, or a file for Foxglove or Rerun",
    "merge": "merge the logs of several computers on one time line, with their clocks measured",
    "record": "record LCM channels into a self-describing log",
    "play": "publish the messages of a log again: faster, slower, paused, step by step",
    "info": "describe a log: channels, types, rates, losses, damage, the graph that produced it",
    "spy": "show the channels of a running graph or a log",
    "echo": "print the messages of one channel, arrays summarised",
    "hz": "measure the rate of a channel, or of all",
    "bw": "measure the bandwidth of a channel, or of all, and the sizes of messages",
    "top": "show the health of running graphs: rates, latencies, drops, state of the guard",
    "view": "serve a page, or Foxglove, that shows a running graph or a log",
}
"""Every command of this room and its help; ``main`` of ``commands/<command>.py`` is the `Command`."""
