"""The commands of runs that are running."""
