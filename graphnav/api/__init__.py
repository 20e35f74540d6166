"""The Python door: what notebooks and scripts call; `graphnav` exports its names."""
