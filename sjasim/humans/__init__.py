"""Dancers: when they really move, how cues become motion, and the body that performs it."""
