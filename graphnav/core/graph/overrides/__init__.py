"""Overrides: swap and add stages, set parameters and wires, rewire and prune."""
