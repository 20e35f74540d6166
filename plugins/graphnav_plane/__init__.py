"""Stages of the family ``plane``."""
