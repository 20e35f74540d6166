"""Maps: read a file, draw a world from it, find a way through."""
