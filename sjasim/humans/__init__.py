"""Simulated dancers: when they move (`timing`), how they move (`motion`), and the body that moves (`body`)."""
