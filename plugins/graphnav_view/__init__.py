"""Stages of the family ``view``."""
