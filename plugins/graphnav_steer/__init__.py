"""Stages of the family ``steer``."""
