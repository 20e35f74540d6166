"""The parts of ``tools/attack.py``: what is spoiled, by what commands it is read, and how these may come out."""
