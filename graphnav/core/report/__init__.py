"""Output of a run: its folder, summary table and pictures."""
