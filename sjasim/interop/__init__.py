"""Bridges to other simulation packages; nothing else in sjasim needs them."""
