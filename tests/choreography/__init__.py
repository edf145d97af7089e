"""Tests of dances and layouts."""
