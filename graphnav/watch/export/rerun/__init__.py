"""Export to Rerun: recordings with a blueprint."""
