"""Stages of the family ``score``."""
