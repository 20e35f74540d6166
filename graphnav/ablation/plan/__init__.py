"""A checked study: every graph with every variant, loaded before anything runs."""
