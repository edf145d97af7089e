"""Detection of events (starts, stops and claps) in skeleton frames."""
