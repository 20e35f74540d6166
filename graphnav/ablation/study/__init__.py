"""What a study asks: its file or command line, axes, seeds, metrics."""
