"""The tables and the report of a study."""
