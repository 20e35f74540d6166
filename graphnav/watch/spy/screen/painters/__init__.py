"""Painters: draw pictures in the terminal by half blocks, sixels or kitty's protocol."""
