"""Loaded before any test: the package chooses an offscreen OpenGL, which must precede MuJoCo's own choice."""

import sjasim  # noqa: F401
