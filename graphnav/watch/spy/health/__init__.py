"""The health of runs, from `graphnav.status`, as text and JSON."""
