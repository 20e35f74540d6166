"""Watch a feed or a log: channels, their newest messages, series."""
