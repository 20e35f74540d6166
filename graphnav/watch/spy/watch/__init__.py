"""Watch a feed or a log: channels, newest messages, series of numbers."""
