"""What a person sees of a run: its folder, its table, its pictures."""
