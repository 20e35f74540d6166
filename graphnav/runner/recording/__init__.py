"""Runs that leave a folder: log, graph, summary."""
