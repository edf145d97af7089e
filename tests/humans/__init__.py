"""Tests of the human model."""
