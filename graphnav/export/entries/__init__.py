"""Entries: what every viewer takes of a run, whatever its file format."""
