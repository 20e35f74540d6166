"""The video of a run: tiles side by side, frame by frame."""
