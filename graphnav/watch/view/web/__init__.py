"""The web server of the page: files over HTTP, updates over a WebSocket."""
