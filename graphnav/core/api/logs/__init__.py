"""Logs in notebooks: messages, arrays and tables."""
