"""Render what the camera sees, with the exact truth."""
