"""What stands on the floor: prisms, outlines, moving obstacles."""
