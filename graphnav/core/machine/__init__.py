"""The machine: its instruction set, threads, files, sockets, terminal, Java, installed packages."""
