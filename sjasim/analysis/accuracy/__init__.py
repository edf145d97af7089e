"""Accuracy of skeletons and of detected events, over many sessions."""
