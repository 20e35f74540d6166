"""Acceptance tests that are long or depend on the machine, one module per item."""
