"""One run of a study, made in a process of its own."""
