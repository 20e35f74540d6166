"""Record a run in a folder: log, graph, summary."""
