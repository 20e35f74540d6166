"""A file that is not a plugin."""
