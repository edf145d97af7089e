"""Fitting the human timing model to recorded groups."""
