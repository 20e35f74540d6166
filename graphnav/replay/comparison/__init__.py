"""Compare what a replay published with the log."""
