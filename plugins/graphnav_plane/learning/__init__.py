"""The learned detector: what it looks at, the network, and its file."""
