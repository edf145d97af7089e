"""Detection of events in recorded joints of real or simulated sensors."""
