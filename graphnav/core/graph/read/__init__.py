"""Read a graph: its file, the files that it extends, its one-file plugins."""
