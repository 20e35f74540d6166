"""Ablations: swap, repeat over seeds, compare with statistics."""
