"""Panels of one frame: image, flow, dominant plane, potential, force, scene."""
