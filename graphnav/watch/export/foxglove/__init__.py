"""Export to Foxglove: MCAP files with Foxglove's schemas."""
