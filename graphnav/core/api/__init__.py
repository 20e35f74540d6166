"""The Python interface for notebooks and scripts; `graphnav` exports its names."""
