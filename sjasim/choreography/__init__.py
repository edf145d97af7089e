"""Dances as scores in beats, their timetables in seconds, and the floor layout; one file for each dance.

To add a dance, add a file here with a function that is registered under the kind ``choreography`` and returns a
`score.Choreography`; ``march.py`` is the shortest example.
"""
