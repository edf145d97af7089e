"""Calibration: the human timing model fitted to recorded groups."""
