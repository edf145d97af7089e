"""What a recorded session says: measures per session, statistics per study, pictures, reports."""
