"""Read what a replay needs from a log."""
