"""What a recorded log offers a replay."""
