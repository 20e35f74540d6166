"""Files that are complete or absent, and whose first write error is kept."""
