"""Runs for Rerun: recordings with a blueprint."""
