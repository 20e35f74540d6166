"""Stages of the family ``flow``."""
