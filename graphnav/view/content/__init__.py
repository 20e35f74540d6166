"""The content of the page, as JSON can hold it."""
