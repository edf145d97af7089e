"""How accurate skeletons and detected events are."""
