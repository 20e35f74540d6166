"""Stages of the family ``planar``."""
