"""Step the stages of a recorded run again."""
