"""Registers the ids; from a clone that is not installed it also puts their package on the path."""

import sjasim  # noqa: F401
