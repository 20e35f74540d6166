"""Estimate the motion of a frame from its flow."""
