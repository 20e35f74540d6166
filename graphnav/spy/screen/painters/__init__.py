"""Painters: draw a picture into the terminal by blocks, sixels or kitty's protocol."""
