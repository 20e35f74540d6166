"""Inputs of a live run: receive, decode and judge the messages of other programs."""
