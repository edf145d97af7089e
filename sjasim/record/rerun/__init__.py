"""Sessions as rerun recordings, reading them back, and the viewer."""
