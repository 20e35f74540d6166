"""Graphs, maps and planar models that ship."""
