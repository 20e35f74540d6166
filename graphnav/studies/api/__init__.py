"""Studies for notebooks and for ``graphnav ablate``."""
