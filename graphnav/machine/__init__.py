"""Properties of the machine: threads, sockets, terminal, Java, installed packages."""
