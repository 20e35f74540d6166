"""Robots, terminals and programs in processes of their own, for long tests and benchmarks."""
