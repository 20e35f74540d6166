"""Runs for Foxglove: MCAP files with its own schemas."""
