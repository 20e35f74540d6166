"""The fields of messages by name: paths, columns, selections, plain values."""
