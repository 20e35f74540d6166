"""Geometry of bodies on the floor: prisms, outlines, moving obstacles."""
