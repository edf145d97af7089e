"""Simulated sensors and their clients: skeletons from depth images or true joints, and motion events from skeletons."""
