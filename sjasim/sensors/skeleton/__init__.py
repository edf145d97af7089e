"""Skeletons from depth images."""
