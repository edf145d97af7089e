"""Events (starts, stops, claps) from skeletons."""
