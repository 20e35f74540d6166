"""Stages of the family ``world``."""
