"""Anticipation methods, which decide when the robot moves, one file per method, and the synchrony equations."""
