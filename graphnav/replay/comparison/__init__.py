"""Compare the messages of a replay with the log."""
