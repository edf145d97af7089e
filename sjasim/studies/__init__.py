"""Sessions run for their figures: one session with its outputs, the accuracy of the components, computing times."""
