"""Separate two mixtures: independent component analysis."""
