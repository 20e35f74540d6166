"""Stages of the family ``io``."""
