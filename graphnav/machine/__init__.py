"""The machine: its threads, sockets, terminal and Java, and the packages that are installed."""
