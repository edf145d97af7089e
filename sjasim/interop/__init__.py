"""Interfaces to other simulation packages; the rest of sjasim does not need them."""
