"""Entries: the content of a run for viewers, independent of the file format."""
