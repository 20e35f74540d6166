"""A plugin that cannot be imported."""

raise OSError("no camera")
