"""Training of the skeleton model, from the project's own bodies and motions; only scripts and tests use it."""
