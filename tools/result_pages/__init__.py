"""The pages of docs/results: their generated tables, and the checks of what their sentences say."""
