"""Logs for notebooks: messages, arrays and tables."""
