"""Imports sjasim, which registers the environments' ids and, in a clone that is not installed, finds their package."""

import sjasim  # noqa: F401
