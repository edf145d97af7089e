"""Training and evaluation of the skeleton model on the project's own bodies and motions, for scripts and tests."""
