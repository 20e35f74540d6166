"""The fields of messages: paths, columns, summaries, trees."""
