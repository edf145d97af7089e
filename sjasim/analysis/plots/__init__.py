"""Figures of sessions as pictures: events of all iterations, the robot's timing, topology graphs, delays by part."""
