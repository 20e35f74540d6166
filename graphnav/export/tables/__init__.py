"""Scalars as CSV and Parquet tables."""
