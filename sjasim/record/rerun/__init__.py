"""Sessions as rerun recordings, and reading these."""
