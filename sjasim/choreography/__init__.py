"""Dances as scores in beats over a tempo map, and where everyone stands; one file per dance."""
