"""The world from above, with the paths of robots."""
