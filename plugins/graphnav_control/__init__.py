"""Stages of the family ``control``."""
