"""Render the camera image with exact ground truth."""
