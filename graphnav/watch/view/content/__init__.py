"""The content of the page as JSON-compatible values."""
