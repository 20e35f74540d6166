"""Export scalars to CSV and Parquet tables."""
